//! The technique's images, buffers and pipeline.

use std::sync::Arc;

use bytemuck::Pod;
use glam::UVec3;

use super::{MarchUniform, RayMarchPlan};
use crate::gpu::{
    Access, Binding, Buffer, BufferUse, ComputePipeline, Device, Format, GpuError, Image,
    ImageDesc, ImageType, ImageUsageFlags, Recorder, Resource,
};
use crate::scene::{RayMarchParams, Scene};
use crate::technique::ViewUniform;
use crate::technique::medium::Medium;

/// Everything of `ray_march` on the device.
pub struct RayMarch {
    /// What it was made from.
    pub plan: RayMarchPlan,
    /// The medium it marches through.
    pub medium: Medium,
    pub(super) pipeline: ComputePipeline,
    pub(super) binding: Binding,
    pub(super) radiance: Arc<Image>,
    pub(super) read_back: Buffer,
    view: Arc<Buffer>,
    march: Arc<Buffer>,
}

impl RayMarch {
    /// Creates everything the plan asks for, or takes over from `old` what still fits.
    ///
    /// # Errors
    /// The driver's refusal or no memory.
    pub fn new(device: &Device, plan: &RayMarchPlan, old: Option<Self>) -> Result<Self, GpuError> {
        let (mut medium, mut pipeline, mut images, mut uniforms) = (None, None, None, None);
        if let Some(old) = old {
            medium = (old.medium.plan == plan.medium).then_some(old.medium);
            pipeline = (old.plan.specialization == plan.specialization
                && old.plan.march().shader.name == plan.march().shader.name)
                .then_some(old.pipeline);
            images = (old.plan.image == plan.image).then_some((old.radiance, old.read_back));
            uniforms = Some((old.view, old.march));
        }
        let medium = medium.map_or_else(|| Medium::new(device, &plan.medium), Ok)?;
        let pipeline = pipeline.map_or_else(
            || ComputePipeline::new(device, plan.march(), &plan.specialization),
            Ok,
        )?;
        let (radiance, read_back) = images.map_or_else(|| create_images(device, plan.image), Ok)?;
        let (view, march) = uniforms.map_or_else(|| create_uniforms(device), Ok)?;
        let binding = pipeline.bind(vec![
            Resource::Uniform(view.clone()),
            Resource::Uniform(march.clone()),
            medium.volume.clone(),
            medium.transfer_function.clone(),
            medium.cell_distance.clone(),
            medium.mask.clone(),
            Resource::Storage(radiance.clone()),
        ])?;
        Ok(Self {
            plan: plan.clone(),
            medium,
            pipeline,
            binding,
            radiance,
            read_back,
            view,
            march,
        })
    }

    /// Writes camera, lights and parameters; the next march reads them.
    pub fn write_uniforms(&self, scene: &Scene, params: &RayMarchParams) {
        write(&self.view, &ViewUniform::new(scene));
        write(&self.march, &MarchUniform::new(scene, params, &self.medium));
    }

    /// The image on the device: linear radiance, alpha = 1 - transmittance.
    #[must_use]
    pub fn radiance(&self) -> &Image {
        &self.radiance
    }

    /// Host buffer for the image.
    #[must_use]
    pub fn read_back(&self) -> &Buffer {
        &self.read_back
    }
}

fn create_images(
    device: &Device,
    [width, height]: [u32; 2],
) -> Result<(Arc<Image>, Buffer), GpuError> {
    let desc = ImageDesc {
        image_type: ImageType::TYPE_2D,
        extent: UVec3::new(width, height, 1),
        format: Format::R32G32B32A32_SFLOAT,
        usage: ImageUsageFlags::STORAGE | ImageUsageFlags::TRANSFER_SRC,
    };
    let radiance = Arc::new(Image::new(device, "radiance", desc)?);
    let mut recorder = Recorder::new(device)?;
    // Nothing was there before; `march` finds the image in the general layout from now on.
    recorder.image_barrier(&radiance, Access::Undefined, Access::ComputeWrite);
    recorder.submit()?;
    let bytes = 16 * u64::from(width) * u64::from(height);
    Ok((
        radiance,
        Buffer::new(device, "read_back", bytes, BufferUse::Readback)?,
    ))
}

fn create_uniforms(device: &Device) -> Result<(Arc<Buffer>, Arc<Buffer>), GpuError> {
    let new = |name, bytes: usize| Buffer::new(device, name, bytes as u64, BufferUse::Uniform);
    Ok((
        Arc::new(new("view", size_of::<ViewUniform>())?),
        Arc::new(new("march", size_of::<MarchUniform>())?),
    ))
}

fn write<T: Pod>(buffer: &Buffer, value: &T) {
    buffer.with_bytes(|to| to.copy_from_slice(bytemuck::bytes_of(value)));
}
