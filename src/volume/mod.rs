//! Volumes: typed voxels on an affine grid, read from files or evaluated from formulas.

mod color;
mod error;
mod geo_tiff;
mod grid;
mod header_text;
mod height_field;
mod meta_image;
mod nifti;
mod nrrd;
mod payload;
mod picture;
pub mod procedural;
mod raw;
mod read;
mod series;
mod source;
mod statistics;
mod voxels;
mod vti;

pub use color::{ColorVolume, read_color};
pub use error::VolumeError;
pub use grid::{Grid, Space};
pub use height_field::{HeightField, HeightMap, Layer, Sheet};
pub use picture::read_picture_colors;
pub use raw::RawLayout;
pub use read::{Format, Progress, ReadOptions, read, read_header};
pub use series::{PLACE, Series};
pub use statistics::Statistics;
pub use voxels::{ScalarType, Voxels};

/// What a file's header says, before any voxel is read.
#[derive(Clone, Debug, PartialEq)]
pub struct Header {
    /// Where the voxels lie in the world.
    pub grid: Grid,
    /// The stored type of a voxel.
    pub scalar_type: ScalarType,
    /// Stored value to data value.
    pub rescale: Rescale,
    /// The file format it was read from.
    pub format: Format,
    /// Number of time steps in the file or series of files; 1 for 3D data.
    pub time_steps: u32,
    /// The file's own word for the world unit (`mm`, `um`, ...), if it has one.
    pub spatial_unit: Option<String>,
}

/// A volume in memory: stored voxels, their place in the world and what they mean.
#[derive(Clone, Debug, PartialEq)]
pub struct Volume {
    /// Name for messages: the file's name or the procedural's.
    pub name: String,
    /// Where the voxels lie in the world.
    pub grid: Grid,
    /// Stored values, x fastest, then y, then z; with a height field one layer, for every z.
    pub voxels: Voxels,
    /// Stored value to data value.
    pub rescale: Rescale,
    /// The world unit's name (`mm`, ...), if known.
    pub spatial_unit: Option<String>,
    /// Where the medium is, if it is a thin layer about a surface and nothing is stored along z.
    pub height_field: Option<HeightField>,
}

/// `data value = slope * stored value + intercept` (NIfTI `scl_slope`, DICOM rescale).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rescale {
    /// Finite, not 0.
    pub slope: f64,
    /// Finite.
    pub intercept: f64,
}

impl Rescale {
    /// Data values are the stored values.
    pub const IDENTITY: Self = Self {
        slope: 1.0,
        intercept: 0.0,
    };

    /// The data value of a stored value.
    #[must_use]
    pub fn apply(self, stored: f64) -> f64 {
        self.slope.mul_add(stored, self.intercept)
    }
}

impl Volume {
    /// Voxels in memory along x, y and z: those of the grid, or one layer of a height field.
    #[must_use]
    pub const fn stored_dims(&self) -> glam::UVec3 {
        let mut dims = self.grid.dims;
        if self.height_field.is_some() {
            dims.z = 1;
        }
        dims
    }

    /// Share of the material's extinction at continuous index `p`: 1 but for height fields.
    #[must_use]
    pub fn share_at(&self, p: glam::DVec3) -> f64 {
        let field = self.height_field.as_ref();
        field.map_or(1.0, |f| f.share(f.above(&self.grid, p)))
    }

    /// The data value (rescaled) of voxel `index` in storage order; NaN and infinities as stored.
    ///
    /// # Panics
    /// If `index` is outside the volume.
    #[must_use]
    pub fn value(&self, index: usize) -> f64 {
        self.rescale.apply(self.voxels.get(index))
    }

    /// The data value at continuous index `p` (0 = centre of the first voxel), trilinear,
    /// clamped in the outer half voxel. The CPU reference of the GPU's filtering.
    #[must_use]
    pub fn sample_index(&self, p: glam::DVec3) -> f64 {
        let dims = self.stored_dims().as_dvec3();
        let p = p.clamp(glam::DVec3::ZERO, dims - 1.0);
        let base = p.floor().min(dims - 2.0).max(glam::DVec3::ZERO);
        let f = p - base;
        let last = self.stored_dims() - 1;
        let mut sum = 0.0;
        for corner in 0..8u32 {
            let o = glam::UVec3::new(corner & 1, (corner >> 1) & 1, corner >> 2);
            let i = (base.as_uvec3() + o).min(last);
            let w = glam::DVec3::select(o.cmpeq(glam::UVec3::ONE), f, 1.0 - f);
            let weight = w.x * w.y * w.z;
            if weight > 0.0 {
                sum += weight * self.value(self.grid.linear_index(i));
            }
        }
        sum
    }
}
