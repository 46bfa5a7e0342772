//! Data value to colour and opacity.
//!
//! Everything here works on *linear* RGB with sRGB primaries: control points hold linear colours and
//! the straight line between two of them is straight in linear light. Files state the colour space
//! of their numbers and are converted when they are read ([`read_file`]).

mod automatic;
mod bake;
mod color_space;
mod definition;
mod error;
mod histogram;
mod modality;
mod nodes;
mod opacity_curve;
mod paraview;
mod preset;
mod primitive;
mod read;

pub use automatic::automatic;
pub use error::TransferFunctionError;
pub use paraview::read_paraview;
pub use preset::Preset;
pub use primitive::{GradientAxis, Primitive, Shape};
pub use read::read_file;

use glam::Vec3;

/// Opacities are limited to this, so that `sigma_t` stays finite:
/// at most `-ln(1e-6) = 13.8` optical depths an `opacity_unit_distance`.
pub const OPACITY_MAX: f64 = 1.0 - 1e-6;

/// What the fourth number of a control point, `opacity`, stands for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Quantity {
    /// Opacity over one `opacity_unit_distance`, in [0, 1].
    #[default]
    Opacity,
    /// Extinction per world unit, >= 0; `opacity_unit_distance` plays no part.
    Extinction,
}

/// One node of the piecewise-linear function.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ControlPoint {
    /// Data value (after rescale).
    pub value: f64,
    /// Linear RGB, >= 0.
    pub color: Vec3,
    /// Opacity over one `opacity_unit_distance`, in [0, 1], or what else [`Quantity`] says.
    pub opacity: f64,
}

/// Piecewise linear between control points, constant beyond the outer ones; or shapes over values and gradient
/// magnitudes.
#[derive(Clone, Debug, PartialEq)]
pub struct TransferFunction {
    /// Where it came from: a preset's name, a file, `automatic: ...`, `inline`.
    pub name: String,
    /// What the points' `opacity` stands for.
    pub quantity: Quantity,
    /// Ascending in `value`; two points may share a value (a jump). Empty: fully transparent.
    pub points: Vec<ControlPoint>,
    /// Shapes over values and gradients: where there are any, they take the place of the points.
    pub primitives: Vec<Primitive>,
    /// World distance over which `opacity` is reached, > 0 (VTK's scalar opacity unit distance).
    pub opacity_unit_distance: f64,
}

impl TransferFunction {
    /// A function with checked invariants.
    ///
    /// # Errors
    /// Where a number is not finite, `points` are not ascending or more than two share a value, an
    /// opacity is outside [0, 1], a colour is negative, or `opacity_unit_distance` is not above 0.
    pub fn new(
        name: impl Into<String>,
        points: Vec<ControlPoint>,
        opacity_unit_distance: f64,
    ) -> Result<Self, TransferFunctionError> {
        let name = name.into();
        if !(opacity_unit_distance.is_finite() && opacity_unit_distance > 0.0) {
            let message = format!(
                "`opacity_unit_distance` is {opacity_unit_distance}, expected a number above 0"
            );
            return Err(TransferFunctionError::new(name, message));
        }
        match check_points(&points) {
            Ok(()) => Ok(Self {
                name,
                quantity: Quantity::Opacity,
                points,
                primitives: Vec::new(),
                opacity_unit_distance,
            }),
            Err(message) => Err(TransferFunctionError::new(name, message)),
        }
    }

    /// Linear colour and opacity at a data value. At a jump the upper side counts; NaN is
    /// transparent. Where gradients decide too, the most that any gradient makes of the value.
    #[must_use]
    pub fn evaluate(&self, value: f64) -> (Vec3, f64) {
        if self.has_gradients() {
            return self.densest(value);
        }
        let Some(first) = self.points.first() else {
            return (Vec3::ZERO, 0.0);
        };
        if value.is_nan() {
            return (Vec3::ZERO, 0.0);
        }
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

    /// Extinction per world unit at a data value, before `density_scale`: of opacities
    /// `-ln(1 - opacity) / opacity_unit_distance`.
    #[must_use]
    pub fn sigma_t(&self, value: f64) -> f64 {
        let (_, opacity) = self.evaluate(value);
        self.sigma_t_of(opacity)
    }

    /// Smallest and largest value of a control point; `None` for a function without.
    #[must_use]
    pub fn range(&self) -> Option<(f64, f64)> {
        Some((self.points.first()?.value, self.points.last()?.value))
    }

    fn sigma_t_of(&self, opacity: f64) -> f64 {
        if self.quantity == Quantity::Extinction {
            return opacity;
        }
        // The sum with 0 turns the -0 of opacity 0 into 0.
        0.0 - (-opacity.clamp(0.0, OPACITY_MAX)).ln_1p() / self.opacity_unit_distance
    }
}

/// `Err` names the first point that breaks an invariant.
fn check_points(points: &[ControlPoint]) -> Result<(), String> {
    for (i, p) in points.iter().enumerate() {
        if !p.value.is_finite() {
            return Err(format!("points[{i}]: value {} is not finite", p.value));
        }
        if !(0.0..=1.0).contains(&p.opacity) {
            return Err(format!(
                "points[{i}]: opacity is {}, expected a number in [0, 1]",
                p.opacity
            ));
        }
        if !(p.color.is_finite() && p.color.min_element() >= 0.0) {
            return Err(format!(
                "points[{i}]: colour is {}, expected three finite numbers, none negative",
                p.color
            ));
        }
    }
    for (i, pair) in points.windows(2).enumerate() {
        if pair[1].value < pair[0].value {
            return Err(format!(
                "points[{}]: value {} comes after {}, expected ascending values",
                i + 1,
                pair[1].value,
                pair[0].value
            ));
        }
    }
    for (i, triple) in points.windows(3).enumerate() {
        if triple[0].value == triple[2].value {
            return Err(format!(
                "points[{}]: third point at value {}, expected at most two (a jump)",
                i + 2,
                triple[2].value
            ));
        }
    }
    let extent = points.last().map_or(0.0, |l| l.value - points[0].value);
    if !extent.is_finite() {
        return Err("the values span more than a 64-bit float can hold".to_owned());
    }
    Ok(())
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn point(value: f64, gray: f32, opacity: f64) -> ControlPoint {
        ControlPoint {
            value,
            color: Vec3::splat(gray),
            opacity,
        }
    }

    fn message(points: Vec<ControlPoint>) -> String {
        TransferFunction::new("f", points, 1.0).unwrap_err().message
    }

    #[test]
    fn new_names_the_offending_point() {
        assert!(message(vec![point(f64::NAN, 0.0, 0.0)]).contains("points[0]: value NaN"));
        assert!(message(vec![point(0.0, 0.0, 1.5)]).contains("opacity is 1.5"));
        assert!(message(vec![point(0.0, 0.0, f64::NAN)]).contains("opacity is NaN"));
        assert!(message(vec![point(0.0, -0.5, 0.0)]).contains("colour"));
        assert!(message(vec![point(2.0, 0.0, 0.0), point(1.0, 0.0, 0.0)]).contains("points[1]"));
        assert!(message(vec![point(2.0, 0.0, 0.0); 3]).contains("points[2]: third"));
        assert!(message(vec![point(-1e308, 0.0, 0.0), point(1e308, 0.0, 0.0)]).contains("span"));
        for distance in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let error = TransferFunction::new("f", Vec::new(), distance).unwrap_err();
            assert!(
                error
                    .to_string()
                    .starts_with("f: `opacity_unit_distance` is")
            );
        }
    }

    #[test]
    fn sigma_t_is_limited_and_zero_is_positive() {
        let f = TransferFunction::new("f", vec![point(0.0, 1.0, 0.0), point(1.0, 1.0, 1.0)], 2.0)
            .unwrap();
        assert_eq!(f.sigma_t(0.0).to_bits(), 0.0f64.to_bits());
        assert!((f.sigma_t(1.0) - 1e6f64.ln() / 2.0).abs() < 1e-9);
        assert!((f.sigma_t(0.5) - 2f64.ln() / 2.0).abs() < 1e-12);
        assert_eq!(f.range(), Some((0.0, 1.0)));
    }
}
