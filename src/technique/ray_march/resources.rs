//! The technique's images, buffers and pipeline.

use std::sync::Arc;

use super::{MarchUniform, RayMarchPlan};
use crate::gpu::{Binding, Buffer, BufferUse, ComputePipeline, Device, GpuError, Image, Resource};
use crate::scene::{RayMarchParams, Scene};
use crate::technique::medium::Medium;
use crate::technique::target::{Target, write};

/// Everything of `ray_march` on the device.
pub struct RayMarch {
    /// What it was made from.
    pub plan: RayMarchPlan,
    pub(super) pipeline: ComputePipeline,
    pub(super) binding: Binding,
    pub(super) radiance: Arc<Image>,
    march: Arc<Buffer>,
}

impl RayMarch {
    /// Creates what the plan asks for beside medium and target, or takes over from `old` what still
    /// fits.
    ///
    /// # Errors
    /// The driver's refusal or no memory.
    pub fn new(
        device: &Device,
        plan: &RayMarchPlan,
        medium: &Medium,
        target: &Target,
        old: Option<Self>,
    ) -> Result<Self, GpuError> {
        let (mut pipeline, mut march) = (None, None);
        if let Some(old) = old {
            pipeline = (old.plan.specialization == plan.specialization
                && old.plan.march().shader.name == plan.march().shader.name)
                .then_some(old.pipeline);
            march = Some(old.march);
        }
        let pipeline = pipeline.map_or_else(
            || ComputePipeline::new(device, plan.march(), &plan.specialization),
            Ok,
        )?;
        let bytes = size_of::<MarchUniform>() as u64;
        let march = march.map_or_else(
            || Buffer::new(device, "march", bytes, BufferUse::Uniform).map(Arc::new),
            Ok,
        )?;
        let binding = pipeline.bind(medium.with_material(vec![
            Resource::Uniform(target.view.clone()),
            Resource::Uniform(march.clone()),
            medium.volume.clone(),
            medium.transfer_function.clone(),
            medium.cell_distance.clone(),
            medium.mask.clone(),
            Resource::Storage(target.radiance.clone()),
        ]))?;
        Ok(Self {
            plan: plan.clone(),
            pipeline,
            binding,
            radiance: target.radiance.clone(),
            march,
        })
    }

    /// Writes lights and parameters; the next march reads them.
    pub fn write_uniforms(&self, scene: &Scene, params: &RayMarchParams, medium: &Medium) {
        write(&self.march, &MarchUniform::new(scene, params, medium));
    }
}
