//! The technique's images, buffers and pipelines.

use std::sync::Arc;

use glam::{DVec3, UVec3};

use super::lookup::{ANGLES, DEPTHS, Key, Lookup, Scalars};
use super::table::shipped;
use super::{AmbientScatteringPlan, AmbientUniform, stage};
use crate::gpu::{
    Access, Binding, Buffer, BufferUse, ComputePipeline, Device, Filter, Format, GpuError, Image,
    ImageDesc, ImageType, ImageUsageFlags, Recorder, Resource, StageTime, upload_image,
};
use crate::scene::{AmbientScatteringParams, Scene};
use crate::technique::albedo_volume::AlbedoImage;
use crate::technique::medium::{Medium, sampler};
use crate::technique::summed_area::{Field, FieldPlan};
use crate::technique::target::{Target, write};

/// Everything of `ambient_scattering` on the device.
pub struct AmbientScattering {
    /// What it was made from.
    pub plan: AmbientScatteringPlan,
    pub(super) extinction: Option<Field>,
    pub(super) occlusion: Option<Field>,
    pub(super) march: ComputePipeline,
    pub(super) march_binding: Binding,
    pub(super) cache_stage: Option<(ComputePipeline, Binding)>,
    pub(super) radiance: Arc<Image>,
    pub(super) cache: Arc<Image>,
    pub(super) gather_stage: Option<(ComputePipeline, Binding)>,
    pub(super) gathered_light: Arc<Image>,
    // Whether `cache` holds the light of the scene as it was at the last frame.
    pub(super) filled: bool,
    tables: Tables,
    albedo: AlbedoImage,
    ambient: Arc<Buffer>,
}

/// The tables on the device.
struct Tables {
    scattered: Arc<Image>,
    tube: Arc<Image>,
    // What they hold.
    held: Option<Key>,
    scalars: Scalars,
}

/// What of an older technique still fits.
#[derive(Default)]
struct Kept {
    extinction: Option<Field>,
    occlusion: Option<Field>,
    march: Option<ComputePipeline>,
    cache_stage: Option<ComputePipeline>,
    cache: Option<Arc<Image>>,
    gather_stage: Option<ComputePipeline>,
    gathered_light: Option<Arc<Image>>,
    filled: bool,
    tables: Option<Tables>,
    albedo: Option<AlbedoImage>,
    ambient: Option<Arc<Buffer>>,
}

impl Kept {
    fn new(old: Option<AmbientScattering>, plan: &AmbientScatteringPlan) -> Self {
        let Some(old) = old else {
            return Self::default();
        };
        let same_reading = old.plan.march().shader.name == plan.march().shader.name;
        let same_march = same_reading && old.plan.march_constants == plan.march_constants;
        let same_stage = old.plan.cache_constants == plan.cache_constants;
        let same_cache = old.plan.cache == plan.cache;
        let same_gather = old.plan.gather_constants == plan.gather_constants;
        let same_light = old.plan.extinction == plan.extinction && old.plan.tables == plan.tables;
        Self {
            extinction: old.extinction,
            occlusion: old.occlusion,
            march: same_march.then_some(old.march),
            cache_stage: old.cache_stage.filter(|_| same_stage).map(|(p, _)| p),
            cache: same_cache.then_some(old.cache),
            gather_stage: old.gather_stage.filter(|_| same_gather).map(|(p, _)| p),
            gathered_light: (old.plan.gather == plan.gather).then_some(old.gathered_light),
            filled: same_cache && same_light && old.filled,
            tables: Some(old.tables),
            albedo: Some(old.albedo),
            ambient: Some(old.ambient),
        }
    }
}

impl AmbientScattering {
    /// Creates what the plan asks for beside medium and target, or takes over from `old` what still
    /// fits.
    ///
    /// # Errors
    /// The driver's refusal or no memory.
    pub fn new(
        device: &Device,
        plan: &AmbientScatteringPlan,
        medium: &Medium,
        target: &Target,
        old: Option<Self>,
    ) -> Result<Self, GpuError> {
        let kept = Kept::new(old, plan);
        let field = |plan: &Option<FieldPlan>, old| {
            let plan = plan.as_ref();
            plan.map(|p| Field::new(device, p, old)).transpose()
        };
        let extinction = field(&plan.extinction, kept.extinction)?;
        let occlusion = field(&plan.occlusion, kept.occlusion)?;
        let bytes = size_of::<AmbientUniform>() as u64;
        let ambient = kept.ambient.map_or_else(
            || Buffer::new(device, "ambient", bytes, BufferUse::Uniform).map(Arc::new),
            Ok,
        )?;
        let cache = kept.cache.map_or_else(|| cache_image(device, plan), Ok)?;
        let gathered_light = kept
            .gathered_light
            .map_or_else(|| gathered_image(device, plan), Ok)?;
        let tables = kept.tables.map_or_else(|| Tables::new(device), Ok)?;
        let linear = sampler(device, "linear", Filter::LINEAR)?;
        let unused = Resource::SampledGeneral(cache.clone(), linear.clone());
        let of = |field: &Option<Field>| match field {
            Some(field) => field.resource(linear.clone()),
            None => unused.clone(),
        };
        let view = Resource::Uniform(target.view.clone());
        let uniform = Resource::Uniform(ambient.clone());
        let tube = Resource::Sampled(tables.tube.clone(), linear.clone());
        let cache_stage = match &plan.cache {
            Some(_) => {
                let pipeline = kept.cache_stage.map_or_else(
                    || ComputePipeline::new(device, plan.radiance_cache(), &plan.cache_constants),
                    Ok,
                )?;
                let binding = pipeline.bind(vec![
                    view.clone(),
                    uniform.clone(),
                    of(&extinction),
                    tube.clone(),
                    Resource::Storage(cache.clone()),
                ])?;
                Some((pipeline, binding))
            }
            None => None,
        };
        let scattered = Resource::Sampled(tables.scattered.clone(), linear.clone());
        let gather_stage = match &plan.gather {
            Some(_) => {
                let pipeline = kept.gather_stage.map_or_else(
                    || ComputePipeline::new(device, plan.gather_stage(), &plan.gather_constants),
                    Ok,
                )?;
                let binding = pipeline.bind(vec![
                    view.clone(),
                    uniform.clone(),
                    of(&extinction),
                    unused.clone(),
                    scattered.clone(),
                    of(&occlusion),
                    Resource::Storage(gathered_light.clone()),
                ])?;
                Some((pipeline, binding))
            }
            None => None,
        };
        let march = kept.march.map_or_else(
            || ComputePipeline::new(device, plan.march(), &plan.march_constants),
            Ok,
        )?;
        let albedo = AlbedoImage::new(device, plan.albedo, kept.albedo)?;
        let march_binding = march.bind(medium.with_material(vec![
            view,
            uniform,
            medium.volume.clone(),
            medium.transfer_function.clone(),
            medium.cell_distance.clone(),
            medium.mask.clone(),
            Resource::Storage(target.radiance.clone()),
            of(&extinction),
            tube,
            unused.clone(),
            scattered,
            of(&occlusion),
            albedo.resource(linear.clone()),
            Resource::SampledGeneral(gathered_light.clone(), linear),
        ]))?;
        Ok(Self {
            plan: plan.clone(),
            extinction,
            occlusion,
            march,
            march_binding,
            cache_stage,
            radiance: target.radiance.clone(),
            cache,
            gather_stage,
            gathered_light,
            filled: kept.filled,
            tables,
            albedo,
            ambient,
        })
    }

    /// Brings tables and albedo volume up to date.
    ///
    /// # Errors
    /// The driver's refusal or no memory for staging.
    pub fn upload(&mut self, device: &Device, scene: &Scene) -> Result<Vec<StageTime>, GpuError> {
        let mut times = self.albedo.upload(device, scene, stage::UPLOAD_ALBEDO)?;
        if self.plan.extinction.is_some() || self.tables.held.is_none() {
            times.extend(self.tables.upload(device, &self.plan.tables)?);
        }
        Ok(times)
    }

    /// Writes lights and parameters; the next stages read them.
    pub fn write_uniforms(&self, scene: &Scene, params: &AmbientScatteringParams, medium: &Medium) {
        let scalars = &self.tables.scalars;
        let uniform = AmbientUniform::new(scene, params, &self.plan, medium, scalars);
        write(&self.ambient, &uniform);
    }
}

impl Tables {
    fn new(device: &Device) -> Result<Self, GpuError> {
        let image = |name, image_type, extent| {
            let desc = ImageDesc {
                image_type,
                extent,
                format: Format::R32G32B32A32_SFLOAT,
                usage: ImageUsageFlags::SAMPLED | ImageUsageFlags::TRANSFER_DST,
            };
            Image::new(device, name, desc).map(Arc::new)
        };
        let (angles, depths) = (ANGLES as u32, DEPTHS as u32);
        Ok(Self {
            scattered: image(
                "scattered",
                ImageType::TYPE_2D,
                UVec3::new(angles, depths, 1),
            )?,
            tube: image("tube", ImageType::TYPE_1D, UVec3::new(depths, 1, 1))?,
            held: None,
            scalars: Scalars {
                vacuum: 0.0,
                dimming_ratio: DVec3::ONE,
            },
        })
    }

    fn upload(&mut self, device: &Device, key: &Key) -> Result<Vec<StageTime>, GpuError> {
        if self.held.as_ref() == Some(key) {
            return Ok(Vec::new());
        }
        let shipped = shipped().map_err(|e| GpuError::Shader {
            name: stage::UPLOAD_TABLES.to_owned(),
            message: e.to_string(),
        })?;
        let lookup = Lookup::new(shipped, key);
        let mut seconds = 0.0;
        for (image, texels) in [
            (&self.scattered, &lookup.scattered),
            (&self.tube, &lookup.tube),
        ] {
            let fill =
                |_, _, to: &mut [u8]| to.copy_from_slice(bytemuck::cast_slice(texels.as_slice()));
            let (name, after) = (stage::UPLOAD_TABLES, Access::ComputeSampled);
            let times = upload_image(device, image, name, 16, after, fill, &mut |_, _| {})?;
            seconds += times.iter().map(|t| t.seconds).sum::<f64>();
        }
        (self.held, self.scalars) = (Some(*key), lookup.scalars);
        Ok(vec![StageTime {
            name: stage::UPLOAD_TABLES.to_owned(),
            seconds,
        }])
    }
}

/// The nodes of all lights, or a texel that is never read.
fn cache_image(device: &Device, plan: &AmbientScatteringPlan) -> Result<Arc<Image>, GpuError> {
    let desc = ImageDesc {
        image_type: ImageType::TYPE_3D,
        extent: plan.cache.map_or(UVec3::ONE, |c| c.extent()),
        format: plan.cache.map_or(Format::R16G16B16A16_SFLOAT, |c| c.format),
        usage: ImageUsageFlags::STORAGE | ImageUsageFlags::SAMPLED,
    };
    readable(device, Image::new(device, "radiance_cache", desc)?)
}

/// What nodes scatter towards the viewer, or a texel that is never read.
fn gathered_image(device: &Device, plan: &AmbientScatteringPlan) -> Result<Arc<Image>, GpuError> {
    let desc = ImageDesc {
        image_type: ImageType::TYPE_3D,
        extent: plan.gather.map_or(UVec3::ONE, |g| g.extent()),
        format: Format::R32G32B32A32_SFLOAT,
        usage: ImageUsageFlags::STORAGE | ImageUsageFlags::SAMPLED,
    };
    readable(device, Image::new(device, "gathered_light", desc)?)
}

fn readable(device: &Device, image: Image) -> Result<Arc<Image>, GpuError> {
    let mut recorder = Recorder::new(device)?;
    // Nothing was there before; the march finds the layout that its descriptor names.
    recorder.image_barrier(&image, Access::Undefined, Access::ComputeSampledOrLoaded);
    recorder.submit()?;
    Ok(Arc::new(image))
}
