//! What every technique renders into, and the camera block that all shaders read.

use std::sync::Arc;

use bytemuck::Pod;
use glam::UVec3;

use super::{PlanError, ResourceKind, ResourcePlan, ViewUniform};
use crate::gpu::{
    Access, Buffer, BufferUse, Device, Format, GpuError, Image, ImageDesc, ImageType,
    ImageUsageFlags, Limits, Recorder, StageTime, download_image,
};
use crate::output;
use crate::scene::{ImageSettings, Scene};

/// The image on the device, the way back to the host, and the view.
pub struct Target {
    size: [u32; 2],
    /// Linear radiance (rgb) and `1 - transmittance` (a), RGBA 32-bit float.
    pub radiance: Arc<Image>,
    /// The `View` block.
    pub view: Arc<Buffer>,
    read_back: Buffer,
}

impl Target {
    /// Creates an image of `[width, height]` pixels, or keeps `old` where it fits.
    ///
    /// # Errors
    /// The driver's refusal or no memory.
    pub fn new(device: &Device, size: [u32; 2], old: Option<Self>) -> Result<Self, GpuError> {
        if let Some(old) = old
            && old.size == size
        {
            return Ok(old);
        }
        let [width, height] = size;
        let desc = ImageDesc {
            image_type: ImageType::TYPE_2D,
            extent: UVec3::new(width, height, 1),
            format: Format::R32G32B32A32_SFLOAT,
            usage: ImageUsageFlags::STORAGE | ImageUsageFlags::TRANSFER_SRC,
        };
        let radiance = Arc::new(Image::new(device, "radiance", desc)?);
        let mut recorder = Recorder::new(device)?;
        // Nothing was there before; techniques find the image in the general layout from now on.
        recorder.image_barrier(&radiance, Access::Undefined, Access::ComputeWrite);
        recorder.submit()?;
        let read_back = Buffer::new(device, "read_back", bytes(size), BufferUse::Readback)?;
        let view_bytes = size_of::<ViewUniform>() as u64;
        let view = Buffer::new(device, "view", view_bytes, BufferUse::Uniform)?;
        Ok(Self {
            size,
            radiance,
            view: Arc::new(view),
            read_back,
        })
    }

    /// Writes the scene's camera, clips and background.
    pub fn write_view(&self, scene: &Scene) {
        write(&self.view, &ViewUniform::new(scene));
    }

    /// Copies the image to the host; `stage` is the technique's name for it.
    ///
    /// # Errors
    /// The driver's refusal or a lost device.
    pub fn download(&self, device: &Device, stage: &str) -> Result<Vec<StageTime>, GpuError> {
        download_image(device, &self.radiance, &self.read_back, stage)
    }

    /// The last image downloaded.
    #[must_use]
    pub fn image(&self) -> output::Image {
        let [width, height] = self.size;
        let count = width as usize * height as usize;
        let pixels = self.read_back.with_bytes(|bytes| {
            let texels = bytes.chunks_exact(16).take(count);
            texels
                .map(bytemuck::pod_read_unaligned::<[f32; 4]>)
                .collect()
        });
        output::Image {
            width,
            height,
            pixels,
        }
    }
}

/// Checks that the device can hold the image.
///
/// # Errors
/// It exceeds a limit.
pub(super) fn check(image: &ImageSettings, limits: &Limits) -> Result<(), PlanError> {
    if image.width.max(image.height) <= limits.max_image_2d {
        return Ok(());
    }
    Err(PlanError::Limit {
        what: "image".to_owned(),
        found: format!("{} x {}", image.width, image.height),
        limit: format!(
            "the device's images reach {} along an axis",
            limits.max_image_2d
        ),
        fix: "lower image.width and image.height".to_owned(),
    })
}

/// The target's resources with their sizes.
#[must_use]
pub(super) fn resources(size: [u32; 2]) -> [ResourcePlan; 2] {
    let bytes = bytes(size);
    let image = |name, format, extent| ResourcePlan {
        name,
        kind: ResourceKind::Image,
        extent,
        format,
        bytes,
        shrink: "lower image.width and image.height",
    };
    let pixels = UVec3::new(size[0], size[1], 1);
    let linear = UVec3::new(u32::try_from(bytes).unwrap_or(u32::MAX), 1, 1);
    [
        image("radiance", Format::R32G32B32A32_SFLOAT, pixels),
        image("read_back", Format::UNDEFINED, linear),
    ]
}

/// Writes a uniform block.
pub(super) fn write<T: Pod>(buffer: &Buffer, value: &T) {
    buffer.with_bytes(|to| to.copy_from_slice(bytemuck::bytes_of(value)));
}

fn bytes([width, height]: [u32; 2]) -> u64 {
    16 * u64::from(width) * u64::from(height)
}
