//! How finely a scene's extinction is summed.

use glam::{DVec3, UVec3};

use super::{ScanForm, layout};
use crate::gpu::{Format, Limits, Specialization, StageLayout};
use crate::scene::{Perturbation, Scene};
use crate::technique::medium::MediumPlan;
use crate::technique::{Input, Inputs, PlanError, ResourceKind, ResourcePlan, StagePlan};
use crate::volume::Grid;

/// Stage names.
pub mod stage {
    /// Extinction of every cell, the volume read through the device's filter.
    pub const EXTINCTION: &str = "summed_area.extinction";
    /// The same by loads of 8-bit texels.
    pub const EXTINCTION_R8: &str = "summed_area.extinction_r8";
    /// The same by loads of 16-bit texels.
    pub const EXTINCTION_R16: &str = "summed_area.extinction_r16";
    /// The same by loads of float texels.
    pub const EXTINCTION_R32F: &str = "summed_area.extinction_r32f";
    /// Running sums along x, y and z, one invocation a line.
    pub const SCAN: &str = "summed_area.scan";
    /// Running sums along x, a subgroup a line.
    pub const SCAN_SUBGROUP: &str = "summed_area.scan_subgroup";
    /// Running sums along y and z, several invocations a line.
    pub const SCAN_SEGMENTS: &str = "summed_area.scan_segments";
    /// Mean extinction of a box about every cell.
    pub const AMBIENT_EXTINCTION: &str = "summed_area.ambient_extinction";
    /// Occlusion by three boxes about every cell.
    pub const OCCLUSION: &str = "summed_area.occlusion";
}

/// Constants of `summed_area.extinction`, in the order of their ids.
pub const CONSTANTS: [Specialization; 7] = [
    Specialization::new(0, "SKIP_EMPTY"),
    Specialization::new(1, "MASKED"),
    Specialization::new(2, "CLIP_BOX"),
    Specialization::new(3, "CLIP_PLANE"),
    Specialization::new(4, "MEDIUM_CELL"),
    Specialization::new(5, "SPLIT"),
    Specialization::new(6, "SQUARES"),
];

/// Cells along a radius, at least, where voxels are not coarser: a box is then sharp enough (the README has
/// the error) and the table small.
const CELLS_A_RADIUS: f64 = 2.5;

/// Cells along the longest side, at least, where the radius asks for them: the volume's faces are as sharp as
/// its inside, whatever the voxels.
const MIN_CELLS: f64 = 48.0;

/// Voxels classified a submission, so that none runs long.
const MAX_VOXELS: u64 = 1 << 28;

/// Levels that the sum over a box may reach, so that differences of sums have a sign.
const MAX_SUM: f64 = (1u64 << 31) as f64 * 0.98;

/// Most levels of one cell: a 32-bit float holds every whole number up to here.
const MAX_LEVEL: f64 = (1 << 24) as f64;

/// Cells, levels and slabs: pure data.
#[derive(Clone, Debug, PartialEq)]
pub struct SummedAreaPlan {
    /// Voxels of a cell along x, y, z.
    pub cell: UVec3,
    /// Cells of a voxel along x, y, z; above 1 only where voxels are coarse and `cell` is 1.
    pub split: UVec3,
    /// Cells along x, y, z.
    pub cells: UVec3,
    /// Levels a unit of extinction (per world unit): what a cell holds of its mean extinction.
    pub levels: f64,
    /// Most levels of a cell, a whole number; of squares too.
    pub largest: u32,
    /// Whether squares of extinctions are summed too.
    pub squares: bool,
    /// Slices of cells a submission.
    pub slices_per_submission: u32,
    /// How running sums are made: what is fastest on the device.
    pub scan: ScanForm,
    /// Constants of `summed_area.extinction`.
    pub constants: Vec<Specialization>,
    // Which of the extinction stages reads the volume as the medium holds it.
    reading: usize,
}

/// Most cells that an automatic radius may ask for: half a gigabyte of sums.
const MOST_CELLS: f64 = (1 << 27) as f64;

/// Smallest radius whose sums have no more than 2^27 cells, world units; 0 where any has.
#[must_use]
pub fn summable_radius(grid: &Grid) -> f64 {
    let voxels_a_cell = (grid.voxel_count() as f64 / MOST_CELLS).cbrt().ceil();
    if voxels_a_cell > 1.0 {
        CELLS_A_RADIUS * voxels_a_cell * grid.spacing().max_element()
    } else {
        0.0
    }
}

/// Side of the cube that has the volume of a sphere of this radius.
#[must_use]
pub fn box_side(radius: f64) -> f64 {
    radius * (4.0 / 3.0 * std::f64::consts::PI).cbrt()
}

impl SummedAreaPlan {
    /// Cells for cubes with the volume of spheres of radius `finest` to `widest`, world units; `squares`: whether
    /// a second table sums squares.
    ///
    /// # Errors
    /// The table would exceed the device's images.
    pub fn new(
        scene: &Scene,
        medium: &MediumPlan,
        (finest, widest): (f64, f64),
        squares: bool,
        limits: &Limits,
    ) -> Result<Self, PlanError> {
        let spacing = scene.volume.grid.spacing();
        let split = split(scene, finest);
        let most = (finest / CELLS_A_RADIUS / spacing).max(DVec3::ONE);
        let coarse = most.floor().min(medium.dims.as_dvec3()).as_uvec3();
        // Parts of voxels along one axis do not mix with several along another.
        let cell = if split == UVec3::ONE {
            coarse
        } else {
            UVec3::ONE
        };
        let cells = (medium.dims * split + cell - 1) / cell;
        let side = box_side(widest) / (spacing * cell.as_dvec3() / split.as_dvec3());
        // The whole cells that a box touches.
        let touched = (side + 2.0).min(cells.as_dvec3()).element_product();
        let baked = medium.table.bake(scene);
        let densest = baked.iter().map(|e| f64::from(e[3])).fold(0.0, f64::max);
        let perturbation = scene.medium.perturbation.as_ref();
        let densest = densest * (1.0 + perturbation.map_or(0.0, Perturbation::largest_variation));
        let largest = (MAX_SUM / touched).min(MAX_LEVEL).floor();
        let per_slice = medium.dims.x as u64 * medium.dims.y as u64 * u64::from(cell.z);
        let slices = (MAX_VOXELS / per_slice.max(1)).clamp(1, u64::from(cells.z));
        let values = [
            u32::from(medium.cells.is_some()),
            u32::from(medium.masked),
            u32::from(scene.clip.bounds.is_some()),
            u32::from(scene.clip.plane.is_some()),
            medium.cells.map_or(1, |c| c.size),
            u32::from(split.max_element() > 1),
            u32::from(squares),
        ];
        let plan = Self {
            cell,
            split,
            cells,
            // A whole number of levels for the densest voxel: a medium of one opacity is summed exactly.
            levels: if densest > 0.0 {
                largest / densest
            } else {
                1.0
            },
            largest: largest as u32,
            squares,
            slices_per_submission: u32::try_from(slices).unwrap_or(1),
            constants: medium.with_constants(&CONSTANTS, &values),
            scan: ScanForm::new(limits),
            reading: medium.form(),
        };
        if plan.cells.max_element() > limits.max_image_3d {
            return Err(PlanError::Limit {
                what: "sums".to_owned(),
                found: format!(
                    "{} x {} x {} cells",
                    plan.cells.x, plan.cells.y, plan.cells.z
                ),
                limit: format!("the device's 3D images reach {}", limits.max_image_3d),
                fix: "raise the radius".to_owned(),
            });
        }
        Ok(plan)
    }

    /// What the sums are made from.
    pub const DEPENDS_ON: Inputs =
        Inputs::of(&[Input::Volume, Input::TransferFunction, Input::Clip]);

    /// The stage that reads the volume as the medium holds it.
    #[must_use]
    pub const fn extinction(&self) -> StageLayout {
        layout::LAYOUTS[self.reading]
    }

    /// Submissions that fill the cells.
    #[must_use]
    pub const fn submissions(&self) -> u32 {
        self.cells.z.div_ceil(self.slices_per_submission)
    }

    /// The stages in order.
    #[must_use]
    pub fn stages(&self) -> Vec<StagePlan> {
        let stage = |name, dispatches, specialization| StagePlan {
            name,
            depends_on: Self::DEPENDS_ON,
            domain: self.cells,
            dispatches,
            specialization,
        };
        let mut stages = vec![stage(
            self.extinction().shader.name,
            self.submissions(),
            self.constants.clone(),
        )];
        stages.extend(
            self.scan
                .stages()
                .iter()
                .map(|(name, axes)| stage(*name, axes.len() as u32 * self.tables(), Vec::new())),
        );
        stages
    }

    /// Tables: of extinctions, and of their squares.
    const fn tables(&self) -> u32 {
        1 + self.squares as u32
    }

    /// The tables' memory, held only while what reads them is made.
    #[must_use]
    pub fn resources(&self) -> Vec<ResourcePlan> {
        let names = ["sums", "squares"].into_iter();
        let table = |name| ResourcePlan {
            name,
            kind: ResourceKind::Staging,
            extent: self.cells,
            format: Format::R32_UINT,
            bytes: 4 * self.cells.as_u64vec3().element_product(),
            shrink: "raise the radius: wider boxes are summed over coarser cells",
        };
        names.take(self.tables() as usize).map(table).collect()
    }

    /// Cells that a box around a point covers to either side along x, y, z, where the box is a cube with
    /// the volume of a sphere of `radius`, world units.
    #[must_use]
    pub fn half_box(&self, scene: &Scene, radius: f64) -> DVec3 {
        let cell = scene.volume.grid.spacing() * self.cell.as_dvec3() / self.split.as_dvec3();
        0.5 * box_side(radius) / cell
    }

    /// Cells a unit of texture coordinate, and that over the number of cells: the last cells may reach
    /// beyond the volume.
    #[must_use]
    pub fn cells_per_texture(&self, dims: UVec3) -> DVec3 {
        dims.as_dvec3() * self.split.as_dvec3() / self.cell.as_dvec3()
    }
}

/// Parts of a voxel that are cells of their own, where voxels are coarse beside the radius and few.
fn split(scene: &Scene, finest: f64) -> UVec3 {
    let grid = &scene.volume.grid;
    let size = grid.spacing() * grid.dims.as_dvec3();
    let wanted = (finest / CELLS_A_RADIUS).max(size.max_element() / MIN_CELLS);
    (grid.spacing() / wanted).floor().max(DVec3::ONE).as_uvec3()
}
