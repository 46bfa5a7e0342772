//! HDR-FLIP: the largest LDR-FLIP over all useful exposures `[Andersson2021]`.

use glam::Vec3;
use rayon::prelude::*;
use serde::Serialize;

use super::seen::Filters;
use super::{ErrorMap, errors};
use crate::output::Image;
use crate::output::difference::SizeMismatch;
use crate::output::metrics::Size;
use crate::output::tone_map::luminance;

/// Tone-mapped luminance that the brightest and the middle pixel are brought to
/// `[Andersson2021, Sec. 3.2]`.
const TARGET: f64 = 0.85;

/// Narkowicz's fit of the ACES curve is
/// `(A x^2 + B x) / (C x^2 + D x + E)` at 0.6 times the exposed radiance, as the paper has it.
const A: f64 = 2.51 * 0.36;
const B: f64 = 0.03 * 0.6;
const C: f64 = 2.43 * 0.36;
const D: f64 = 0.59 * 0.6;
const E: f64 = 0.14;

/// Luminances below this count as it: a black reference has no exposure of its own.
const DARKEST: f32 = f32::EPSILON;

/// The exposures that HDR-FLIP looks at, evenly spaced in stops.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Exposures {
    /// Stops that bring the brightest pixel of the reference to 0.85.
    pub start: f64,
    /// Stops that bring its median to 0.85.
    pub stop: f64,
    /// How many, both ends included; at least 2.
    pub count: u32,
}

impl Exposures {
    /// From the luminance of the reference `[Andersson2021, Eq. 1 to 3]`.
    #[must_use]
    pub fn of(reference: &Image) -> Self {
        let mut luminances: Vec<f32> = reference
            .pixels
            .iter()
            .map(|p| luminance(radiance(p)).max(DARKEST))
            .collect();
        if luminances.is_empty() {
            luminances.push(DARKEST);
        }
        let middle = luminances.len() / 2;
        let (_, &mut median, _) = luminances.select_nth_unstable_by(middle, f32::total_cmp);
        let brightest = luminances.iter().copied().fold(DARKEST, f32::max);
        let exposed = exposed_for(TARGET);
        let (start, stop) = (
            (exposed / f64::from(brightest)).log2(),
            (exposed / f64::from(median)).log2(),
        );
        // `as` saturates; the range of f32 bounds it to some hundred anyway.
        let count = ((stop - start).ceil() as u32).max(2);
        Self { start, stop, count }
    }

    /// The stops, ascending.
    fn iter(self) -> impl Iterator<Item = f64> {
        let step = (self.stop - self.start) / f64::from(self.count.max(2) - 1);
        (0..self.count.max(2)).map(move |i| self.start + step * f64::from(i))
    }
}

/// The exposed radiance that the curve maps to `t`: the positive root of
/// `(A - t C) x^2 + (B - t D) x - t E = 0`.
fn exposed_for(t: f64) -> f64 {
    let (a, b, c) = (A - t * C, B - t * D, -t * E);
    let half = -0.5 * b / a;
    half + (half * half - c / a).sqrt()
}

/// HDR-FLIP of two radiance images and the exposures it took; alpha and negative radiance do not
/// count.
///
/// # Errors
///
/// When the sizes differ, or the images are empty or do not fill their size.
pub fn hdr_flip(
    found: &Image,
    reference: &Image,
    pixels_per_degree: f64,
) -> Result<(ErrorMap, Exposures), SizeMismatch> {
    let size = Size::common(Size::of_image(found), Size::of_image(reference))?;
    let exposures = Exposures::of(reference);
    let filters = Filters::new(pixels_per_degree);
    let mut largest = vec![0.0_f32; found.pixels.len()];
    for stops in exposures.iter() {
        let factor = stops.exp2();
        let shown = |image: &Image| -> Vec<Vec3> {
            let pixels = image.pixels.par_iter();
            pixels.map(|p| tone_mapped(radiance(p), factor)).collect()
        };
        let found = errors(size, &shown(found), &shown(reference), &filters);
        for (largest, error) in largest.iter_mut().zip(found) {
            *largest = largest.max(error);
        }
    }
    Ok((size.map(largest), exposures))
}

fn radiance(&[r, g, b, _]: &[f32; 4]) -> Vec3 {
    Vec3::new(r, g, b).max(Vec3::ZERO)
}

/// The curve, cut to [0, 1]. In f64, where the square of a finite radiance stays finite.
fn tone_mapped(radiance: Vec3, factor: f64) -> Vec3 {
    radiance.map(|v| {
        let x = f64::from(v) * factor;
        let mapped = (A * x * x + B * x) / (C * x * x + D * x + E);
        mapped.clamp(0.0, 1.0) as f32
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_root_is_mapped_to_its_target() {
        let x = exposed_for(TARGET);
        let mapped = (A * x * x + B * x) / (C * x * x + D * x + E);
        assert!((mapped - TARGET).abs() < 1e-12, "{x} {mapped}");
    }
}
