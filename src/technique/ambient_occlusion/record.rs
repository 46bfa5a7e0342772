//! First the occlusion of every cell, where something changed it; then the march.

use bytemuck::bytes_of;
use glam::UVec3;

use super::{AmbientOcclusion, OccludedMarchPush};
use crate::gpu::{Access, Device, GpuError, Recorder, StageTime};
use crate::scene::Scene;
use crate::technique::Inputs;
use crate::technique::medium::Medium;
use crate::technique::summed_area::SummedAreaPlan;
use crate::technique::target::Target;

/// Invocations a tile.
const TILE_INVOCATIONS: u32 = 64;

/// Brings the occlusion up to date; `changed` says what differs from the last frame.
///
/// # Errors
/// The driver's refusal, no memory, or a validation message.
pub fn record_occlusion(
    device: &Device,
    technique: &mut AmbientOcclusion,
    of: (&Scene, &Medium, &Target),
    changed: Inputs,
    progress: &mut dyn FnMut(u64, u64),
) -> Result<Vec<StageTime>, GpuError> {
    match &mut technique.occlusion {
        Some(field) if !field.is_filled() || changed.intersects(SummedAreaPlan::DEPENDS_ON) => {
            field.record(device, of, progress)
        }
        _ => Ok(Vec::new()),
    }
}

/// Marches the whole image: one dispatch a band of tiles and sub-sample, each a submission;
/// `progress(done, total)` counts them.
///
/// # Errors
/// The driver's refusal, a lost device, or a validation message.
pub fn record_march(
    device: &Device,
    technique: &AmbientOcclusion,
    progress: &mut dyn FnMut(u64, u64),
) -> Result<Vec<StageTime>, GpuError> {
    let plan = &technique.plan;
    let name = plan.march().shader.name;
    let (pipeline, binding) = (&technique.march, &technique.march_binding);
    let mut constants = plan.constants.iter();
    let spread = constants
        .find(|s| s.name == "SPREAD")
        .map_or(1, |s| s.value);
    let total = plan.bands() * plan.sub_samples;
    let mut seconds = 0.0;
    for index in 0..total {
        let first_tile = index / plan.sub_samples * plan.tiles_per_submission;
        let tile_count = plan.tiles_per_submission.min(plan.tiles - first_tile);
        let push = OccludedMarchPush {
            first_tile,
            tile_count,
            sub_sample: index % plan.sub_samples,
        };
        let mut recorder = Recorder::new(device)?;
        // RAW and WAW: sub-samples add to what the ones before wrote.
        recorder.image_barrier(
            &technique.radiance,
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
