//! Moving whole images between host and device.

use glam::UVec3;

use super::{Access, Buffer, BufferUse, Device, GpuError, Image, Recorder, StageTime};

/// Bytes of the staging buffer: large enough to stream at full speed, small beside a volume.
const STAGING_BYTES: u64 = 16 << 20;

/// Slices (rows for 2D) that one round of staging takes, and the staging buffer's bytes, for an image
/// of `slices` slices of `slice_bytes` each.
#[must_use]
pub fn staging(slice_bytes: u64, slices: u32) -> (u32, u64) {
    let round = (STAGING_BYTES / slice_bytes.max(1)).clamp(1, u64::from(slices.max(1)));
    (u32::try_from(round).unwrap_or(1), slice_bytes * round)
}

/// Fills an image slab by slab through a staging buffer and leaves it ready for `after`.
///
/// `fill(first_slice, slices, bytes)` writes `slices` whole xy-slices (rows for 2D, the one row for
/// 1D) of tightly packed texels starting at `first_slice`; `texel_bytes` is a texel's size.
/// `progress(done, total)` counts bytes.
///
/// # Errors
/// The driver's refusal or no memory.
pub fn upload_image(
    device: &Device,
    image: &Image,
    stage: &str,
    texel_bytes: u64,
    after: Access,
    mut fill: impl FnMut(u32, u32, &mut [u8]),
    progress: &mut dyn FnMut(u64, u64),
) -> Result<Vec<StageTime>, GpuError> {
    let extent = image.desc().extent;
    let slice_bytes = u64::from(extent.x) * u64::from(extent.y) * texel_bytes;
    let (slices, bytes) = staging(slice_bytes, extent.z);
    let name = format!("{} staging", image.name());
    let staging = Buffer::new(device, &name, bytes, BufferUse::Upload)?;
    let total = slice_bytes * u64::from(extent.z);
    let mut seconds = 0.0;
    let mut z = 0;
    while z < extent.z {
        let count = slices.min(extent.z - z);
        let bytes = usize::try_from(slice_bytes * u64::from(count)).unwrap_or(usize::MAX);
        staging.with_bytes(|staged| {
            if let Some(target) = staged.get_mut(..bytes) {
                fill(z, count, target);
            }
        });
        let mut recorder = Recorder::new(device)?;
        if z == 0 {
            // Nothing was there before.
            recorder.image_barrier(image, Access::Undefined, Access::CopyWrite);
        }
        recorder.copy_stage(stage, |r| {
            r.copy_to_image(
                &staging,
                image,
                UVec3::new(0, 0, z),
                UVec3::new(extent.x, extent.y, count),
            );
        });
        z += count;
        if z == extent.z {
            // RAW: every later stage reads what the copies wrote.
            recorder.image_barrier(image, Access::CopyWrite, after);
        }
        seconds += recorder.submit()?.iter().map(|t| t.seconds).sum::<f64>();
        progress(u64::from(z) * slice_bytes, total);
    }
    Ok(vec![StageTime {
        name: stage.to_owned(),
        seconds,
    }])
}

/// Copies a storage image, last written by a compute shader, to the host: tightly packed texels.
///
/// # Errors
/// The driver's refusal or no memory.
pub fn download_image(
    device: &Device,
    image: &Image,
    readback: &Buffer,
    stage: &str,
) -> Result<Vec<StageTime>, GpuError> {
    let mut recorder = Recorder::new(device)?;
    // RAW: the copy reads what the last compute stage wrote.
    recorder.image_barrier(image, Access::ComputeWrite, Access::CopyRead);
    recorder.copy_stage(stage, |r| r.copy_to_buffer(image, readback));
    // RAW: the host reads what the copy wrote.
    recorder.buffer_barrier(readback, Access::CopyWrite, Access::HostRead);
    // WAR: the next frame writes what the copy read.
    recorder.image_barrier(image, Access::CopyRead, Access::ComputeWrite);
    recorder.submit()
}
