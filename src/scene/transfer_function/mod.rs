//! Data value to colour and opacity.

mod automatic;
mod color_map;
mod file;
mod interpolate;
mod preset;

pub use automatic::automatic;
pub use color_map::read_color_map;
pub use file::{TransferFunctionError, read_file};
pub use preset::Preset;

use glam::Vec3;

/// Opacities are limited to this, so that `sigma_t` stays finite:
/// at most `-ln(1e-6) = 13.8` optical depths an `opacity_unit_distance`.
pub const OPACITY_MAX: f64 = 1.0 - 1e-6;

/// Fewest and most entries of a baked table.
const ENTRIES: (usize, usize) = (1024, 16384);

/// Entries that the narrowest segment between two control points should span.
const ENTRIES_PER_SEGMENT: f64 = 8.0;

/// One node of the piecewise-linear function.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ControlPoint {
    /// Data value (after rescale).
    pub value: f64,
    /// Linear RGB, >= 0.
    pub color: Vec3,
    /// Opacity over one `opacity_unit_distance`, in [0, 1].
    pub opacity: f64,
}

/// Piecewise linear between control points, constant beyond the outer ones.
#[derive(Clone, Debug, PartialEq)]
pub struct TransferFunction {
    /// Where it came from: a preset's name, a file, `automatic: ...`, `inline`.
    pub name: String,
    /// Ascending in `value`; two points may share a value (a jump). Empty: fully transparent.
    pub points: Vec<ControlPoint>,
    /// World distance over which `opacity` is reached, > 0 (VTK's scalar opacity unit distance).
    pub opacity_unit_distance: f64,
}

impl TransferFunction {
    /// Linear colour and opacity at a data value.
    #[must_use]
    pub fn evaluate(&self, value: f64) -> (Vec3, f64) {
        let Some(first) = self.points.first() else {
            return (Vec3::ZERO, 0.0);
        };
        let upper = self.points.partition_point(|p| p.value <= value);
        if upper == 0 {
            return (first.color, first.opacity);
        }
        let a = self.points[upper - 1];
        let Some(b) = self.points.get(upper) else {
            return (a.color, a.opacity);
        };
        let s = (value - a.value) / (b.value - a.value);
        (
            a.color.lerp(b.color, s as f32),
            a.opacity + s * (b.opacity - a.opacity),
        )
    }

    /// Extinction per world unit at a data value, before `density_scale`:
    /// `-ln(1 - opacity) / opacity_unit_distance`.
    #[must_use]
    pub fn sigma_t(&self, value: f64) -> f64 {
        extinction(self.evaluate(value).1) / self.opacity_unit_distance
    }

    /// How many entries of a table over `[min, max]` resolve the narrowest segment: a power of two
    /// from 1024 to 16384.
    #[must_use]
    pub fn entries_needed(&self, min: f64, max: f64) -> usize {
        let inside = |p: &ControlPoint| p.value > min && p.value < max;
        let narrowest = self
            .points
            .windows(2)
            .filter(|w| inside(&w[0]) || inside(&w[1]))
            .map(|w| w[1].value - w[0].value)
            .filter(|width| *width > 0.0)
            .fold(f64::INFINITY, f64::min);
        let wanted = ((max - min) / narrowest * ENTRIES_PER_SEGMENT).clamp(0.0, ENTRIES.1 as f64);
        (wanted as usize)
            .next_power_of_two()
            .clamp(ENTRIES.0, ENTRIES.1)
    }

    /// `(r, g, b, sigma_t)`, colour linear and extinction per world unit, at `entries` values evenly
    /// from `min` to `max`.
    ///
    /// A control point that falls between two entries and has more extinction than either gives the
    /// nearer one its own colour and extinction, so that no spike is lost, however narrow.
    #[must_use]
    pub fn bake(&self, min: f64, max: f64, entries: usize, density_scale: f64) -> Vec<[f32; 4]> {
        let last = entries.saturating_sub(1).max(1) as f64;
        let scale = density_scale / self.opacity_unit_distance;
        let entry = |(color, opacity): (Vec3, f64)| {
            color
                .extend((extinction(opacity) * scale) as f32)
                .to_array()
        };
        let value = |i: usize| min + (max - min) * (i as f64 / last);
        let mut baked: Vec<_> = (0..entries)
            .map(|i| entry(self.evaluate(value(i))))
            .collect();
        for p in self
            .points
            .iter()
            .filter(|p| p.value >= min && p.value <= max)
        {
            let at = if max > min {
                (p.value - min) / (max - min) * last
            } else {
                0.0
            };
            let exact = entry((p.color, p.opacity));
            if let Some(nearest) = baked.get_mut(at.round() as usize)
                && exact[3] > nearest[3]
            {
                *nearest = exact;
            }
        }
        baked
    }
}

/// Optical depth of an opacity, at most 13.8.
fn extinction(opacity: f64) -> f64 {
    -(-opacity.clamp(0.0, OPACITY_MAX)).ln_1p()
}
