//! The technique's images, buffers and pipeline.

use std::sync::Arc;

use glam::UVec3;

use super::environment::{Environment, Maps};
use super::plan::WALKER_LAYERS;
use super::{PathTracePlan, TraceUniform, leaves, stage};
use crate::gpu::{
    Access, Binding, Buffer, BufferUse, ComputePipeline, Device, Filter, Format, GpuError, Image,
    ImageDesc, ImageType, ImageUsageFlags, Resource, StageTime, download_image, upload_image,
};
use crate::scene::Scene;
use crate::technique::albedo_volume::AlbedoImage;
use crate::technique::medium::{Medium, sampler};
use crate::technique::target::{Target, write};
use crate::technique::{Input, Inputs};

/// Everything of `path_trace` on the device.
pub struct PathTrace {
    /// What it was made from.
    pub plan: PathTracePlan,
    pub(super) pipeline: ComputePipeline,
    pub(super) binding: Binding,
    pub(super) radiance: Arc<Image>,
    pub(super) buffers: Buffers,
    maps: Maps,
    albedo: AlbedoImage,
    leaves: Arc<Image>,
    // Whether `leaves` holds anything yet.
    filled: bool,
    /// Samples that every pixel has.
    pub samples: u32,
}

/// What a walk keeps between dispatches.
pub(super) struct Buffers {
    pub(super) moments: Arc<Image>,
    pub(super) walkers: Arc<Image>,
    pub(super) counters: Arc<Image>,
    pub(super) counters_read_back: Buffer,
    trace: Arc<Buffer>,
}

impl PathTrace {
    /// Creates what the plan asks for beside medium and target, or takes over from `old` what still
    /// fits.
    ///
    /// # Errors
    /// The driver's refusal or no memory.
    pub fn new(
        device: &Device,
        plan: &PathTracePlan,
        medium: &Medium,
        target: &Target,
        old: Option<Self>,
    ) -> Result<Self, GpuError> {
        let (mut pipeline, mut buffers, mut leaves) = (None, None, None);
        let (mut maps, mut albedo) = (None, None);
        let (mut filled, mut samples) = (false, 0);
        if let Some(old) = old {
            pipeline = (old.plan.specialization == plan.specialization
                && old.plan.trace().shader.name == plan.trace().shader.name)
                .then_some(old.pipeline);
            buffers = (old.plan.image == plan.image).then_some(old.buffers);
            samples = old.samples;
            (maps, albedo) = (Some(old.maps), Some(old.albedo));
            filled = old.filled && old.plan.leaves == plan.leaves;
            leaves = (old.plan.leaves == plan.leaves).then_some(old.leaves);
        }
        let pipeline = pipeline.map_or_else(
            || ComputePipeline::new(device, plan.trace(), &plan.specialization),
            Ok,
        )?;
        let buffers = buffers.map_or_else(|| Buffers::new(device, plan.image), Ok)?;
        let leaves = leaves.map_or_else(|| leaves_image(device, plan), Ok)?;
        let maps = Maps::new(device, plan.maps, maps)?;
        let albedo = AlbedoImage::new(device, plan.albedo, albedo)?;
        let nearest = sampler(device, "nearest", Filter::NEAREST)?;
        let linear = sampler(device, "linear", Filter::LINEAR)?;
        let binding = pipeline.bind(medium.with_material(vec![
            Resource::Uniform(target.view.clone()),
            Resource::Uniform(buffers.trace.clone()),
            medium.volume.clone(),
            medium.transfer_function.clone(),
            Resource::Storage(leaves.clone()),
            medium.mask.clone(),
            Resource::Storage(target.radiance.clone()),
            Resource::Storage(buffers.moments.clone()),
            Resource::Storage(buffers.walkers.clone()),
            Resource::Storage(buffers.counters.clone()),
            albedo.resource(linear),
            Resource::Sampled(maps.map.clone(), nearest.clone()),
            Resource::Sampled(maps.alias.clone(), nearest),
        ]))?;
        Ok(Self {
            plan: plan.clone(),
            pipeline,
            binding,
            radiance: target.radiance.clone(),
            buffers,
            maps,
            albedo,
            leaves,
            filled,
            samples,
        })
    }

    /// Squared standard error of every pixel of the last image; NaN after one sample.
    ///
    /// # Errors
    /// The driver's refusal or no memory.
    pub fn variance(&self, device: &Device) -> Result<Vec<[f32; 3]>, GpuError> {
        let n = f64::from(self.samples);
        let scale = 1.0 / (n * (n - 1.0));
        let squares = download(device, &self.buffers.moments)?;
        let variance = |[r, g, b, _]: &[f32; 4]| [r, g, b].map(|s| (f64::from(*s) * scale) as f32);
        Ok(squares.iter().map(variance).collect())
    }

    /// Root mean square of the pixels' standard errors, relative to the image's mean radiance.
    ///
    /// # Errors
    /// The driver's refusal or no memory.
    pub(super) fn relative_error(&self, device: &Device) -> Result<f64, GpuError> {
        let rgb = |[r, g, b]: [f32; 3]| f64::from(r) + f64::from(g) + f64::from(b);
        let variance: f64 = self.variance(device)?.into_iter().map(rgb).sum();
        let radiance = download(device, &self.radiance)?;
        let mean: f64 = radiance.iter().map(|p| rgb([p[0], p[1], p[2]])).sum();
        let n = 3.0 * radiance.len() as f64;
        // A black image is exact.
        Ok(if variance > 0.0 {
            (variance / n).sqrt() / (mean / n)
        } else {
            0.0
        })
    }

    /// Brings leaves, environment map and albedo volume up to date; `changed` says what differs from the
    /// last frame.
    ///
    /// # Errors
    /// The driver's refusal or no memory for staging.
    pub fn upload(
        &mut self,
        device: &Device,
        scene: &Scene,
        medium: &Medium,
        changed: Inputs,
    ) -> Result<Vec<StageTime>, GpuError> {
        let mut times = self.upload_leaves(device, scene, medium, changed)?;
        let map = Environment::of(scene).map(|e| e.map);
        times.extend(self.maps.upload(device, map)?);
        times.extend(self.albedo.upload(device, scene, stage::UPLOAD_ALBEDO)?);
        Ok(times)
    }

    fn upload_leaves(
        &mut self,
        device: &Device,
        scene: &Scene,
        medium: &Medium,
        changed: Inputs,
    ) -> Result<Vec<StageTime>, GpuError> {
        let media = Inputs::of(&[Input::Volume, Input::TransferFunction]);
        if self.filled && !changed.intersects(media) {
            return Ok(Vec::new());
        }
        let bounds = match self.plan.leaves {
            Some(_) => leaves::leaves(scene, &medium.plan.table),
            None => vec![[0; 2]],
        };
        let bytes: &[u8] = bytemuck::cast_slice(&bounds);
        let slice = bytes.len() / self.leaves.desc().extent.z as usize;
        let fill = |first: u32, _, to: &mut [u8]| {
            let at = first as usize * slice;
            to.copy_from_slice(&bytes[at..at + to.len()]);
        };
        let (after, name) = (Access::ComputeReadWrite, stage::UPLOAD_LEAVES);
        let times = upload_image(device, &self.leaves, name, 8, after, fill, &mut |_, _| {})?;
        self.filled = true;
        Ok(if self.plan.leaves.is_some() {
            times
        } else {
            Vec::new()
        })
    }

    /// Writes medium and lights; the next walk reads them.
    pub fn write_uniforms(&self, scene: &Scene, medium: &Medium) {
        write(&self.buffers.trace, &TraceUniform::new(scene, medium));
    }
}

impl Buffers {
    fn new(device: &Device, [width, height]: [u32; 2]) -> Result<Self, GpuError> {
        let image = |name, image_type, extent, format, usage| {
            let desc = ImageDesc {
                image_type,
                extent,
                format,
                usage: ImageUsageFlags::STORAGE | usage,
            };
            Image::new(device, name, desc).map(Arc::new)
        };
        let (none, flat) = (ImageUsageFlags::empty(), ImageType::TYPE_2D);
        let (float, word) = (Format::R32G32B32A32_SFLOAT, Format::R32G32B32A32_UINT);
        let pixels = UVec3::new(width, height, 1);
        let moments = image(
            "moments",
            flat,
            pixels,
            float,
            ImageUsageFlags::TRANSFER_SRC,
        )?;
        let layers = UVec3::new(width, height, WALKER_LAYERS);
        let walkers = image("walkers", ImageType::TYPE_3D, layers, word, none)?;
        let copied = ImageUsageFlags::TRANSFER_SRC | ImageUsageFlags::TRANSFER_DST;
        let two = UVec3::new(2, 1, 1);
        let counters = image("counters", flat, two, Format::R32_UINT, copied)?;
        // Shaders only ever add to the counters; the host looks at the differences.
        let (after, zero) = (Access::ComputeReadWrite, |_, _, to: &mut [u8]| to.fill(0));
        upload_image(
            device,
            &counters,
            "counters",
            4,
            after,
            zero,
            &mut |_, _| {},
        )?;
        let bytes = size_of::<TraceUniform>() as u64;
        Ok(Self {
            moments,
            walkers,
            counters,
            counters_read_back: Buffer::new(device, "counters_read_back", 8, BufferUse::Readback)?,
            trace: Arc::new(Buffer::new(device, "trace", bytes, BufferUse::Uniform)?),
        })
    }
}

fn leaves_image(device: &Device, plan: &PathTracePlan) -> Result<Arc<Image>, GpuError> {
    let desc = ImageDesc {
        image_type: ImageType::TYPE_3D,
        extent: plan.leaves.unwrap_or(UVec3::ONE),
        format: Format::R32G32_UINT,
        usage: ImageUsageFlags::STORAGE | ImageUsageFlags::TRANSFER_DST,
    };
    Image::new(device, "leaves", desc).map(Arc::new)
}

/// The texels of an RGBA float image that the walk has written.
fn download(device: &Device, image: &Image) -> Result<Vec<[f32; 4]>, GpuError> {
    let bytes = 16 * image.desc().extent.as_u64vec3().element_product();
    let read_back = Buffer::new(device, "statistics_read_back", bytes, BufferUse::Readback)?;
    download_image(device, image, &read_back, stage::READ_BACK)?;
    let texels = |bytes: &[u8]| {
        bytes
            .chunks_exact(16)
            .map(bytemuck::pod_read_unaligned)
            .collect()
    };
    Ok(read_back.with_bytes(|bytes| texels(bytes)))
}
