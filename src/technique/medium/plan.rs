//! Which parts of the medium a scene needs on the device.

use glam::{DVec3, UVec3};

use super::{Encoding, Table};
use crate::gpu::{Access, Format, Limits, Specialization};
use crate::scene::{Octave, Perturbation, Scene};
use crate::technique::{Input, Inputs, Omission, PlanError, StagePlan};

/// Stage names of the medium.
pub mod stage {
    /// Copy of the voxels to the device.
    pub const UPLOAD_VOLUME: &str = "medium.upload_volume";
    /// Copy of the mask of finite voxels.
    pub const UPLOAD_MASK: &str = "medium.upload_mask";
    /// Copy of the transfer function's table.
    pub const UPLOAD_TABLE: &str = "medium.upload_table";
    /// Smallest and largest voxel of every cell.
    pub const CELL_MIN_MAX: &str = "medium.cell_min_max";
    /// Which cells the transfer function leaves empty.
    pub const CELL_OCCUPANCY: &str = "medium.cell_occupancy";
    /// Distance from every cell to the nearest occupied one.
    pub const CELL_DISTANCE: &str = "medium.cell_distance";
}

/// Voxels along the edge of a cell: small enough to follow thin shells, large enough that the
/// pairs take 1/32 of the volume.
const CELL_SIZE: u32 = 4;

/// Most cells of a height field, which keeps little else for every place.
const MOST_SPARSE: u64 = 1 << 20;

/// Longest distance kept, in cells: one look-up skips at most about this many.
const REACH: u32 = 15;

/// Most cells by which noise may move what is looked up: distances are kept in 8 bits.
const MOST_WIDEN: u32 = 200;

/// Voxels by which noise moves what is looked up, at most, along the grid's axes.
#[must_use]
pub fn reach_of_noise(scene: &Scene) -> DVec3 {
    let perturbation = scene.medium.perturbation.as_ref();
    let furthest = perturbation.map_or(0.0, Perturbation::largest_displacement);
    let index_from_world = scene.volume.grid.world_from_index.matrix3.inverse();
    let along = |v: DVec3| v.abs();
    // Along each axis of the world by as much, in the worst direction.
    let sum = along(index_from_world.x_axis)
        + along(index_from_world.y_axis)
        + along(index_from_world.z_axis);
    // A little room for the device's rounding.
    furthest * sum * (1.0 + 1e-4)
}

/// Edge of a height field's cells, voxels: as few cells as suit a map, not a volume.
fn sparse_cell(dims: UVec3) -> u32 {
    let cells = |size: u32| ((dims + size - 1) / size).as_u64vec3().element_product();
    let sizes = (0..12).map(|i| CELL_SIZE << i);
    let mut sizes = sizes.filter(|size| cells(*size) <= MOST_SPARSE);
    sizes.next().unwrap_or(CELL_SIZE << 12)
}

/// The cells for empty-space skipping, or why there are none.
fn cells(scene: &Scene, table: &Table) -> Result<CellsPlan, &'static str> {
    let dims = scene.volume.grid.dims;
    let height_field = scene.volume.height_field.is_some();
    let size = if height_field {
        sparse_cell(dims)
    } else {
        CELL_SIZE
    };
    let along = (dims + size - 1) / size;
    let widen = reach_of_noise(scene).max_element() / f64::from(size);
    if !height_field && !Table::has_empty_range(&table.bake(scene)) {
        return Err("the transfer function leaves no data value empty");
    }
    if widen >= f64::from(along.max_element().min(MOST_WIDEN)) {
        return Err("noise moves what is looked up too far");
    }
    Ok(CellsPlan {
        size,
        height_field,
        dims: along,
        reach: REACH,
        widen: widen.ceil() as u32,
    })
}

/// Refuses what the device's images cannot hold or filter.
fn check_limits(scene: &Scene, limits: &Limits) -> Result<(), PlanError> {
    let stored = scene.volume.stored_dims();
    let height_field = scene.volume.height_field.is_some();
    if stored.max_element() > limits.max_image_3d {
        let fix = if height_field {
            "raise volume.height_field.level"
        } else {
            "resample or crop the volume"
        };
        return Err(PlanError::Limit {
            what: format!("volume {}", scene.volume.name),
            found: format!("{} x {} x {} voxels", stored.x, stored.y, stored.z),
            limit: format!(
                "the device's 3D images reach {} along an axis",
                limits.max_image_3d
            ),
            fix: fix.to_owned(),
        });
    }
    let unfiltered = |what: &str, images: &str| {
        Err(PlanError::Limit {
            what: what.to_owned(),
            found: format!("needs linear filtering of {images} images"),
            limit: "the device has none".to_owned(),
            fix: "use another device (`tyndall devices`)".to_owned(),
        })
    };
    if !limits.linear_rgba32_sfloat {
        return unfiltered("transfer function", "four-channel 32-bit float");
    }
    if height_field && !limits.linear_r32_sfloat {
        return unfiltered("surface_heights", "32-bit float");
    }
    Ok(())
}

/// The medium's device data for one scene.
#[derive(Clone, Debug, PartialEq)]
pub struct MediumPlan {
    /// Voxels along x, y, z.
    pub dims: UVec3,
    /// Of them in memory: one layer of a height field.
    pub stored: UVec3,
    /// Whether the medium is a layer about a surface.
    pub height_field: bool,
    /// Texel format.
    pub encoding: Encoding,
    /// Whether techniques load and filter the medium's texels themselves ([`Limits::prefers_loads`]).
    pub loaded: bool,
    /// Whether some voxels are NaN or infinite and need a mask.
    pub masked: bool,
    /// The transfer function's table.
    pub table: Table,
    /// Cells for empty-space skipping; `None` where nothing can be skipped.
    pub cells: Option<CellsPlan>,
    why_no_cells: &'static str,
    /// Octaves of noise that move places, and that vary the material.
    pub displaced: u32,
    /// See `displaced`.
    pub varied: u32,
}

/// A coarse grid over the volume.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CellsPlan {
    /// Voxels along the edge of a cell.
    pub size: u32,
    /// Whether the medium is met only about a surface.
    pub height_field: bool,
    /// Cells along x, y, z.
    pub dims: UVec3,
    /// Longest distance kept, in cells.
    pub reach: u32,
    /// Cells by which noise moves what is looked up, at most, along any axis.
    pub widen: u32,
}

impl MediumPlan {
    /// Which of four forms of a stage suits the medium: that which reads through the device's filter, or those by
    /// loads of 8-bit, 16-bit and float texels.
    #[must_use]
    pub const fn form(&self) -> usize {
        match (self.loaded, self.encoding.format) {
            (false, _) => 0,
            (true, Format::R8_UNORM) => 1,
            (true, Format::R16_UNORM) => 2,
            (true, _) => 3,
        }
    }

    /// Decides formats and sizes; `no_skipping` says why the technique does not skip empty space, if
    /// it does not.
    ///
    /// # Errors
    /// The volume exceeds a limit of the device.
    pub fn new(
        scene: &Scene,
        no_skipping: Option<&'static str>,
        limits: &Limits,
    ) -> Result<Self, PlanError> {
        check_limits(scene, limits)?;
        let table = Table::choose(scene, limits);
        let perturbation = scene.medium.perturbation.as_ref();
        let octaves = |of: fn(&Octave) -> bool| {
            let octaves = perturbation.iter().flat_map(|p| &p.octaves);
            u32::try_from(octaves.filter(|o| of(o)).count()).unwrap_or(u32::MAX)
        };
        let (cells, why_no_cells) = match no_skipping.map_or_else(|| cells(scene, &table), Err) {
            Ok(cells) => (Some(cells), ""),
            Err(why) => (None, why),
        };
        Ok(Self {
            dims: scene.volume.grid.dims,
            stored: scene.volume.stored_dims(),
            height_field: scene.volume.height_field.is_some(),
            encoding: Encoding::choose(&scene.volume, &scene.statistics, limits)?,
            loaded: limits.prefers_loads,
            masked: scene.statistics.nan + scene.statistics.infinite > 0,
            table,
            cells,
            why_no_cells,
            displaced: octaves(|o| o.displacement > 0.0),
            varied: octaves(Octave::varies),
        })
    }

    /// How techniques read volume, table and distances.
    #[must_use]
    pub fn reading(&self) -> Access {
        if self.loaded {
            Access::ComputeSampledOrLoaded
        } else {
            Access::ComputeSampled
        }
    }

    /// Octaves of noise, those that do both counted twice.
    #[must_use]
    pub const fn octaves(&self) -> u32 {
        self.displaced + self.varied
    }

    /// The stages in order.
    #[must_use]
    pub fn stages(&self) -> Vec<StagePlan> {
        let volume = Inputs::of(&[Input::Volume]);
        // A volume of another range has another plan, and all is made anew.
        let table = Inputs::of(&[Input::TransferFunction]);
        let occupancy = volume.union(table);
        let stage = |name, depends_on, domain, dispatches, specialization| StagePlan {
            name,
            depends_on,
            domain,
            dispatches,
            specialization,
        };
        let row = UVec3::new(self.table.entries, 1, 1);
        let mut stages = vec![stage(stage::UPLOAD_VOLUME, volume, self.stored, 1, vec![])];
        if self.masked {
            stages.push(stage(stage::UPLOAD_MASK, volume, self.stored, 1, vec![]));
        }
        stages.push(stage(
            stage::UPLOAD_TABLE,
            table,
            row,
            1 + u32::from(self.cells.is_some())
                + u32::from(self.table.gradients.is_some())
                + u32::from(self.octaves() > 0),
            vec![],
        ));
        if let Some(c) = self.cells {
            stages.extend([
                stage(
                    stage::CELL_MIN_MAX,
                    volume,
                    c.dims,
                    1,
                    c.min_max_constants(),
                ),
                stage(
                    stage::CELL_OCCUPANCY,
                    occupancy,
                    c.dims,
                    1,
                    c.reach_constants(),
                ),
                stage(
                    stage::CELL_DISTANCE,
                    occupancy,
                    c.dims,
                    3,
                    c.distance_constants(),
                ),
            ]);
        }
        stages
    }

    /// What the scene does not need of the medium.
    #[must_use]
    pub fn omitted(&self) -> Vec<Omission> {
        let mut list = Vec::new();
        if !self.masked {
            let why = "every voxel is finite".to_owned();
            list.push(Omission {
                what: "finite_mask",
                why,
            });
        }
        if !self.height_field {
            list.push(Omission {
                what: "surface_heights",
                why: "the volume is no height field".to_owned(),
            });
        }
        if self.octaves() == 0 {
            list.push(Omission {
                what: "noise",
                why: "the scene has no medium.perturbation".to_owned(),
            });
        }
        if self.table.gradients.is_none() {
            list.push(Omission {
                what: "gradient_table",
                why: "the transfer function looks at values alone".to_owned(),
            });
        }
        if self.cells.is_none() {
            list.push(Omission {
                what: "cells",
                why: self.why_no_cells.to_owned(),
            });
        }
        list
    }
}

impl CellsPlan {
    /// Constants of `medium.cell_min_max`.
    #[must_use]
    pub fn min_max_constants(&self) -> Vec<Specialization> {
        let own = [
            Specialization::new(0, "CELL_SIZE"),
            Specialization::new(1, "HEIGHT_FIELD"),
        ];
        Specialization::with_values(&own, &[self.size, u32::from(self.height_field)])
    }

    /// Constants of `medium.cell_occupancy`: distances before they are widened.
    #[must_use]
    pub fn reach_constants(&self) -> Vec<Specialization> {
        vec![Specialization {
            id: 0,
            name: "REACH",
            value: self.reach + self.widen,
        }]
    }

    /// Constants of `medium.cell_distance`.
    #[must_use]
    pub fn distance_constants(&self) -> Vec<Specialization> {
        let mut constants = self.reach_constants();
        constants.push(Specialization {
            id: 1,
            name: "WIDEN",
            value: self.widen,
        });
        constants
    }
}
