//! First the depths to the lights, where something changed them; then the march.

use bytemuck::bytes_of;
use glam::UVec3;

use super::{CacheLightPush, ScatterMarchPush, SingleScatter, SingleScatterPlan};
use crate::gpu::{Access, Device, GpuError, Recorder, StageTime};
use crate::technique::{Inputs, TilePush};

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
            let slices = plan.tiles.whole_streams(slice_count);
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
    let [ranges, samples] = plan.ranges;
    let push = |TilePush {
                    first_tile,
                    tile_count,
                    sub_sample,
                },
                range| ScatterMarchPush {
        first_tile,
        tile_count,
        sub_sample,
        first_sample: range * samples,
        end_sample: if range + 1 == ranges {
            u32::MAX
        } else {
            (range + 1) * samples
        },
    };
    let march = (&single_scatter.march, &single_scatter.march_binding);
    let radiance = &single_scatter.radiance;
    let time = (plan.tiles).record(device, march, radiance, (ranges, push), progress)?;
    Ok(vec![time])
}
