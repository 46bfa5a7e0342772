//! The technique's images, buffers and pipelines.

use std::sync::Arc;

use super::{AmbientOcclusionPlan, OccludedUniform, stage};
use crate::gpu::{
    Binding, Buffer, BufferUse, ComputePipeline, Device, Filter, GpuError, Image, Resource,
    StageTime,
};
use crate::scene::{AmbientOcclusionParams, Scene};
use crate::technique::albedo_volume::AlbedoImage;
use crate::technique::medium::{Medium, sampler};
use crate::technique::summed_area::Field;
use crate::technique::target::{Target, write};

/// Everything of `ambient_occlusion` on the device.
pub struct AmbientOcclusion {
    /// What it was made from.
    pub plan: AmbientOcclusionPlan,
    pub(super) occlusion: Option<Field>,
    pub(super) march: ComputePipeline,
    pub(super) march_binding: Binding,
    pub(super) radiance: Arc<Image>,
    albedo: AlbedoImage,
    occluded: Arc<Buffer>,
}

/// What of an older technique still fits.
#[derive(Default)]
struct Kept {
    occlusion: Option<Field>,
    march: Option<ComputePipeline>,
    albedo: Option<AlbedoImage>,
    occluded: Option<Arc<Buffer>>,
}

impl Kept {
    fn new(old: Option<AmbientOcclusion>, plan: &AmbientOcclusionPlan) -> Self {
        let Some(old) = old else {
            return Self::default();
        };
        let same_reading = old.plan.march().shader.name == plan.march().shader.name;
        let same_march = same_reading && old.plan.constants == plan.constants;
        Self {
            occlusion: old.occlusion,
            march: same_march.then_some(old.march),
            albedo: Some(old.albedo),
            occluded: Some(old.occluded),
        }
    }
}

impl AmbientOcclusion {
    /// Creates what the plan asks for beside medium and target, or takes over from `old` what still
    /// fits.
    ///
    /// # Errors
    /// The driver's refusal or no memory.
    pub fn new(
        device: &Device,
        plan: &AmbientOcclusionPlan,
        medium: &Medium,
        target: &Target,
        old: Option<Self>,
    ) -> Result<Self, GpuError> {
        let kept = Kept::new(old, plan);
        let field_plan = plan.occlusion.as_ref();
        let occlusion = field_plan
            .map(|p| Field::new(device, p, kept.occlusion))
            .transpose()?;
        let bytes = size_of::<OccludedUniform>() as u64;
        let occluded = kept.occluded.map_or_else(
            || Buffer::new(device, "occluded", bytes, BufferUse::Uniform).map(Arc::new),
            Ok,
        )?;
        let march = kept.march.map_or_else(
            || ComputePipeline::new(device, plan.march(), &plan.constants),
            Ok,
        )?;
        let albedo = AlbedoImage::new(device, plan.albedo, kept.albedo)?;
        let linear = sampler(device, "linear", Filter::LINEAR)?;
        let march_binding = march.bind(medium.with_material(vec![
            Resource::Uniform(target.view.clone()),
            Resource::Uniform(occluded.clone()),
            medium.volume.clone(),
            medium.transfer_function.clone(),
            medium.cell_distance.clone(),
            medium.mask.clone(),
            Resource::Storage(target.radiance.clone()),
            match &occlusion {
                Some(field) => field.resource(linear.clone()),
                // Never read; the mask is always there.
                None => medium.mask.clone(),
            },
            albedo.resource(linear),
        ]))?;
        Ok(Self {
            plan: plan.clone(),
            occlusion,
            march,
            march_binding,
            radiance: target.radiance.clone(),
            albedo,
            occluded,
        })
    }

    /// Brings the albedo volume up to date.
    ///
    /// # Errors
    /// The driver's refusal or no memory for staging.
    pub fn upload_albedo(
        &mut self,
        device: &Device,
        scene: &Scene,
    ) -> Result<Vec<StageTime>, GpuError> {
        self.albedo.upload(device, scene, stage::UPLOAD_ALBEDO)
    }

    /// Writes lights and parameters; the next stages read them.
    pub fn write_uniforms(&self, scene: &Scene, params: &AmbientOcclusionParams, medium: &Medium) {
        let uniform = OccludedUniform::new(scene, params, &self.plan, medium);
        write(&self.occluded, &uniform);
    }
}
