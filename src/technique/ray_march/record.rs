//! The march: one dispatch a sub-sample and band of tiles, each a submission.

use super::RayMarch;
use crate::gpu::{Device, GpuError, StageTime};

/// Marches the whole image; `progress(done, total)` counts bands of tiles.
///
/// # Errors
/// The driver's refusal, a lost device, or a validation message.
pub fn record_march(
    device: &Device,
    ray_march: &RayMarch,
    progress: &mut dyn FnMut(u64, u64),
) -> Result<Vec<StageTime>, GpuError> {
    let march = (&ray_march.pipeline, &ray_march.binding);
    let push = (1, |tiles, _| tiles);
    let tiles = ray_march.plan.tiles;
    let time = tiles.record(device, march, &ray_march.radiance, push, progress)?;
    Ok(vec![time])
}
