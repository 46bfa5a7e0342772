//! Transfer functions over two axes, data value and gradient magnitude, made of a few simple shapes
//! `[Kniss2001]`, as `[Kniss2003]` classifies its volumes.
//!
//! The gradient's magnitude is that of the data values over the world, in data units a world unit, by central
//! differences one voxel to either side (to one side at the volume's faces): it does not depend on the step of
//! a march, nor on units of length if the shapes are given in the same.
//!
//! Where shapes overlap their materials are mixed: extinctions add up, so that their opacities unite as
//! `1 - (1 - a)(1 - b)`, and the colour is the mean of the shapes' colours weighted by extinction.

use std::ops::RangeInclusive;

use glam::{DVec3, Vec3};

use super::TransferFunction;

/// How a shape's opacity falls from its middle.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum Shape {
    /// The same opacity over the whole rectangle. Its gradients need not end.
    Box,
    /// A tip at the middle value and the lowest gradient, which widens to all values at the highest; from the
    /// middle value to the sides the opacity falls linearly: it follows the boundary between two materials,
    /// however blurred `[Levoy1988]`.
    Triangle,
    /// A bell over the ellipse in the rectangle, whose sides are at three standard deviations; 0 there.
    Gaussian,
}

/// A rectangle of values and gradients that a shape fills.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Primitive {
    /// What fills it.
    pub shape: Shape,
    /// Lowest and highest data value, finite, ascending.
    pub value: [f64; 2],
    /// Lowest and highest gradient magnitude, data units a world unit, >= 0, ascending; of a box the highest
    /// may be infinite.
    pub gradient: [f64; 2],
    /// Linear RGB, >= 0.
    pub color: Vec3,
    /// Largest opacity over one `opacity_unit_distance`, in [0, 1].
    pub opacity: f64,
}

/// Of a bell, what is left at three standard deviations.
const BELL_END: f64 = 0.011_108_996_538_242_306;

/// Entries across the narrowest shape, and how many there may be along each axis. Sides without a slope, those of
/// boxes and the upper one of triangles, become as steep as one entry is wide.
const ENTRIES_A_SHAPE: f64 = 64.0;
const VALUES: RangeInclusive<usize> = 512..=2048;
const GRADIENTS: RangeInclusive<usize> = 256..=512;

impl Primitive {
    /// Share of the opacity at a data value and a gradient magnitude, in [0, 1].
    #[must_use]
    pub fn share(&self, value: f64, gradient: f64) -> f64 {
        let [low, high] = self.gradient;
        let inside = (low..=high).contains(&gradient);
        match self.shape {
            _ if !inside => 0.0,
            Shape::Box => f64::from((self.value[0]..=self.value[1]).contains(&value)),
            Shape::Triangle => self.tent(value, (gradient - low) / (high - low)),
            Shape::Gaussian => {
                let off = (gradient - 0.5 * (low + high)) / (0.5 * (high - low));
                self.bell(value, off)
            }
        }
    }

    /// Largest share of the opacity at a data value, whatever the gradient.
    fn largest_share(&self, value: f64) -> f64 {
        match self.shape {
            Shape::Box => self.share(value, self.gradient[0]),
            Shape::Triangle => self.tent(value, 1.0),
            Shape::Gaussian => self.bell(value, 0.0),
        }
    }

    /// Values from the middle one, of which the sides are 1 away.
    fn off(&self, value: f64) -> f64 {
        let [low, high] = self.value;
        (value - 0.5 * (low + high)) / (0.5 * (high - low))
    }

    fn tent(&self, value: f64, width: f64) -> f64 {
        let off = self.off(value).abs();
        if off < width { 1.0 - off / width } else { 0.0 }
    }

    fn bell(&self, value: f64, off_gradient: f64) -> f64 {
        let square = self.off(value).powi(2) + off_gradient * off_gradient;
        // NaN is nowhere.
        if square < 1.0 {
            ((-4.5 * square).exp() - BELL_END) / (1.0 - BELL_END)
        } else {
            0.0
        }
    }

    /// Nothing smaller than the entries of a table: it would fall between them.
    fn widened(mut self, value_step: f64, axis: GradientAxis) -> Self {
        let [low, high] = self.gradient;
        let gradient_step = axis.step_at(if high.is_finite() { high } else { low });
        for (range, step) in [
            (&mut self.value, value_step),
            (&mut self.gradient, gradient_step),
        ] {
            let short = 2.0 * step - (range[1] - range[0]);
            if short > 0.0 {
                *range = [range[0] - 0.5 * short, range[1] + 0.5 * short];
            }
        }
        self
    }
}

/// The gradients of a table over both axes, closer together where they are small: most of a volume is nearly even,
/// and there triangles have their tips.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GradientAxis {
    /// Entries along gradients, at least 2; the first is for gradient 0.
    pub entries: u32,
    /// Gradient magnitude of the last entry, data units a world unit; steeper ones count as this one.
    pub max: f64,
}

impl GradientAxis {
    /// Gradient magnitude of an entry: they go with its square.
    #[must_use]
    pub fn gradient(&self, entry: f64) -> f64 {
        self.max * (entry / f64::from(self.entries - 1)).powi(2)
    }

    /// From a gradient magnitude to that of an entry later.
    fn step_at(&self, gradient: f64) -> f64 {
        let entry = (gradient / self.max).sqrt() * f64::from(self.entries - 1);
        self.gradient(entry + 1.0) - gradient
    }
}

impl TransferFunction {
    /// Whether gradients decide beside values.
    #[must_use]
    pub const fn has_gradients(&self) -> bool {
        !self.primitives.is_empty()
    }

    /// Linear colour, and extinction per world unit before `density_scale`, at a data value and a gradient
    /// magnitude; NaN is transparent. Without gradients as [`Self::evaluate`] and [`Self::sigma_t`].
    #[must_use]
    pub fn material(&self, value: f64, gradient: f64) -> (Vec3, f64) {
        if self.has_gradients() {
            return self.mixed(|p| p.share(value, gradient));
        }
        (self.evaluate(value).0, self.sigma_t(value))
    }

    /// Colour and opacity that no gradient exceeds at a data value.
    pub(super) fn densest(&self, value: f64) -> (Vec3, f64) {
        let (color, sigma_t) = self.mixed(|p| p.largest_share(value));
        (color, -(-sigma_t * self.opacity_unit_distance).exp_m1())
    }

    fn mixed(&self, share: impl Fn(&Primitive) -> f64) -> (Vec3, f64) {
        let (mut color, mut sum) = (DVec3::ZERO, 0.0);
        for p in &self.primitives {
            let sigma_t = self.sigma_t_of(p.opacity * share(p));
            color += sigma_t * p.color.as_dvec3();
            sum += sigma_t;
        }
        if sum > 0.0 {
            // Together no denser than one shape may be.
            ((color / sum).as_vec3(), sum.min(self.sigma_t_of(1.0)))
        } else {
            (Vec3::ZERO, 0.0)
        }
    }

    /// Entries along values, of a table over `[min, max]`, that the narrowest shape needs: a power of two from
    /// 512 to 2048.
    pub(super) fn values_needed(&self, min: f64, max: f64) -> usize {
        let narrowest = narrowest(self.primitives.iter().map(|p| p.value));
        wanted(max - min, narrowest, VALUES)
    }

    /// The table's other axis, if gradients decide: to the highest gradient that a shape tells from steeper
    /// ones.
    #[must_use]
    pub fn gradient_axis(&self) -> Option<GradientAxis> {
        if !self.has_gradients() {
            return None;
        }
        let ends = self.primitives.iter().flat_map(|p| p.gradient);
        let highest = ends.filter(|g| g.is_finite()).fold(0.0, f64::max);
        if highest <= 0.0 {
            return Some(GradientAxis {
                entries: 2,
                max: 1.0,
            });
        }
        let roots = self.primitives.iter().map(|p| p.gradient.map(f64::sqrt));
        let entries = wanted(highest.sqrt(), narrowest(roots), GRADIENTS);
        // The last entry lies beyond the highest end.
        let max = highest * ((entries - 1) as f64 / (entries - 2) as f64).powi(2);
        Some(GradientAxis {
            entries: entries as u32,
            max,
        })
    }

    /// The function with every shape at least two entries of a table wide along each axis, so that none falls
    /// between them.
    #[must_use]
    pub fn widened(&self, value_step: f64, axis: GradientAxis) -> Self {
        let wide = |p: &Primitive| p.widened(value_step, axis);
        Self {
            primitives: self.primitives.iter().map(wide).collect(),
            ..self.clone()
        }
    }

    /// Table of `(r, g, b, sigma_t)` over values `[min, max]`, fastest, and the gradients of `axis`. Entries
    /// without extinction take the colour of their neighbours, so that no interpolated colour is darker than
    /// what it is mixed from.
    #[must_use]
    pub fn bake_gradients(
        &self,
        (min, max): (f64, f64),
        values: usize,
        axis: GradientAxis,
        density_scale: f64,
    ) -> Vec<[f32; 4]> {
        let last = values.saturating_sub(1).max(1) as f64;
        let mut table = Vec::with_capacity(values * axis.entries as usize);
        for row in 0..axis.entries {
            let gradient = axis.gradient(f64::from(row));
            table.extend((0..values).map(|i| {
                let value = min + (max - min) * (i as f64 / last);
                let (color, sigma_t) = self.material(value, gradient);
                [color.x, color.y, color.z, (sigma_t * density_scale) as f32]
            }));
        }
        spread_colors(&table, values)
    }
}

/// The smallest extent of finite ranges.
fn narrowest(ranges: impl Iterator<Item = [f64; 2]>) -> f64 {
    let extents = ranges.map(|r| r[1] - r[0]);
    extents
        .filter(|e| e.is_finite())
        .fold(f64::INFINITY, f64::min)
}

fn wanted(extent: f64, narrowest: f64, limits: RangeInclusive<usize>) -> usize {
    // `as` saturates, and makes 0 of NaN.
    let entries = (ENTRIES_A_SHAPE * extent / narrowest).ceil() as usize;
    let (least, most) = limits.into_inner();
    entries.clamp(least, most).next_power_of_two()
}

fn spread_colors(table: &[[f32; 4]], values: usize) -> Vec<[f32; 4]> {
    let at = |i: usize| table.get(i).copied().unwrap_or_default();
    let filled = |(i, entry): (usize, &[f32; 4])| {
        if entry[3] > 0.0 {
            return *entry;
        }
        let (x, mut sum) = (i % values, [0.0; 4]);
        for row in [i.checked_sub(values), Some(i), Some(i + values)] {
            let Some(middle) = row else { continue };
            let first = if x > 0 { middle - 1 } else { middle };
            let end = if x + 1 < values { middle + 1 } else { middle };
            for near in (first..=end).map(at) {
                for channel in 0..3 {
                    sum[channel] += near[3] * near[channel];
                }
                sum[3] += near[3];
            }
        }
        let weight = if sum[3] > 0.0 { sum[3] } else { 1.0 };
        [sum[0] / weight, sum[1] / weight, sum[2] / weight, 0.0]
    };
    table.iter().enumerate().map(filled).collect()
}

#[cfg(test)]
mod tests {
    use super::super::Quantity;
    use super::*;

    fn primitive(shape: Shape, color: Vec3) -> Primitive {
        Primitive {
            shape,
            value: [1.0, 3.0],
            gradient: [2.0, 6.0],
            color,
            opacity: 0.5,
        }
    }

    fn function(primitives: &[Primitive]) -> TransferFunction {
        TransferFunction {
            name: String::new(),
            quantity: Quantity::Opacity,
            points: Vec::new(),
            primitives: primitives.to_vec(),
            opacity_unit_distance: 2.0,
        }
    }

    #[test]
    fn shapes_are_whole_in_the_middle_and_end_at_their_sides() {
        for (shape, middle) in [
            (Shape::Box, 4.0),
            (Shape::Triangle, 4.0),
            (Shape::Gaussian, 4.0),
        ] {
            let p = primitive(shape, Vec3::ONE);
            assert_eq!(p.share(2.0, middle), 1.0, "{shape:?}");
            for (value, gradient) in [
                (0.99, 4.0),
                (3.01, 4.0),
                (2.0, 1.99),
                (2.0, 6.01),
                (f64::NAN, 4.0),
                (2.0, f64::NAN),
            ] {
                assert_eq!(
                    p.share(value, gradient),
                    0.0,
                    "{shape:?} {value} {gradient}"
                );
            }
        }
        // Half way to a side: the tent is half as high, at half the gradients half as wide.
        let tent = primitive(Shape::Triangle, Vec3::ONE);
        assert_eq!(tent.share(2.5, 6.0), 0.5);
        assert_eq!(tent.share(2.25, 4.0), 0.5);
        let bell = primitive(Shape::Gaussian, Vec3::ONE);
        // A third of the way is one standard deviation, along either axis.
        let sigma = ((-0.5f64).exp() - BELL_END) / (1.0 - BELL_END);
        assert!((bell.share(2.0 + 1.0 / 3.0, 4.0) - sigma).abs() < 1e-12);
        assert!((bell.share(2.0, 4.0 + 2.0 / 3.0) - sigma).abs() < 1e-12);
        assert!(((-4.5f64).exp() - BELL_END).abs() < 1e-15);
    }

    #[test]
    fn overlapping_shapes_unite_like_independent_materials() {
        let (red, blue) = (Vec3::X, Vec3::Z);
        let mut other = primitive(Shape::Box, blue);
        other.opacity = 0.75;
        let f = function(&[primitive(Shape::Box, red), other]);
        let (color, sigma_t) = f.material(2.0, 4.0);
        assert!((sigma_t - -(0.5f64 * 0.25).ln() / 2.0).abs() < 1e-12);
        // -ln(0.25) is twice -ln(0.5).
        assert!((color - Vec3::new(1.0, 0.0, 2.0) / 3.0).length() < 1e-6);
        let (_, opacity) = f.densest(2.0);
        assert!((opacity - 0.875).abs() < 1e-12);
        assert_eq!(f.material(2.0, 9.0), (Vec3::ZERO, 0.0));
    }

    #[test]
    fn no_entry_is_denser_than_the_densest_of_its_value_and_none_is_black() {
        let shapes = [Shape::Box, Shape::Triangle, Shape::Gaussian];
        let list = shapes.map(|s| primitive(s, Vec3::new(0.2, 0.4, 0.8)));
        for f in [function(&list), function(&list[1..2])] {
            let axis = f.gradient_axis().unwrap_or(GradientAxis {
                entries: 2,
                max: 1.0,
            });
            let table = f.bake_gradients((0.0, 5.0), 256, axis, 3.0);
            let bounds = f.bake(0.0, 5.0, 256, 3.0);
            for (i, entry) in table.iter().enumerate() {
                assert!(entry[3] <= bounds[i % 256][3] * (1.0 + 1e-6), "{i}");
                let lit = entry[3] > 0.0;
                assert!(!lit || (entry[2] - 0.8).abs() < 1e-6, "{i}: {entry:?}");
            }
            // The last row is beyond every shape.
            assert!(table.iter().rev().take(256).all(|e| e[3] == 0.0));
            // Beside an entry with extinction every entry has its colour.
            for pair in table.windows(2).filter(|p| p[0][3] > 0.0) {
                assert!((pair[1][2] - 0.8).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn narrow_shapes_are_widened_and_axes_are_limited() {
        let mut p = primitive(Shape::Gaussian, Vec3::ONE);
        p.value = [2.0, 2.0 + 1e-9];
        p.gradient = [0.5, f64::INFINITY];
        p.shape = Shape::Box;
        let f = function(&[p]);
        assert_eq!(f.values_needed(0.0, 5.0), *VALUES.end());
        let axis = f.gradient_axis().unwrap_or(GradientAxis {
            entries: 2,
            max: 0.0,
        });
        assert_eq!(axis.entries as usize, *GRADIENTS.start());
        let wide = f.widened(5.0 / 255.0, axis);
        let table = wide.bake_gradients((0.0, 5.0), 256, axis, 1.0);
        assert!(table.iter().any(|e| e[3] > 0.0));
        // A box without an end reaches to the steepest.
        assert!(table.iter().rev().take(256).any(|e| e[3] > 0.0));
    }
}
