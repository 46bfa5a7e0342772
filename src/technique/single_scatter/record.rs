//! First the depths to the lights, where something changed them; then the march.

use bytemuck::bytes_of;
use glam::UVec3;

use super::{CacheLightPush, ScatterMarchPush, SingleScatter, SingleScatterPlan};
use crate::gpu::{Access, Device, GpuError, Recorder, StageTime};
use crate::technique::Inputs;

/// Invocations a tile.
const TILE_INVOCATIONS: u32 = 64;

/// Brings the light cache up to date; `changed` says what differs from the last frame. One dispatch a
/// light and slab of nodes, each a submission; `progress(done, total)` counts them.
///
/// # Errors
/// The driver's refusal, a lost device, or a validation message.
pub fn record_light_cache(
    device: &Device,
    single_scatter: &mut SingleScatter,
    changed: Inputs,
    progress: &mut dyn FnMut(u64, u64),
) -> Result<Vec<StageTime>, GpuError> {
    let plan = &single_scatter.plan;
    let current = single_scatter.filled && !changed.intersects(SingleScatterPlan::CACHED);
    let (Some(cache), Some((pipeline, binding)), false) =
        (&plan.cache, &single_scatter.light_cache, current)
    else {
        return Ok(Vec::new());
    };
    let name = plan.light_cache().shader.name;
    let spread = spread(plan);
    let (slabs, image) = (cache.submissions(), &single_scatter.light_depth);
    let total = cache.lights * slabs;
    let mut seconds = 0.0;
    for index in 0..total {
        let first_slice = index % slabs * cache.slices_per_submission;
        let slice_count = cache.slices_per_submission.min(cache.nodes.z - first_slice);
        let push = CacheLightPush {
            light: index / slabs,
            first_slice,
            slice_count,
        };
        let mut recorder = Recorder::new(device)?;
        if index == 0 {
            // WAR: the last march has read what is written anew.
            recorder.image_barrier(image, Access::ComputeSampledOrLoaded, Access::ComputeWrite);
        }
        recorder.compute_stage(name, |r| {
            // Whole streams: the shader deals slices out to `spread` of them.
            let slices = slice_count.div_ceil(spread) * spread;
            let domain = UVec3::new(cache.nodes.x, cache.nodes.y, slices);
            r.dispatch(pipeline, binding, bytes_of(&push), domain);
        });
        if index + 1 == total {
            // RAW: the march reads what the slabs wrote.
            recorder.image_barrier(image, Access::ComputeWrite, Access::ComputeSampledOrLoaded);
        }
        seconds += recorder.submit()?.iter().map(|t| t.seconds).sum::<f64>();
        progress(u64::from(index) + 1, u64::from(total));
    }
    single_scatter.filled = true;
    Ok(vec![StageTime {
        name: name.to_owned(),
        seconds,
    }])
}

/// Marches the whole image: one dispatch a band of tiles, sub-sample and range of samples, each a
/// submission; `progress(done, total)` counts them.
///
/// # Errors
/// The driver's refusal, a lost device, or a validation message.
pub fn record_march(
    device: &Device,
    single_scatter: &SingleScatter,
    progress: &mut dyn FnMut(u64, u64),
) -> Result<Vec<StageTime>, GpuError> {
    let plan = &single_scatter.plan;
    let name = plan.march().shader.name;
    let (pipeline, binding) = (&single_scatter.march, &single_scatter.march_binding);
    let spread = spread(plan);
    let [ranges, samples] = plan.ranges;
    let total = plan.bands() * plan.sub_samples * ranges;
    let mut seconds = 0.0;
    for index in 0..total {
        let (band, range) = (index / (plan.sub_samples * ranges), index % ranges);
        let first_tile = band * plan.tiles_per_submission;
        let tile_count = plan.tiles_per_submission.min(plan.tiles - first_tile);
        let push = ScatterMarchPush {
            first_tile,
            tile_count,
            sub_sample: index / ranges % plan.sub_samples,
            first_sample: range * samples,
            end_sample: if range + 1 == ranges {
                u32::MAX
            } else {
                (range + 1) * samples
            },
        };
        let mut recorder = Recorder::new(device)?;
        // RAW and WAW: sub-samples and ranges add to what the ones before wrote.
        recorder.image_barrier(
            &single_scatter.radiance,
            Access::ComputeWrite,
            Access::ComputeReadWrite,
        );
        recorder.compute_stage(name, |r| {
            // Whole streams: the shader deals tiles out to `spread` of them.
            let groups = tile_count.div_ceil(spread) * spread;
            let domain = UVec3::new(groups * TILE_INVOCATIONS, 1, 1);
            r.dispatch(pipeline, binding, bytes_of(&push), domain);
        });
        seconds += recorder.submit()?.iter().map(|t| t.seconds).sum::<f64>();
        progress(u64::from(index) + 1, u64::from(total));
    }
    Ok(vec![StageTime {
        name: name.to_owned(),
        seconds,
    }])
}

fn spread(plan: &SingleScatterPlan) -> u32 {
    let mut constants = plan.march_constants.iter();
    constants
        .find(|s| s.name == "SPREAD")
        .map_or(1, |s| s.value)
}
