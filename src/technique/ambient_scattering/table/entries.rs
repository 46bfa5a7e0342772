//! A whole table in memory.

use super::collided::Collided;
use super::grid::Grid;
use super::optics::unscattered;
use super::slice::Slice;
use super::sums::Sums;

/// `L_o` over angle, extinction and anisotropy at one albedo.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Single-scattering albedo, 0 to 1.
    pub albedo: f64,
    /// Paths that an entry was estimated from, on average; 0 if unknown.
    pub samples: u32,
    /// Where its entries lie.
    pub grid: Grid,
    /// Radiance per unit irradiance of the front, 1 / sr: angle fastest, `g` slowest.
    pub radiance: Vec<f32>,
    /// Its standard errors; empty if unknown.
    pub standard_error: Vec<f32>,
}

impl Table {
    /// What sums say at one of their albedos.
    #[must_use]
    pub fn new(sums: &Sums, albedo: usize) -> Self {
        let grid = sums.request.grid;
        let (mut radiance, mut standard_error) = (Vec::new(), Vec::new());
        for column in 0..grid.columns() {
            for angle in 0..grid.thetas.count {
                let [value, error] = sums.radiance(column, albedo, angle);
                // Radiance is above 0 everywhere; 0 is what no path has found.
                radiance.push((value as f32).max(f32::MIN_POSITIVE));
                standard_error.push(error as f32);
            }
        }
        Self {
            albedo: sums.request.albedos[albedo],
            samples: sums.paths_of_a_column(),
            grid,
            radiance,
            standard_error,
        }
    }

    /// Index of an entry.
    #[must_use]
    pub const fn index(&self, g: usize, sigma: usize, theta: usize) -> usize {
        (g * self.grid.sigmas.count + sigma) * self.grid.thetas.count + theta
    }

    /// The table at any `g` within -0.99 and 0.99, at its own albedo.
    #[must_use]
    pub fn slice(&self, g: f64) -> Slice {
        let collided = Collided::of_table(self);
        Slice::new(&collided.grid, self.albedo, g, collided.at_g(g))
    }

    /// The standard error of the nearest entry, 1 / sr, where it is known.
    #[must_use]
    pub fn error_near(&self, theta: f64, sigma_t: f64, g: f64) -> Option<f64> {
        let grid = self.grid;
        let index = self.index(
            grid.gs.nearest(g),
            grid.sigmas.nearest(sigma_t),
            grid.thetas.nearest(theta),
        );
        self.standard_error.get(index).map(|e| f64::from(*e))
    }

    /// The table of the light that has not collided: what a table at least holds.
    #[must_use]
    pub fn unscattered(grid: &Grid, index: usize) -> f64 {
        let column = index / grid.thetas.count;
        let [sigma_t, g] = grid.column(column);
        unscattered(grid.thetas.node(index % grid.thetas.count), sigma_t, g)
    }
}
