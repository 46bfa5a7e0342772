//! The albedo volume on the device, for the techniques that scatter light.

use std::sync::Arc;

use glam::UVec3;

use super::{Input, Inputs, ResourceKind, ResourcePlan, StagePlan};
use crate::gpu::{
    Access, Device, Format, GpuError, Image, ImageDesc, ImageType, ImageUsageFlags, Resource,
    Sampler, StageTime, upload_image,
};
use crate::scene::Scene;
use crate::volume::ColorVolume;

/// The image that holds the colours, one texel a voxel; of one texel where there are none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct AlbedoPlan {
    extent: UVec3,
    format: Format,
    /// Whether the scene has an albedo volume.
    pub(super) is_there: bool,
}

impl AlbedoPlan {
    /// Colours of 8 bits where the scene's have no more.
    pub(super) fn new(scene: &Scene) -> Self {
        let colors = scene.medium.albedo_volume.as_deref();
        Self {
            extent: colors.map_or(UVec3::ONE, |c| c.dims),
            format: if colors.is_some_and(|c| !c.is_8_bit()) {
                Format::R16G16B16A16_UNORM
            } else {
                Format::R8G8B8A8_UNORM
            },
            is_there: colors.is_some(),
        }
    }

    /// The transfer, where there is something to transfer.
    pub(super) fn stage(&self, name: &'static str) -> Option<StagePlan> {
        self.is_there.then(|| StagePlan {
            name,
            depends_on: Inputs::of(&[Input::Volume]),
            domain: self.extent,
            dispatches: 1,
            specialization: Vec::new(),
        })
    }

    /// The image's memory.
    pub(super) fn resource(&self) -> ResourcePlan {
        ResourcePlan {
            name: "albedo_volume",
            kind: ResourceKind::Auxiliary,
            extent: self.extent,
            format: self.format,
            bytes: self.texel_bytes() * self.extent.as_u64vec3().element_product(),
            shrink: "store it in 8 bits",
        }
    }

    fn texel_bytes(&self) -> u64 {
        if self.format == Format::R8G8B8A8_UNORM {
            4
        } else {
            8
        }
    }
}

/// The image on the device.
pub(super) struct AlbedoImage {
    plan: AlbedoPlan,
    image: Arc<Image>,
    // The volume that it holds.
    held: Option<Arc<ColorVolume>>,
    filled: bool,
}

impl AlbedoImage {
    /// Creates the image, or takes over `old` where it fits.
    pub(super) fn new(
        device: &Device,
        plan: AlbedoPlan,
        old: Option<Self>,
    ) -> Result<Self, GpuError> {
        if let Some(old) = old.filter(|o| o.plan == plan) {
            return Ok(old);
        }
        let desc = ImageDesc {
            image_type: ImageType::TYPE_3D,
            extent: plan.extent,
            format: plan.format,
            usage: ImageUsageFlags::SAMPLED | ImageUsageFlags::TRANSFER_DST,
        };
        Ok(Self {
            plan,
            image: Image::new(device, "albedo_volume", desc).map(Arc::new)?,
            held: None,
            filled: false,
        })
    }

    /// The image as shaders read it, through a linear filter.
    pub(super) fn resource(&self, linear: Arc<Sampler>) -> Resource {
        Resource::Sampled(self.image.clone(), linear)
    }

    /// Fills the image with the scene's colours, unless it holds them already; the stage is `name`.
    pub(super) fn upload(
        &mut self,
        device: &Device,
        scene: &Scene,
        name: &'static str,
    ) -> Result<Vec<StageTime>, GpuError> {
        let colors = scene.medium.albedo_volume.as_ref();
        let same = self.held.as_ref().map(Arc::as_ptr) == colors.map(Arc::as_ptr);
        if self.filled && same {
            return Ok(Vec::new());
        }
        let slice = (self.plan.extent.x * self.plan.extent.y) as usize;
        let bytes = self.plan.texel_bytes();
        let fill = |first: u32, _, to: &mut [u8]| {
            let Some(colors) = colors else { return };
            let texels = to.chunks_exact_mut(bytes as usize);
            for (i, texel) in texels.enumerate() {
                write(texel, colors, first as usize * slice + i);
            }
        };
        let after = Access::ComputeSampled;
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
