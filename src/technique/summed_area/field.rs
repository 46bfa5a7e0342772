//! What is made of the table: a volume of mean extinctions, or of occlusions, one texel a cell.

use std::sync::Arc;

use bytemuck::bytes_of;
use glam::{DVec3, UVec3};

use super::layout::{AMBIENT_EXTINCTION, BoxPush, OCCLUSION, OcclusionPush};
use super::{SummedArea, SummedAreaPlan, record_sums, summable_radius};
use crate::gpu::{
    Access, ComputePipeline, Device, Format, GpuError, Image, ImageDesc, ImageType,
    ImageUsageFlags, Limits, Recorder, Resource, Sampler, StageLayout, StageTime,
};
use crate::scene::{Radius, Scene};
use crate::technique::medium::{Medium, MediumPlan};
use crate::technique::target::Target;
use crate::technique::{PlanError, ResourceKind, ResourcePlan, StagePlan};

/// What a texel holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FieldKind {
    /// Optical depth of a radius at the mean extinction of the box about the cell's centre.
    AmbientExtinction,
    /// Share of light from all around that reaches the cell's centre through the box, in [0, 1].
    Occlusion,
}

/// Boxes within the smallest one that occlusion is told from, itself counted in.
const SHELLS: f64 = 3.0;

/// Cells whose boxes are summed a submission: each reads up to 384 sums.
const MAX_CELLS: u64 = 1 << 25;

/// A field of one scene: pure data.
#[derive(Clone, Debug, PartialEq)]
pub struct FieldPlan {
    /// What it holds.
    pub kind: FieldKind,
    /// The table that it is made from.
    pub area: SummedAreaPlan,
    /// Radius of the sphere whose volume the box has, world units.
    pub radius: f64,
    /// Cells that the box covers to either side.
    pub half_box: DVec3,
    /// Texture coordinates of the field a unit of texture coordinate of the volume.
    pub scale: DVec3,
}

/// Voxels of an automatic radius of occlusion: wide enough to tell a hollow from a bulge, and near enough that the
/// light beyond may be taken for even.
const AUTO_VOXELS: f64 = 14.0;

/// Radius within which the medium dims an environment's light, world units: 14 voxels where it is automatic (more in
/// grids so large that their sums would not fit), at most half the volume's longest side.
#[must_use]
pub fn occlusion_radius(scene: &Scene, wanted: Radius) -> f64 {
    let grid = &scene.volume.grid;
    let voxels = AUTO_VOXELS * grid.spacing().min_element();
    // Cells suit half the radius.
    let auto = || Radius::within(grid, voxels.max(2.0 * summable_radius(grid)));
    wanted.given(grid).unwrap_or_else(auto)
}

impl FieldPlan {
    /// Plans a field of boxes with the volume of spheres of `radius` world units.
    ///
    /// # Errors
    /// The table would exceed the device's images.
    pub fn new(
        scene: &Scene,
        medium: &MediumPlan,
        kind: FieldKind,
        radius: f64,
        limits: &Limits,
    ) -> Result<Self, PlanError> {
        let finest = match kind {
            FieldKind::AmbientExtinction => radius,
            // The inner shells weigh little: half the radius' fineness will do.
            FieldKind::Occlusion => 0.5 * radius,
        };
        let squares = kind == FieldKind::Occlusion;
        let area = SummedAreaPlan::new(scene, medium, (finest, radius), squares, limits)?;
        Ok(Self {
            kind,
            radius,
            half_box: area.half_box(scene, radius),
            scale: area.cells_per_texture(medium.dims) / area.cells.as_dvec3(),
            area,
        })
    }

    fn layout(&self) -> StageLayout {
        match self.kind {
            FieldKind::AmbientExtinction => AMBIENT_EXTINCTION,
            FieldKind::Occlusion => OCCLUSION,
        }
    }

    /// The field's name: its image and the word of its stage.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        match self.kind {
            FieldKind::AmbientExtinction => "ambient_extinction",
            FieldKind::Occlusion => "occlusion",
        }
    }

    fn slices(&self) -> u32 {
        let n = self.area.cells;
        let most = (MAX_CELLS / (u64::from(n.x) * u64::from(n.y)).max(1)).max(1);
        u32::try_from(most).unwrap_or(u32::MAX).min(n.z)
    }

    /// The stages in order: the table's, then the field's.
    #[must_use]
    pub fn stages(&self) -> Vec<StagePlan> {
        let mut stages = self.area.stages();
        stages.push(StagePlan {
            name: self.layout().shader.name,
            depends_on: SummedAreaPlan::DEPENDS_ON,
            domain: self.area.cells,
            dispatches: self.area.cells.z.div_ceil(self.slices()),
            specialization: Vec::new(),
        });
        stages
    }

    /// The field's memory, and what the tables take meanwhile.
    #[must_use]
    pub fn resources(&self) -> Vec<ResourcePlan> {
        let field = ResourcePlan {
            name: self.name(),
            kind: ResourceKind::Auxiliary,
            extent: self.area.cells,
            format: Format::R16_SFLOAT,
            bytes: 2 * self.area.cells.as_u64vec3().element_product(),
            shrink: "raise the radius: the field is coarser then",
        };
        let mut list = vec![field];
        list.extend(self.area.resources());
        list
    }

    /// Levels to what a texel holds: for occlusion to the optical depth of a shell whose share of the
    /// largest box is 1.
    fn push(&self, first_slice: u32, slice_count: u32) -> BoxPush {
        let volume = 8.0 * self.half_box.element_product();
        let thickness = match self.kind {
            FieldKind::AmbientExtinction => self.radius,
            FieldKind::Occlusion => self.radius / SHELLS,
        };
        BoxPush {
            half_box: self.half_box.as_vec3().to_array(),
            depth_a_level: (thickness / self.area.levels / volume) as f32,
            first_slice,
            slice_count,
        }
    }

    /// The same for the squares of a shell's depth.
    fn occlusion_push(&self, shells: BoxPush) -> OcclusionPush {
        let volume = 8.0 * self.half_box.element_product();
        let thickness = self.radius / SHELLS / self.area.levels;
        let square = thickness * thickness * f64::from(self.area.largest) / volume;
        OcclusionPush {
            shells,
            square_a_level: square as f32,
        }
    }
}

/// A field on the device.
pub struct Field {
    /// What it was made from.
    pub plan: FieldPlan,
    area: SummedArea,
    pipeline: ComputePipeline,
    image: Arc<Image>,
    // Whether the image holds the field of the scene as it was at the last frame.
    filled: bool,
}

impl Field {
    /// Creates pipelines and the image, or takes over from `old` what still fits.
    ///
    /// # Errors
    /// The driver's refusal or no memory.
    pub fn new(device: &Device, plan: &FieldPlan, old: Option<Self>) -> Result<Self, GpuError> {
        let mut filled = false;
        let (mut area, mut pipeline, mut image) = (None, None, None);
        if let Some(old) = old.filter(|o| o.plan.kind == plan.kind) {
            filled = old.filled && old.plan == *plan;
            image = (old.plan.area.cells == plan.area.cells).then_some(old.image);
            (area, pipeline) = (Some(old.area), Some(old.pipeline));
        }
        let area = SummedArea::new(device, &plan.area, area)?;
        let pipeline =
            pipeline.map_or_else(|| ComputePipeline::new(device, plan.layout(), &[]), Ok)?;
        let image = image.map_or_else(|| field_image(device, plan), Ok)?;
        Ok(Self {
            plan: plan.clone(),
            area,
            pipeline,
            image,
            filled,
        })
    }

    /// The field as shaders read it, through a linear filter.
    #[must_use]
    pub fn resource(&self, linear: Arc<Sampler>) -> Resource {
        Resource::SampledGeneral(self.image.clone(), linear)
    }

    /// The image, one texel a cell, 16-bit floats.
    #[must_use]
    pub const fn image(&self) -> &Arc<Image> {
        &self.image
    }

    /// Whether the image holds the field of the scene as it was at the last frame.
    #[must_use]
    pub const fn is_filled(&self) -> bool {
        self.filled
    }

    /// Makes the field anew. The table is there only meanwhile.
    ///
    /// # Errors
    /// The driver's refusal, no memory, or a validation message.
    pub fn record(
        &mut self,
        device: &Device,
        (scene, medium, target): (&Scene, &Medium, &Target),
        progress: &mut dyn FnMut(u64, u64),
    ) -> Result<Vec<StageTime>, GpuError> {
        self.area.write_uniforms(scene, medium);
        let sums = self.area.allocate(device, medium, target)?;
        let mut times = record_sums(device, &self.area, &sums, progress)?;
        let tables = sums.tables().map(|t| Resource::Storage(t.clone()));
        let field = Resource::Storage(self.image.clone());
        let binding = self.pipeline.bind(tables.chain([field]).collect())?;
        let (n, slices) = (self.plan.area.cells, self.plan.slices());
        let name = self.pipeline.name();
        let mut seconds = 0.0;
        let mut first_slice = 0;
        while first_slice < n.z {
            let slice_count = slices.min(n.z - first_slice);
            let push = self.plan.push(first_slice, slice_count);
            let mut recorder = Recorder::new(device)?;
            if first_slice == 0 {
                // WAR: earlier stages have read what is written anew.
                recorder.image_barrier(
                    &self.image,
                    Access::ComputeSampledOrLoaded,
                    Access::ComputeWrite,
                );
            }
            recorder.compute_stage(name, |r| {
                let domain = UVec3::new(n.x, n.y, slice_count);
                let occlusion = self.plan.occlusion_push(push);
                let push = match self.plan.kind {
                    FieldKind::AmbientExtinction => bytes_of(&push),
                    FieldKind::Occlusion => bytes_of(&occlusion),
                };
                r.dispatch(&self.pipeline, &binding, push, domain);
            });
            first_slice += slice_count;
            if first_slice == n.z {
                // RAW: later stages read what the slabs wrote.
                recorder.image_barrier(
                    &self.image,
                    Access::ComputeWrite,
                    Access::ComputeSampledOrLoaded,
                );
            }
            seconds += recorder.submit()?.iter().map(|t| t.seconds).sum::<f64>();
        }
        self.filled = true;
        times.push(StageTime {
            name: name.to_owned(),
            seconds,
        });
        Ok(times)
    }
}

fn field_image(device: &Device, plan: &FieldPlan) -> Result<Arc<Image>, GpuError> {
    let desc = ImageDesc {
        image_type: ImageType::TYPE_3D,
        extent: plan.area.cells,
        format: Format::R16_SFLOAT,
        usage: ImageUsageFlags::STORAGE | ImageUsageFlags::SAMPLED | ImageUsageFlags::TRANSFER_SRC,
    };
    let image = Image::new(device, plan.name(), desc)?;
    let mut recorder = Recorder::new(device)?;
    // Nothing was there before; readers find the layout that their descriptors name.
    recorder.image_barrier(&image, Access::Undefined, Access::ComputeSampledOrLoaded);
    recorder.submit()?;
    Ok(Arc::new(image))
}
