//! The albedo volume on the device.

use std::sync::Arc;

use glam::UVec3;

use super::stage;
use crate::gpu::{
    Access, Device, Format, GpuError, Image, ImageDesc, ImageType, ImageUsageFlags, StageTime,
    upload_image,
};
use crate::volume::ColorVolume;

/// The format that holds the colours: 8 bits where they have no more.
pub(super) fn format(colors: Option<&ColorVolume>) -> Format {
    if colors.is_some_and(|c| !c.is_8_bit()) {
        Format::R16G16B16A16_UNORM
    } else {
        Format::R8G8B8A8_UNORM
    }
}

/// Bytes of a texel.
pub(super) fn texel_bytes(format: Format) -> u64 {
    if format == Format::R8G8B8A8_UNORM {
        4
    } else {
        8
    }
}

/// An image of the colours, one texel a voxel; of one texel where there are none.
pub(super) struct Colors {
    pub(super) image: Arc<Image>,
    // The volume that it holds.
    held: Option<Arc<ColorVolume>>,
    filled: bool,
}

impl Colors {
    pub(super) fn new(
        device: &Device,
        (extent, format): (UVec3, Format),
        old: Option<Self>,
    ) -> Result<Self, GpuError> {
        let fits = |c: &Self| c.image.desc().extent == extent && c.image.desc().format == format;
        if let Some(old) = old.filter(fits) {
            return Ok(old);
        }
        let desc = ImageDesc {
            image_type: ImageType::TYPE_3D,
            extent,
            format,
            usage: ImageUsageFlags::SAMPLED | ImageUsageFlags::TRANSFER_DST,
        };
        Ok(Self {
            image: Image::new(device, "albedo_volume", desc).map(Arc::new)?,
            held: None,
            filled: false,
        })
    }

    /// Fills the image with the scene's colours, unless it holds them already.
    pub(super) fn upload(
        &mut self,
        device: &Device,
        colors: Option<&Arc<ColorVolume>>,
    ) -> Result<Vec<StageTime>, GpuError> {
        let same = self.held.as_ref().map(Arc::as_ptr) == colors.map(Arc::as_ptr);
        if self.filled && same {
            return Ok(Vec::new());
        }
        let desc = self.image.desc();
        let slice = (desc.extent.x * desc.extent.y) as usize;
        let bytes = texel_bytes(desc.format);
        let fill = |first: u32, _, to: &mut [u8]| {
            let Some(colors) = colors else { return };
            let texels = to.chunks_exact_mut(bytes as usize);
            for (i, texel) in texels.enumerate() {
                write(texel, colors, first as usize * slice + i);
            }
        };
        let (after, name) = (Access::ComputeSampled, stage::UPLOAD_ALBEDO);
        let times = upload_image(
            device,
            &self.image,
            name,
            bytes,
            after,
            fill,
            &mut |_, _| {},
        )?;
        (self.held, self.filled) = (colors.cloned(), true);
        Ok(if colors.is_some() { times } else { Vec::new() })
    }
}

/// A voxel's colour as texel of 4 or 8 bytes.
fn write(texel: &mut [u8], colors: &ColorVolume, index: usize) {
    let color = colors.color(index);
    for (i, c) in color.to_array().into_iter().enumerate() {
        if texel.len() == 4 {
            texel[i] = (255.0 * c).round() as u8;
        } else {
            let word = (65535.0 * c).round() as u16;
            texel[2 * i..2 * i + 2].copy_from_slice(&word.to_ne_bytes());
        }
    }
}
