//! FLIP: how large the difference of two pictures looks when one flips between them.
//!
//! | step | file |
//! |---|---|
//! | opponent colours, Lab, distance of colours | `color` |
//! | what the eye resolves; edges and points | `seen` |
//! | both joined to one error: LDR-FLIP `[Andersson2020]` | here |
//! | its maximum over exposures: HDR-FLIP `[Andersson2021]` | `hdr` |
//! | the map as a picture | `picture` |

mod color;
mod hdr;
mod picture;
mod seen;

use glam::Vec3;
use rayon::prelude::*;

use self::color::DistanceScale;
use self::seen::{Filters, Seen};
use super::Size;
use crate::output::Display;
use crate::output::difference::SizeMismatch;
use crate::scene::linear_from_srgb;

pub use hdr::{Exposures, hdr_flip};
pub use picture::picture;

/// Pixels per degree of sight of who sits 0.7 m before a display 0.7 m and 3840 pixels wide, the
/// setting of `[Andersson2020]`: `distance * pixels / width * pi / 180`.
pub const PIXELS_PER_DEGREE: f64 = 3840.0 * std::f64::consts::PI / 180.0;

/// Fewest pixels per degree that are taken; below, the filters are narrower than a pixel.
pub const MIN_PIXELS_PER_DEGREE: f64 = 1.0;

/// Most pixels per degree that are taken: beyond, the filters are wider than any display.
pub const MAX_PIXELS_PER_DEGREE: f64 = 1000.0;

/// Rows that are worked on together, at least: whole planes of large images would be fresh memory
/// at each step, which costs more than the arithmetic.
const BAND: usize = 64;

/// One error for each pixel: 0 where no difference is seen, 1 for the largest.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ErrorMap {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Errors in [0, 1], row by row from the top left.
    pub values: Vec<f32>,
}

impl ErrorMap {
    /// Mean error, 0 for an empty map.
    #[must_use]
    pub fn mean(&self) -> f64 {
        let sum: f64 = self.values.iter().map(|&v| f64::from(v)).sum();
        sum / self.values.len().max(1) as f64
    }

    /// Largest error.
    #[must_use]
    pub fn largest(&self) -> f64 {
        f64::from(self.values.iter().copied().fold(0.0, f32::max))
    }
}

/// LDR-FLIP of two pictures `[Andersson2020]`; their alpha does not count.
///
/// `pixels_per_degree` is kept within [`MIN_PIXELS_PER_DEGREE`] and [`MAX_PIXELS_PER_DEGREE`]; NaN
/// counts as [`PIXELS_PER_DEGREE`].
///
/// # Errors
///
/// When the sizes differ, or the pictures are empty or do not fill their size.
pub fn ldr_flip(
    found: &Display,
    reference: &Display,
    pixels_per_degree: f64,
) -> Result<ErrorMap, SizeMismatch> {
    let size = Size::common(Size::of_display(found), Size::of_display(reference))?;
    let linear = |display: &Display| -> Vec<Vec3> {
        let pixels = display.pixels.par_iter();
        pixels
            .map(|&[r, g, b, _]| Vec3::new(r, g, b).map(linear_from_srgb))
            .collect()
    };
    let filters = Filters::new(pixels_per_degree);
    let values = errors(size, &linear(found), &linear(reference), &filters);
    Ok(size.map(values))
}

/// LDR-FLIP of linear RGB in [0, 1], pixel by pixel.
fn errors(size: Size, found: &[Vec3], reference: &[Vec3], filters: &Filters) -> Vec<f32> {
    let width = size.width as usize;
    let scale = DistanceScale::new();
    let radius = filters.radius();
    let band = BAND.max(radius) * width;
    let mut errors = vec![0.0; found.len()];
    let bands = errors.par_chunks_mut(band).enumerate();
    bands.for_each(|(i, errors)| {
        // With the rows that the filters reach, which are seen wrongly themselves.
        let start = (i * band).saturating_sub(radius * width);
        let end = (i * band + errors.len() + radius * width).min(found.len());
        let seen = |pixels: &[Vec3]| Seen::new(width, &pixels[start..end], filters);
        let (found, reference) = (seen(found), seen(reference));
        let pairs = found.pixels.iter().zip(&reference.pixels);
        let inner = pairs.skip(i * band - start);
        for (error, (a, b)) in errors.iter_mut().zip(inner) {
            let color = scale.error(a.lab, b.lab);
            // The more an edge or a point changes, the closer to 1 is the error
            // `[Andersson2020, Eq. 8]`.
            *error = color.powf(1.0 - a.feature_difference(b));
        }
    });
    errors
}
