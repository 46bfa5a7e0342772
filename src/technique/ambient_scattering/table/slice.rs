//! A table at one anisotropy and albedo, and what it says beyond its last extinction.

use super::grid::Grid;
use super::optics::{colliding, thin_collided, unscattered};

/// Share of the extinctions that a slice's trend beyond its last one is taken from.
const TREND: usize = 4;

/// `L_o` over angle and extinction.
#[derive(Clone, Debug, PartialEq)]
pub struct Slice {
    /// Single-scattering albedo, 0 to 1.
    pub albedo: f64,
    /// Mean cosine of the phase function, -0.99 to 0.99.
    pub g: f64,
    /// Angles and extinctions; its `gs` are not the slice's.
    pub grid: Grid,
    /// Radiance per unit irradiance of the front, 1 / sr, angle fastest: finite and above 0.
    pub radiance: Vec<f32>,
    // ln C, angle fastest.
    log_collided: Vec<f64>,
    // d ln C / d sigma_t beyond the last extinction, by angle; never above 0.
    trend: Vec<f64>,
}

impl Slice {
    /// From logarithms of `C` beside that of thin media, angle fastest.
    pub(super) fn new(grid: &Grid, albedo: f64, g: f64, log_ratio: Vec<f64>) -> Self {
        let (g, albedo) = (g.clamp(-0.99, 0.99), albedo.clamp(0.0, 1.0));
        let thin: Vec<_> = grid
            .thetas
            .nodes()
            .map(|t| thin_collided(t, g).ln())
            .collect();
        let mut log_collided = log_ratio;
        for row in log_collided.chunks_mut(grid.thetas.count) {
            row.iter_mut().zip(&thin).for_each(|(v, thin)| *v += thin);
        }
        let mut slice = Self {
            albedo,
            g,
            grid: *grid,
            radiance: Vec::new(),
            trend: trend(grid, &log_collided),
            log_collided,
        };
        slice.radiance = slice.tabulate(&grid.sigmas.nodes().collect::<Vec<_>>());
        slice
    }

    /// Radiance, 1 / sr, at any angle, radians, and any extinction from 0 on: what has not collided in closed
    /// form, what has interpolated in its logarithm, beyond the last extinction by its trend there (the
    /// half-space's constant on the lit side, diffusion's exponential on the other).
    #[must_use]
    pub fn radiance(&self, theta: f64, sigma_t: f64) -> f64 {
        let theta = theta.clamp(0.0, std::f64::consts::PI);
        let (s, ds) = self.grid.sigmas.place(sigma_t);
        let (t, dt) = self.grid.thetas.place(theta);
        let count = self.grid.thetas.count;
        let next = |i: usize, count: usize| (i + 1).min(count - 1);
        let nodes = cubic(t, dt, count);
        let row = |s: usize| {
            let part = |(t, weight): &(usize, f64)| weight * self.log_collided[s * count + t];
            nodes.iter().map(part).sum::<f64>()
        };
        let (low, high) = (row(s), row(next(s, self.grid.sigmas.count)));
        let slope = self.trend[t] + dt * (self.trend[next(t, count)] - self.trend[t]);
        let log = low + ds * (high - low) + beyond(slope, self.grid.sigmas.max, sigma_t);
        let collided = self.albedo * colliding(sigma_t) * log.exp();
        unscattered(theta, sigma_t, self.g) + collided
    }

    /// The slice at other extinctions, angle fastest, as 32-bit floats above 0.
    #[must_use]
    pub fn tabulate(&self, sigmas: &[f64]) -> Vec<f32> {
        let thetas: Vec<_> = self.grid.thetas.nodes().collect();
        let at = |s: &f64, t: &f64| (self.radiance(*t, *s) as f32).max(f32::MIN_POSITIVE);
        let rows = sigmas
            .iter()
            .flat_map(|s| thetas.iter().map(move |t| at(s, t)));
        rows.collect()
    }
}

/// Four nodes about a place and their weights, by the cubic of Catmull and Rom; at the ends by the line.
fn cubic(t: usize, dt: f64, count: usize) -> Vec<(usize, f64)> {
    if t == 0 || t + 2 >= count {
        return vec![(t, 1.0 - dt), ((t + 1).min(count - 1), dt)];
    }
    let (d2, d3) = (dt * dt, dt * dt * dt);
    vec![
        (t - 1, 0.5 * (2.0 * d2 - d3 - dt)),
        (t, 0.5 * (2.0 - 5.0 * d2 + 3.0 * d3)),
        (t + 1, 0.5 * (dt + 4.0 * d2 - 3.0 * d3)),
        (t + 2, 0.5 * (d3 - d2)),
    ]
}

/// How `ln C` goes on from the last extinction: where it hardly falls, towards the half-space's constant as
/// `1 / sigma_t` does, for a sphere is ever flatter; where it falls fast, in a straight line as diffusion does;
/// mixed between.
fn beyond(slope: f64, last: f64, sigma_t: f64) -> f64 {
    if sigma_t <= last {
        return 0.0;
    }
    let fast = (-0.5 * slope * last - 1.0).clamp(0.0, 1.0);
    let flattening = last * (1.0 - last / sigma_t);
    slope * (flattening + fast * (sigma_t - last - flattening))
}

/// Slopes of `ln C` over the last extinctions, fitted to them so that noise weighs little.
fn trend(grid: &Grid, log_collided: &[f64]) -> Vec<f64> {
    let (sigmas, thetas) = (grid.sigmas.count, grid.thetas.count);
    let rows = sigmas - sigmas.div_ceil(TREND)..sigmas;
    let middle = rows.clone().map(|s| grid.sigmas.node(s)).sum::<f64>() / rows.len() as f64;
    let spread: f64 = rows
        .clone()
        .map(|s| (grid.sigmas.node(s) - middle).powi(2))
        .sum();
    let slope = |theta: usize| {
        let value = |s: usize| (grid.sigmas.node(s) - middle) * log_collided[s * thetas + theta];
        let slope = rows.clone().map(value).sum::<f64>() / spread.max(1e-30);
        slope.min(0.0)
    };
    (0..thetas).map(slope).collect()
}
