//! Tables that the shaders read: a phase function by the cosine, and what dims scattered light by the data.

use std::f64::consts::PI;

use crate::scene::{HalfAngleParams, TransportColor};
use crate::technique::medium::Table;

/// A user's phase function, per steradian, by the cosine from -1 to 1 in equal steps: scaled so that its integral
/// over the sphere, with straight lines between the rows, is 1 for each colour. One row of 0 without one.
#[must_use]
pub(super) fn phase(params: &HalfAngleParams) -> Vec<[f32; 4]> {
    let rows = params.phase_table.as_deref().unwrap_or(&[]);
    if rows.len() < 2 {
        return vec![[0.0; 4]];
    }
    let step = 2.0 / (rows.len() - 1) as f64;
    let integral = |c: usize| {
        let trapezoids = rows.windows(2).map(|w| 0.5 * (w[0][c] + w[1][c]));
        2.0 * PI * step * trapezoids.sum::<f64>()
    };
    let whole = [0, 1, 2].map(integral);
    let scaled = |row: &[f64; 3]| {
        let value = |c: usize| (row[c] / whole[c].max(f64::MIN_POSITIVE)) as f32;
        [value(0), value(1), value(2), 0.0]
    };
    rows.iter().map(scaled).collect()
}

/// For every entry of the transfer function's table the share of the extinction that dims scattered light,
/// `-ln` of the transport colour, at most 1. One entry of 0 where the albedo decides.
#[must_use]
pub(super) fn transport(params: &HalfAngleParams, table: &Table) -> Vec<[f32; 4]> {
    let TransportColor::Points(rows) = &params.transport_color else {
        return vec![[0.0; 4]];
    };
    let width = (table.max - table.min) / f64::from(table.entries - 1);
    let entry = |i: u32| {
        let color = transport_color(rows, table.min + f64::from(i) * width);
        let [r, g, b] = color.map(|c| decay_of(c) as f32);
        [r, g, b, 0.0]
    };
    (0..table.entries).map(entry).collect()
}

/// Share of the extinction that leaves `color` of scattered light after a mean free path: 1, as much as dims
/// direct light, from 1/e down.
#[must_use]
pub(super) fn decay_of(color: f64) -> f64 {
    (-color.clamp(0.0, 1.0).ln()).min(1.0)
}

/// Between the rows in straight lines, beyond them the outermost.
#[must_use]
pub(super) fn transport_color(rows: &[[f64; 4]], value: f64) -> [f64; 3] {
    let color = |row: &[f64; 4]| [row[1], row[2], row[3]];
    let above = rows.partition_point(|row| row[0] <= value);
    match (
        above.checked_sub(1).and_then(|i| rows.get(i)),
        rows.get(above),
    ) {
        (Some(low), Some(high)) => {
            let t = (value - low[0]) / (high[0] - low[0]);
            let (a, b) = (color(low), color(high));
            [0, 1, 2].map(|c| a[c] + t * (b[c] - a[c]))
        }
        (Some(only), None) | (None, Some(only)) => color(only),
        (None, None) => [1.0; 3],
    }
}

/// Share of the extinction that dims scattered light by the albedo: how diffuse light decays far from its source
/// in a medium of the reduced albedo `a (1 - g) / (1 - a g)`, for which `sqrt(1 - a^3)` is within 2.5 % of transport
/// theory's `k = a artanh(k)`.
#[must_use]
pub(super) fn decay(albedo: f64, g: f64) -> f64 {
    let a = albedo.clamp(0.0, 1.0);
    let reduced = 1.0 - a * g;
    let similar = a * (1.0 - g) / reduced;
    (reduced * (1.0 - similar.powi(3)).max(0.0).sqrt()).min(1.0)
}
