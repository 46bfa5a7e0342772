//! First the occlusion of every cell, where something changed it; then the march.

use super::AmbientOcclusion;
use crate::gpu::{Device, GpuError, StageTime};
use crate::scene::Scene;
use crate::technique::Inputs;
use crate::technique::medium::Medium;
use crate::technique::summed_area::SummedAreaPlan;
use crate::technique::target::Target;

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
    let march = (&technique.march, &technique.march_binding);
    let push = (1, |tiles, _| tiles);
    let tiles = technique.plan.tiles;
    let time = tiles.record(device, march, &technique.radiance, push, progress)?;
    Ok(vec![time])
}
