//! The march: one dispatch a sub-sample and band of tiles, one submission a band.

use bytemuck::bytes_of;
use glam::UVec3;

use super::{MarchPush, RayMarch};
use crate::gpu::{Access, Device, GpuError, Recorder, StageTime};

/// Invocations a tile.
const TILE_INVOCATIONS: u32 = 64;

/// Marches the whole image; `progress(done, total)` counts bands of tiles.
///
/// # Errors
/// The driver's refusal, a lost device, or a validation message.
pub fn record_march(
    device: &Device,
    ray_march: &RayMarch,
    progress: &mut dyn FnMut(u64, u64),
) -> Result<Vec<StageTime>, GpuError> {
    let plan = &ray_march.plan;
    let name = plan.march().shader.name;
    let (pipeline, binding) = (&ray_march.pipeline, &ray_march.binding);
    let spread = plan
        .specialization
        .iter()
        .find(|s| s.name == "SPREAD")
        .map_or(1, |s| s.value);
    let bands = plan.tiles.div_ceil(plan.tiles_per_submission);
    let total = u64::from(bands) * u64::from(plan.sub_samples);
    let mut seconds = 0.0;
    for band in 0..bands {
        let first_tile = band * plan.tiles_per_submission;
        let tile_count = plan.tiles_per_submission.min(plan.tiles - first_tile);
        // Whole streams: the shader deals tiles out to `spread` of them.
        let groups = tile_count.div_ceil(spread) * spread;
        for sub_sample in 0..plan.sub_samples {
            let push = MarchPush {
                first_tile,
                tile_count,
                sub_sample,
            };
            let mut recorder = Recorder::new(device)?;
            // RAW and WAW: a sub-sample adds to what the one before wrote.
            recorder.image_barrier(
                &ray_march.radiance,
                Access::ComputeWrite,
                Access::ComputeReadWrite,
            );
            recorder.compute_stage(name, |r| {
                let domain = UVec3::new(groups * TILE_INVOCATIONS, 1, 1);
                r.dispatch(pipeline, binding, bytes_of(&push), domain);
            });
            seconds += recorder.submit()?.iter().map(|t| t.seconds).sum::<f64>();
            let done = u64::from(band) * u64::from(plan.sub_samples) + u64::from(sub_sample) + 1;
            progress(done, total);
        }
    }
    Ok(vec![StageTime {
        name: name.to_owned(),
        seconds,
    }])
}
