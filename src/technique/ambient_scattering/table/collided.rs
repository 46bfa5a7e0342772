//! The collided part of a table, as what interpolates well: its logarithm beside that of thin media.

use super::entries::Table;
use super::grid::{Axis, Grid};
use super::optics::{colliding, thin_collided};

/// `ln(C / p)`, where `C` is collided radiance per colliding light and albedo, and `p` is what `C` is in thin
/// media. 0 at `sigma_t = 0`, smooth in all of `theta`, `sigma_t`, `g`.
#[derive(Clone, Debug, PartialEq)]
pub struct Collided {
    /// Where the entries lie.
    pub grid: Grid,
    /// The logarithms: angle fastest, `g` slowest.
    pub log_ratio: Vec<f32>,
}

/// The least logarithm, 2^-64: what no path has found, or what cannot be told from what has not collided.
const FLOOR: f32 = -44.361_42;

impl Collided {
    /// From values of `C` that `value(column, angle)` gives.
    #[must_use]
    pub fn new(grid: Grid, value: impl Fn(usize, usize) -> f64) -> Self {
        let mut log_ratio = Vec::new();
        for column in 0..grid.columns() {
            let [_, g] = grid.column(column);
            for (angle, theta) in grid.thetas.nodes().enumerate() {
                let ratio = value(column, angle) / thin_collided(theta, g);
                log_ratio.push((ratio.ln() as f32).max(FLOOR));
            }
        }
        Self { grid, log_ratio }
    }

    /// What of a table's radiance has collided.
    #[must_use]
    pub fn of_table(table: &Table) -> Self {
        let grid = table.grid;
        Self::new(grid, |column, angle| {
            let [sigma_t, g] = grid.column(column);
            let scale = table.albedo * colliding(sigma_t);
            let index = column * grid.thetas.count + angle;
            let rest = f64::from(table.radiance[index]) - Table::unscattered(&grid, index);
            if scale > 0.0 {
                rest / scale
            } else {
                thin_collided(grid.thetas.node(angle), g)
            }
        })
    }

    /// The logarithms of all angles and extinctions at one `g`, angle fastest. Cubic between the nodes of
    /// `g`; beyond them the last two nodes go on in a straight line.
    #[must_use]
    pub fn at_g(&self, g: f64) -> Vec<f64> {
        let entries = self.grid.sigmas.count * self.grid.thetas.count;
        let weights = cubic_weights(&self.grid.gs, g);
        let mut slice = vec![0.0; entries];
        for (node, weight) in weights {
            let values = &self.log_ratio[node * entries..(node + 1) * entries];
            for (to, value) in slice.iter_mut().zip(values) {
                *to += weight * f64::from(*value);
            }
        }
        slice
    }

    /// Every `step`-th angle and extinction.
    #[must_use]
    pub fn coarser(&self, step: usize) -> Self {
        let grid = self.grid.coarser(step);
        let (sigmas, thetas) = (self.grid.sigmas.count, self.grid.thetas.count);
        let mut log_ratio = Vec::new();
        for g in 0..grid.gs.count {
            for sigma in 0..grid.sigmas.count {
                let first = (g * sigmas + sigma * step) * thetas;
                log_ratio.extend((0..grid.thetas.count).map(|t| self.log_ratio[first + t * step]));
            }
        }
        Self { grid, log_ratio }
    }
}

/// Nodes of an axis and their weights at `value`: the cubic through the four nearest, the line through the
/// last two beyond the ends, or what fewer nodes allow.
fn cubic_weights(axis: &Axis, value: f64) -> Vec<(usize, f64)> {
    let nodes: Vec<f64> = axis.nodes().collect();
    weights(&nodes, value)
}

/// As [`cubic_weights`], for nodes at any ascending places.
pub(super) fn weights(nodes: &[f64], value: f64) -> Vec<(usize, f64)> {
    let count = nodes.len();
    let at = nodes.partition_point(|n| *n <= value);
    let range = if at == 0 {
        0..count.min(2)
    } else if at == count && nodes[count - 1] < value {
        count.saturating_sub(2)..count
    } else {
        let first = at.saturating_sub(2).min(count.saturating_sub(4));
        first..count.min(first + 4)
    };
    let others = range.clone();
    let lagrange = |i: usize| {
        let factors = others.clone().filter(|j| *j != i);
        factors
            .map(|j| (value - nodes[j]) / (nodes[i] - nodes[j]))
            .product()
    };
    range.map(|i| (i, lagrange(i))).collect()
}
