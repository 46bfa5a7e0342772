//! Data value to colour and opacity.

mod automatic;
mod paraview;
mod preset;

pub use automatic::automatic;
pub use paraview::{TransferFunctionError, read_file, read_paraview};
pub use preset::Preset;

use glam::Vec3;

/// Opacities are limited to this, so that `sigma_t` stays finite:
/// at most `-ln(1e-6) = 13.8` optical depths an `opacity_unit_distance`.
pub const OPACITY_MAX: f64 = 1.0 - 1e-6;

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
        let (_, opacity) = self.evaluate(value);
        -(-opacity.clamp(0.0, OPACITY_MAX)).ln_1p() / self.opacity_unit_distance
    }

    /// temp
    #[must_use]
    pub fn entries_needed(&self, _min: f64, _max: f64) -> usize {
        4096
    }
    /// temp
    #[must_use]
    pub fn bake(&self, min: f64, max: f64, entries: usize, density_scale: f64) -> Vec<[f32; 4]> {
        (0..entries)
            .map(|i| {
                let v = min + (max - min) * i as f64 / (entries - 1) as f64;
                let (c, _) = self.evaluate(v);
                [c.x, c.y, c.z, (self.sigma_t(v) * density_scale) as f32]
            })
            .collect()
    }
}
