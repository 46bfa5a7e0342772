//! Height fields: a surface over a plane with a thin layer of the medium about it `[Kniss2003, III.D]`.
//!
//! Nothing is stored along z. A volume with a height field keeps one layer of voxels, which hold for every height; its
//! grid has as many layers as cubes of the map's texels would make, so that steps and cells have a size.

mod halve;
mod map;

pub use map::{HeightMap, Layer, Sheet};

use glam::DVec3;

use super::Grid;

/// A surface over the grid's x and y, and the faces of the medium about it.
///
/// Heights and distances are in layers: grid coordinates along z, 0 at the centre of the lowest layer.
#[derive(Clone, Debug, PartialEq)]
pub struct HeightField {
    /// The surface over every column, x fastest; finite.
    pub heights: Vec<f32>,
    /// The medium's lower face, from the surface.
    pub bottom: f64,
    /// The medium's upper face, from the surface; above `bottom`.
    pub top: f64,
    /// Distance from either face over which extinction rises from nothing to the material's, > 0.
    pub ramp: f64,
    /// How far the box reaches beyond the faces, for noise that moves the medium.
    pub margin: f64,
    /// How often the map was halved.
    pub level: u32,
}

impl HeightField {
    /// Share of the material's extinction at a distance above the surface, in [0, 1].
    #[must_use]
    pub fn share(&self, above: f64) -> f64 {
        let inside = (above - self.bottom).min(self.top - above);
        (inside / self.ramp).clamp(0.0, 1.0)
    }

    /// Distance of grid coordinates `q` above the surface; bilinear, clamped beyond the outer columns.
    #[must_use]
    pub fn above(&self, grid: &Grid, q: DVec3) -> f64 {
        let (nx, ny) = (grid.dims.x as usize, grid.dims.y as usize);
        let along = |at: f64, n: usize| {
            let at = at.clamp(0.0, (n - 1) as f64);
            let low = at as usize;
            (low, (low + 1).min(n - 1), at - low as f64)
        };
        let ((x0, x1, fx), (y0, y1, fy)) = (along(q.x, nx), along(q.y, ny));
        let height = |x: usize, y: usize| f64::from(self.heights[x + nx * y]);
        let row = |y| height(x0, y) + fx * (height(x1, y) - height(x0, y));
        q.z - (row(y0) + fy * (row(y1) - row(y0)))
    }

    /// Lowest and highest of the columns from `lo` to `hi`, both included.
    #[must_use]
    pub fn range(&self, grid: &Grid, lo: [u32; 2], hi: [u32; 2]) -> (f64, f64) {
        let nx = grid.dims.x as usize;
        let mut range = (f64::INFINITY, f64::NEG_INFINITY);
        for y in lo[1]..=hi[1] {
            for x in lo[0]..=hi[0] {
                let height = f64::from(self.heights[x as usize + nx * y as usize]);
                range = (range.0.min(height), range.1.max(height));
            }
        }
        range
    }
}
