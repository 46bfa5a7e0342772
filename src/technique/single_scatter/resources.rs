//! The technique's images, buffers and pipelines.

use std::sync::Arc;

use glam::UVec3;

use super::{ScatterUniform, SingleScatterPlan, stage};
use crate::gpu::{
    Access, Binding, Buffer, BufferUse, ComputePipeline, Device, Filter, Format, GpuError, Image,
    ImageDesc, ImageType, ImageUsageFlags, Recorder, Resource, StageTime,
};
use crate::scene::{Scene, SingleScatterParams};
use crate::technique::albedo_volume::AlbedoImage;
use crate::technique::medium::{Medium, sampler};
use crate::technique::target::{Target, write};

/// Everything of `single_scatter` on the device.
pub struct SingleScatter {
    /// What it was made from.
    pub plan: SingleScatterPlan,
    pub(super) march: ComputePipeline,
    pub(super) march_binding: Binding,
    pub(super) light_cache: Option<(ComputePipeline, Binding)>,
    pub(super) radiance: Arc<Image>,
    pub(super) light_depth: Arc<Image>,
    albedo: AlbedoImage,
    // Whether `light_depth` holds the depths to the lights as they were at the last frame.
    pub(super) filled: bool,
    scatter: Arc<Buffer>,
}

/// What of an older technique still fits.
#[derive(Default)]
struct Kept {
    march: Option<ComputePipeline>,
    light_cache: Option<ComputePipeline>,
    light_depth: Option<Arc<Image>>,
    filled: bool,
    albedo: Option<AlbedoImage>,
    scatter: Option<Arc<Buffer>>,
}

impl Kept {
    fn new(old: Option<SingleScatter>, plan: &SingleScatterPlan) -> Self {
        let Some(old) = old else {
            return Self::default();
        };
        let same_reading = old.plan.march().shader.name == plan.march().shader.name;
        let same_march = same_reading && old.plan.march_constants == plan.march_constants;
        let same_stage = same_reading && old.plan.cache_constants == plan.cache_constants;
        let same_cache = old.plan.cache == plan.cache;
        Self {
            march: same_march.then_some(old.march),
            light_cache: old.light_cache.filter(|_| same_stage).map(|(p, _)| p),
            light_depth: same_cache.then_some(old.light_depth),
            filled: same_cache && old.filled,
            albedo: Some(old.albedo),
            scatter: Some(old.scatter),
        }
    }
}

impl SingleScatter {
    /// Creates what the plan asks for beside medium and target, or takes over from `old` what still
    /// fits.
    ///
    /// # Errors
    /// The driver's refusal or no memory.
    pub fn new(
        device: &Device,
        plan: &SingleScatterPlan,
        medium: &Medium,
        target: &Target,
        old: Option<Self>,
    ) -> Result<Self, GpuError> {
        let kept = Kept::new(old, plan);
        let bytes = size_of::<ScatterUniform>() as u64;
        let scatter = kept.scatter.map_or_else(
            || Buffer::new(device, "scatter", bytes, BufferUse::Uniform).map(Arc::new),
            Ok,
        )?;
        let light_depth = kept
            .light_depth
            .map_or_else(|| depth_image(device, plan), Ok)?;
        let inputs = |last: Vec<Resource>| {
            let mut list = vec![
                Resource::Uniform(target.view.clone()),
                Resource::Uniform(scatter.clone()),
                medium.volume.clone(),
                medium.transfer_function.clone(),
                medium.cell_distance.clone(),
                medium.mask.clone(),
            ];
            list.extend(last);
            medium.with_material(list)
        };
        let light_cache = match &plan.cache {
            Some(_) => {
                let pipeline = kept.light_cache.map_or_else(
                    || ComputePipeline::new(device, plan.light_cache(), &plan.cache_constants),
                    Ok,
                )?;
                let binding =
                    pipeline.bind(inputs(vec![Resource::Storage(light_depth.clone())]))?;
                Some((pipeline, binding))
            }
            None => None,
        };
        let march = kept.march.map_or_else(
            || ComputePipeline::new(device, plan.march(), &plan.march_constants),
            Ok,
        )?;
        let albedo = AlbedoImage::new(device, plan.albedo, kept.albedo)?;
        let linear = sampler(device, "linear", Filter::LINEAR)?;
        let depth = if plan.medium.loaded {
            Resource::Storage(light_depth.clone())
        } else {
            Resource::SampledGeneral(light_depth.clone(), linear.clone())
        };
        let radiance = Resource::Storage(target.radiance.clone());
        let march_binding = march.bind(inputs(vec![radiance, depth, albedo.resource(linear)]))?;
        Ok(Self {
            plan: plan.clone(),
            march,
            march_binding,
            light_cache,
            radiance: target.radiance.clone(),
            light_depth,
            albedo,
            filled: kept.filled,
            scatter,
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
    pub fn write_uniforms(&self, scene: &Scene, params: &SingleScatterParams, medium: &Medium) {
        let uniform = ScatterUniform::new(scene, params, &self.plan, medium);
        write(&self.scatter, &uniform);
    }
}

/// The nodes of all lights, or a texel that is never read.
fn depth_image(device: &Device, plan: &SingleScatterPlan) -> Result<Arc<Image>, GpuError> {
    let desc = ImageDesc {
        image_type: ImageType::TYPE_3D,
        extent: plan.cache.map_or(UVec3::ONE, |c| c.extent()),
        format: Format::R32_SFLOAT,
        usage: ImageUsageFlags::STORAGE | ImageUsageFlags::SAMPLED,
    };
    let image = Image::new(device, "light_depth", desc)?;
    let mut recorder = Recorder::new(device)?;
    // Nothing was there before; the march finds the layout that its descriptor names.
    recorder.image_barrier(&image, Access::Undefined, Access::ComputeSampledOrLoaded);
    recorder.submit()?;
    Ok(Arc::new(image))
}
