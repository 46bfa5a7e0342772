//! The medium's images and pipelines on the device.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::UVec3;
use rayon::prelude::*;

use super::{CellsPlan, MaterialUniform, MediumPlan, Table, stage};
use crate::gpu::{
    Access, Binding, BindingKind, Buffer, BufferUse, ComputePipeline, Device, Filter, Format,
    GpuError, Image, ImageDesc, ImageType, ImageUsageFlags, Resource, Sampler, SamplerAddressMode,
    SamplerDesc, StageLayout, StageTime, shader, upload_image,
};
use crate::scene::Scene;
use crate::scene::perturbation::{NOISE_SIZE, Noise};
use crate::technique::target::write;
use crate::volume::{Volume, Voxels};

const MIN_MAX: StageLayout = StageLayout {
    shader: shader::MEDIUM_CELL_MIN_MAX,
    bindings: &[
        BindingKind::SampledImage,
        BindingKind::StorageImage,
        BindingKind::SampledImage,
    ],
    push_bytes: 8,
};
const OCCUPANCY: StageLayout = StageLayout {
    shader: shader::MEDIUM_CELL_OCCUPANCY,
    bindings: &[
        BindingKind::SampledImage,
        BindingKind::SampledImage,
        BindingKind::StorageImage,
    ],
    push_bytes: size_of::<OccupancyPush>() as u32,
};
const DISTANCE: StageLayout = StageLayout {
    shader: shader::MEDIUM_CELL_DISTANCE,
    bindings: &[BindingKind::SampledImage, BindingKind::StorageImage],
    push_bytes: 4,
};

/// The interfaces of the medium's stages, for the layout test.
pub const LAYOUTS: &[StageLayout] = &[MIN_MAX, OCCUPANCY, DISTANCE];

/// Push constants of `medium.cell_occupancy`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct OccupancyPush {
    /// Texture value at the table's first entry.
    pub table_min: f32,
    /// Entries a unit of texture value.
    pub table_scale: f32,
}

/// Where the medium lives on the device.
pub struct Medium {
    pub(super) device: Device,
    /// What it was made from.
    pub plan: MediumPlan,
    /// Voxels: to be filtered linearly, or to be loaded, as the plan says.
    pub volume: Resource,
    /// 1 where voxels are finite; 1 x 1 x 1 where all are.
    pub mask: Resource,
    /// `(r, g, b, sigma_t)` over the data range.
    pub transfer_function: Resource,
    /// Distance to the nearest occupied cell; 1 x 1 x 1 without cells.
    pub cell_distance: Resource,
    pub(super) cells: Option<Cells>,
    material: Arc<Buffer>,
    gradient_table: Resource,
    noise: Resource,
    surface_heights: Resource,
    images: Images,
}

struct Images {
    volume: Arc<Image>,
    mask: Arc<Image>,
    table: Arc<Image>,
    gradient_table: Arc<Image>,
    noise: Arc<Image>,
    surface_heights: Arc<Image>,
    cell_distance: Arc<Image>,
}

/// Images and stages of the cells.
pub(super) struct Cells {
    pub(super) plan: CellsPlan,
    pub(super) min_max: Arc<Image>,
    pub(super) occupied_before: Arc<Image>,
    pub(super) distance: Arc<Image>,
    pub(super) pong: Arc<Image>,
    pub(super) min_max_stage: (ComputePipeline, Binding),
    pub(super) occupancy_stage: (ComputePipeline, Binding),
    pub(super) distance_pipeline: ComputePipeline,
    pub(super) to_pong: Binding,
    pub(super) from_pong: Binding,
}

impl Medium {
    /// Creates every image the plan asks for; nothing is uploaded yet.
    ///
    /// # Errors
    /// The driver's refusal or no memory.
    pub fn new(device: &Device, plan: &MediumPlan) -> Result<Self, GpuError> {
        let one = UVec3::ONE;
        let linear = sampler(device, "linear", Filter::LINEAR)?;
        let nearest = sampler(device, "nearest", Filter::NEAREST)?;
        let uploaded = ImageUsageFlags::SAMPLED | ImageUsageFlags::TRANSFER_DST;
        let usage = if plan.loaded {
            uploaded | ImageUsageFlags::STORAGE
        } else {
            uploaded
        };
        let format = plan.encoding.format;
        let volume = image_3d(device, "volume", plan.stored, format, usage)?;
        let mask_dims = if plan.masked { plan.stored } else { one };
        let mask = image_3d(device, "finite_mask", mask_dims, Format::R8_UNORM, uploaded)?;
        let (entries, format) = (plan.table.entries, Format::R32G32B32A32_SFLOAT);
        let table = table_image(device, "transfer_function", entries, format, usage)?;
        let axes = plan.table.gradients;
        let extent = axes.map_or(one, |axis| UVec3::new(entries, axis.entries, 1));
        let image_2d = |name, extent, format| {
            let desc = ImageDesc {
                image_type: ImageType::TYPE_2D,
                extent,
                format,
                usage: uploaded,
            };
            Image::new(device, name, desc).map(Arc::new)
        };
        let gradient_table = image_2d("gradient_table", extent, format)?;
        let extent = if plan.height_field { plan.stored } else { one };
        let surface_heights = image_2d("surface_heights", extent, Format::R32_SFLOAT)?;
        let heights = Resource::Sampled(surface_heights.clone(), linear.clone());
        let edge = if plan.octaves() > 0 {
            NOISE_SIZE as u32
        } else {
            1
        };
        let noise = image_3d(device, "noise", UVec3::splat(edge), format, uploaded)?;
        let repeating = SamplerDesc {
            filter: Filter::LINEAR,
            address_mode: SamplerAddressMode::REPEAT,
        };
        let repeating = Arc::new(Sampler::new(device, "repeating", repeating)?);
        let bytes = size_of::<MaterialUniform>() as u64;
        let material = Arc::new(Buffer::new(device, "material", bytes, BufferUse::Uniform)?);
        let volume_resource = if plan.loaded {
            Resource::SampledGeneral(volume.clone(), linear.clone())
        } else {
            Resource::Sampled(volume.clone(), linear.clone())
        };
        let cells = plan
            .cells
            .map(|c| Cells::new(device, plan, c, (&volume_resource, &heights), &nearest))
            .transpose()?;
        let cell_distance = match &cells {
            Some(cells) => cells.pong.clone(),
            None => image_3d(device, "cell_distance", one, Format::R8_UINT, usage)?,
        };
        let read = |image: &Arc<Image>, sampler: &Arc<Sampler>| {
            if plan.loaded {
                Resource::Storage(image.clone())
            } else {
                Resource::Sampled(image.clone(), sampler.clone())
            }
        };
        Ok(Self {
            device: device.clone(),
            plan: plan.clone(),
            volume: read(&volume, &linear),
            mask: Resource::Sampled(mask.clone(), linear.clone()),
            transfer_function: read(&table, &linear),
            cell_distance: read(&cell_distance, &nearest),
            cells,
            material,
            gradient_table: Resource::Sampled(gradient_table.clone(), linear),
            noise: Resource::Sampled(noise.clone(), repeating),
            surface_heights: heights,
            images: Images {
                volume,
                mask,
                table,
                gradient_table,
                noise,
                surface_heights,
                cell_distance,
            },
        })
    }

    /// A stage's own resources and the material's, as [`with_material`](super::with_material) orders them.
    #[must_use]
    pub fn with_material(&self, mut own: Vec<Resource>) -> Vec<Resource> {
        own.extend([
            Resource::Uniform(self.material.clone()),
            self.gradient_table.clone(),
            self.noise.clone(),
            self.surface_heights.clone(),
        ]);
        own
    }

    /// Writes what stages read of the material beside tables.
    pub fn write_uniforms(&self, scene: &Scene) {
        write(&self.material, &MaterialUniform::new(scene, &self.plan));
    }

    /// Streams the voxels, and the mask if there is one, to the device.
    ///
    /// # Errors
    /// The driver's refusal or no memory for staging.
    pub fn upload_volume(
        &self,
        volume: &Volume,
        progress: &mut dyn FnMut(u64, u64),
    ) -> Result<Vec<StageTime>, GpuError> {
        let encoding = self.plan.encoding;
        let fill = |first, count, target: &mut [u8]| {
            let slice = target.len() / count as usize;
            target
                .par_chunks_mut(slice.max(1))
                .zip(first..first + count)
                .for_each(|(to, z)| {
                    encoding.encode(volume, z, 1, to);
                });
        };
        let (d, i) = (&self.device, &self.images);
        let bytes = encoding.texel_bytes();
        let after = self.plan.reading();
        let name = stage::UPLOAD_VOLUME;
        let mut times = upload_image(d, &i.volume, name, bytes, after, fill, progress)?;
        let mask = |first, count, target: &mut [u8]| fill_mask(volume, first, count, target);
        let (name, after) = (stage::UPLOAD_MASK, Access::ComputeSampled);
        let masked = upload_image(d, &i.mask, name, 1, after, mask, &mut |_, _| {})?;
        if self.plan.masked {
            times.extend(masked);
        }
        if let Some(field) = &volume.height_field {
            let heights = bytemuck::cast_slice(&field.heights);
            let after = Access::ComputeSampled;
            times.extend(self.upload_whole(
                stage::UPLOAD_VOLUME,
                &i.surface_heights,
                4,
                after,
                heights,
            )?);
        }
        self.fill_unused()?;
        Ok(merged(times))
    }

    /// Brings images that are never read to the layout that their descriptors name.
    fn fill_unused(&self) -> Result<(), GpuError> {
        // One texel each.
        let fill = |image, texel: u64, after| {
            let empty = &[0; 16][..texel as usize];
            self.upload_whole("medium.unused", image, texel, after, empty)
        };
        if self.cells.is_none() {
            fill(&self.images.cell_distance, 1, self.plan.reading())?;
        }
        if !self.plan.height_field {
            fill(&self.images.surface_heights, 4, Access::ComputeSampled)?;
        }
        if self.plan.table.gradients.is_none() {
            fill(&self.images.gradient_table, 16, Access::ComputeSampled)?;
        }
        if self.plan.octaves() == 0 {
            fill(&self.images.noise, 16, Access::ComputeSampled)?;
        }
        Ok(())
    }

    /// Copies the transfer function's table to the device.
    ///
    /// # Errors
    /// The driver's refusal or no memory for staging.
    pub fn upload_table(&self, scene: &Scene) -> Result<Vec<StageTime>, GpuError> {
        let (name, baked) = (stage::UPLOAD_TABLE, self.plan.table.bake(scene));
        let row = bytemuck::cast_slice(&baked);
        let mut times =
            self.upload_whole(name, &self.images.table, 16, self.plan.reading(), row)?;
        if let Some(gradients) = self.plan.table.bake_gradients(scene) {
            let rows = bytemuck::cast_slice(&gradients);
            let image = &self.images.gradient_table;
            times.extend(self.upload_whole(name, image, 16, Access::ComputeSampled, rows)?);
        }
        if let (true, Some(p)) = (self.plan.octaves() > 0, &scene.medium.perturbation) {
            let noise = Noise::new(p.seed);
            let texels = bytemuck::cast_slice(noise.texels());
            times.extend(self.upload_whole(
                name,
                &self.images.noise,
                16,
                Access::ComputeSampled,
                texels,
            )?);
        }
        if let Some(cells) = &self.cells {
            let counts = Table::occupied_before(&baked);
            let row = bytemuck::cast_slice(&counts);
            let image = &cells.occupied_before;
            times.extend(self.upload_whole(name, image, 4, Access::ComputeSampled, row)?);
        }
        Ok(merged(times))
    }

    /// Copies a whole image of not much.
    fn upload_whole(
        &self,
        name: &str,
        image: &Image,
        texel: u64,
        after: Access,
        bytes: &[u8],
    ) -> Result<Vec<StageTime>, GpuError> {
        let fill = |_, _, to: &mut [u8]| to.copy_from_slice(bytes);
        upload_image(
            &self.device,
            image,
            name,
            texel,
            after,
            fill,
            &mut |_, _| {},
        )
    }

    /// Texture value at the table's first entry, and entries a unit of texture value.
    #[must_use]
    pub fn table_mapping(&self) -> (f32, f32) {
        let (encoding, table) = (&self.plan.encoding, &self.plan.table);
        let first = encoding.texture_value(table.min);
        let last = encoding.texture_value(table.max);
        (
            first as f32,
            (f64::from(table.entries - 1) / (last - first)) as f32,
        )
    }
}

impl Cells {
    fn new(
        device: &Device,
        plan: &MediumPlan,
        cells: CellsPlan,
        (volume, heights): (&Resource, &Resource),
        nearest: &Arc<Sampler>,
    ) -> Result<Self, GpuError> {
        let usage = ImageUsageFlags::SAMPLED | ImageUsageFlags::STORAGE;
        let storage = |name, format| image_3d(device, name, cells.dims, format, usage);
        let min_max = storage("cell_min_max", plan.encoding.pair_format().0)?;
        let distance = storage("cell_distance", Format::R8_UINT)?;
        let pong = storage("cell_distance_pong", Format::R8_UINT)?;
        let entries = plan.table.entries + 1;
        let uploaded = ImageUsageFlags::SAMPLED | ImageUsageFlags::TRANSFER_DST;
        let format = Format::R32_UINT;
        let occupied_before = table_image(device, "occupied_before", entries, format, uploaded)?;
        let read = |image: &Arc<Image>| Resource::Sampled(image.clone(), nearest.clone());
        let write = |image: &Arc<Image>| Resource::Storage(image.clone());
        let bound = |layout, constants: &[_], resources| {
            let pipeline = ComputePipeline::new(device, layout, constants)?;
            let binding = pipeline.bind(resources)?;
            Ok::<_, GpuError>((pipeline, binding))
        };
        let min_max_stage = bound(
            MIN_MAX,
            &cells.min_max_constants(),
            vec![volume.clone(), write(&min_max), heights.clone()],
        )?;
        let occupancy_stage = bound(
            OCCUPANCY,
            &cells.reach_constants(),
            vec![read(&min_max), read(&occupied_before), write(&distance)],
        )?;
        let distance_pipeline =
            ComputePipeline::new(device, DISTANCE, &cells.distance_constants())?;
        let to_pong = distance_pipeline.bind(vec![read(&distance), write(&pong)])?;
        let from_pong = distance_pipeline.bind(vec![read(&pong), write(&distance)])?;
        Ok(Self {
            plan: cells,
            min_max,
            occupied_before,
            distance,
            pong,
            min_max_stage,
            occupancy_stage,
            distance_pipeline,
            to_pong,
            from_pong,
        })
    }
}

/// One time a stage, of however many copies.
fn merged(times: Vec<StageTime>) -> Vec<StageTime> {
    let mut stages: Vec<StageTime> = Vec::new();
    for time in times {
        match stages.iter_mut().find(|s| s.name == time.name) {
            Some(stage) => stage.seconds += time.seconds,
            None => stages.push(time),
        }
    }
    stages
}

/// Mirrored repetition equals clamping for coordinates in [0, 1], and keeps lavapipe's float filter
/// for 8-bit texels, where clamping would filter in 8 bits.
pub(in crate::technique) fn sampler(
    device: &Device,
    name: &str,
    filter: Filter,
) -> Result<Arc<Sampler>, GpuError> {
    let address_mode = SamplerAddressMode::MIRRORED_REPEAT;
    Sampler::new(
        device,
        name,
        SamplerDesc {
            filter,
            address_mode,
        },
    )
    .map(Arc::new)
}

fn image_3d(
    device: &Device,
    name: &str,
    extent: UVec3,
    format: Format,
    usage: ImageUsageFlags,
) -> Result<Arc<Image>, GpuError> {
    let desc = ImageDesc {
        image_type: ImageType::TYPE_3D,
        extent,
        format,
        usage,
    };
    Image::new(device, name, desc).map(Arc::new)
}

fn table_image(
    device: &Device,
    name: &str,
    entries: u32,
    format: Format,
    usage: ImageUsageFlags,
) -> Result<Arc<Image>, GpuError> {
    let desc = ImageDesc {
        image_type: ImageType::TYPE_1D,
        extent: UVec3::new(entries, 1, 1),
        format,
        usage,
    };
    Image::new(device, name, desc).map(Arc::new)
}

/// 255 where a voxel is finite. Without a mask the image is a single texel, which is never read.
fn fill_mask(volume: &Volume, first: u32, count: u32, target: &mut [u8]) {
    let at = volume.grid.linear_index(UVec3::new(0, 0, first));
    let end = volume.grid.linear_index(UVec3::new(0, 0, first + count));
    target.fill(255);
    if target.len() == end - at {
        match &volume.voxels {
            Voxels::F32(v) => mark(target, &v[at..end], |x| x.is_finite()),
            Voxels::F64(v) => mark(target, &v[at..end], |x| x.is_finite()),
            _ => {}
        }
    }
}

fn mark<T>(target: &mut [u8], voxels: &[T], is_finite: impl Fn(&T) -> bool) {
    for (to, voxel) in target.iter_mut().zip(voxels) {
        *to = if is_finite(voxel) { 255 } else { 0 };
    }
}
