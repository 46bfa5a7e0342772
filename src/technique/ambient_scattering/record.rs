//! First the light that arrives, where something changed it; then the march.

use bytemuck::bytes_of;
use glam::UVec3;

use super::{AmbientScattering, AmbientScatteringPlan, GatherPush, TubePush};
use crate::gpu::{Access, Device, GpuError, Recorder, StageTime};
use crate::scene::Scene;
use crate::technique::Inputs;
use crate::technique::medium::Medium;
use crate::technique::summed_area::{Field, SummedAreaPlan};
use crate::technique::target::Target;

/// Brings ambient extinction, occlusion and radiance cache up to date; `changed` says what differs from the last
/// frame. One dispatch a slab, each a submission; `progress(done, total)` counts them.
///
/// # Errors
/// The driver's refusal, no memory, or a validation message.
pub fn record_radiance_cache(
    device: &Device,
    technique: &mut AmbientScattering,
    (scene, medium, target): (&Scene, &Medium, &Target),
    changed: Inputs,
    progress: &mut dyn FnMut(u64, u64),
) -> Result<Vec<StageTime>, GpuError> {
    let mut times = Vec::new();
    let mut bring = |field: &mut Option<Field>, times: &mut Vec<StageTime>| {
        if let Some(field) = field
            && (!field.is_filled() || changed.intersects(SummedAreaPlan::DEPENDS_ON))
        {
            times.extend(field.record(device, (scene, medium, target), progress)?);
        }
        Ok::<_, GpuError>(())
    };
    bring(&mut technique.extinction, &mut times)?;
    bring(&mut technique.occlusion, &mut times)?;
    let current = technique.filled && !changed.intersects(AmbientScatteringPlan::CACHED);
    if !current {
        times.extend(fill_cache(device, technique, progress)?);
        technique.filled = true;
    }
    Ok(times)
}

fn fill_cache(
    device: &Device,
    technique: &AmbientScattering,
    progress: &mut dyn FnMut(u64, u64),
) -> Result<Option<StageTime>, GpuError> {
    let plan = &technique.plan;
    let (Some(cache), Some((pipeline, binding))) = (&plan.cache, &technique.cache_stage) else {
        return Ok(None);
    };
    let name = pipeline.name();
    let (slabs, image, nodes) = (cache.submissions(), &technique.cache, cache.nodes.count);
    let total = cache.lights * slabs;
    let mut seconds = 0.0;
    for index in 0..total {
        let first_slice = index % slabs * cache.slices_per_submission;
        let slice_count = cache.slices_per_submission.min(nodes.z - first_slice);
        let push = TubePush {
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
            let domain = UVec3::new(nodes.x, nodes.y, slices);
            r.dispatch(pipeline, binding, bytes_of(&push), domain);
        });
        if index + 1 == total {
            // RAW: the march reads what the slabs wrote.
            recorder.image_barrier(image, Access::ComputeWrite, Access::ComputeSampledOrLoaded);
        }
        seconds += recorder.submit()?.iter().map(|t| t.seconds).sum::<f64>();
        progress(u64::from(index) + 1, u64::from(total));
    }
    Ok(Some(StageTime {
        name: name.to_owned(),
        seconds,
    }))
}

/// Has the cache's nodes look where that serves the rays, then marches the whole image: one dispatch a band of tiles and
/// sub-sample, each a submission; `progress(done, total)` counts them.
///
/// # Errors
/// The driver's refusal, a lost device, or a validation message.
pub fn record_march(
    device: &Device,
    technique: &AmbientScattering,
    progress: &mut dyn FnMut(u64, u64),
) -> Result<Vec<StageTime>, GpuError> {
    let mut times = Vec::from_iter(gather(device, technique)?);
    let march = (&technique.march, &technique.march_binding);
    let push = (1, |tiles, _| tiles);
    let tiles = technique.plan.tiles;
    times.push(tiles.record(device, march, &technique.radiance, push, progress)?);
    Ok(times)
}

/// What nodes scatter towards the viewer: one dispatch a slab of them, each a submission.
fn gather(device: &Device, technique: &AmbientScattering) -> Result<Option<StageTime>, GpuError> {
    let plan = &technique.plan;
    let (Some(gather), Some((pipeline, binding))) = (&plan.gather, &technique.gather_stage) else {
        return Ok(None);
    };
    let (name, image) = (pipeline.name(), &technique.gathered_light);
    let total = gather.submissions();
    let mut seconds = 0.0;
    for index in 0..total {
        let first_slice = index * gather.slices_per_submission;
        let push = GatherPush {
            first_slice,
            slice_count: gather
                .slices_per_submission
                .min(gather.nodes.z - first_slice),
        };
        let mut recorder = Recorder::new(device)?;
        if index == 0 {
            // WAR: the last march has read what is written anew.
            recorder.image_barrier(image, Access::ComputeSampledOrLoaded, Access::ComputeWrite);
        }
        recorder.compute_stage(name, |r| {
            let domain = gather.nodes.with_z(push.slice_count);
            r.dispatch(pipeline, binding, bytes_of(&push), domain);
        });
        if index + 1 == total {
            // RAW: the march reads what the slabs wrote.
            recorder.image_barrier(image, Access::ComputeWrite, Access::ComputeSampledOrLoaded);
        }
        seconds += recorder.submit()?.iter().map(|t| t.seconds).sum::<f64>();
    }
    Ok(Some(StageTime {
        name: name.to_owned(),
        seconds,
    }))
}
