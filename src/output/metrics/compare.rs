//! All measures of two images at once.

use serde::Serialize;

use super::check::{self, CompareError, Side, Size};
use super::errors::{Errors, RELATIVE_EPSILON, Values, errors};
use super::flip::{ErrorMap, Exposures, PIXELS_PER_DEGREE, hdr_flip, ldr_flip};
use super::psnr::psnr;
use super::ssim::ssim;
use super::z_score::{ZScore, z_score};
use crate::output::tone_map::{Alpha, ToneMapping, expose, to_display};
use crate::output::{Display, Image, Variance};
use crate::scene::{Exposure, ToneMap};

/// What the measures depend on besides the images.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CompareOptions {
    /// Exposure of both images for what is measured as shown; `Auto` is the reference's.
    pub exposure: Exposure,
    /// Tone map of both.
    pub tone_map: ToneMap,
    /// See [`Errors::relative_mse`]; above 0, in squared radiance.
    pub relative_epsilon: f64,
    /// For FLIP; see [`PIXELS_PER_DEGREE`].
    pub pixels_per_degree: f64,
}

impl Default for CompareOptions {
    fn default() -> Self {
        Self {
            exposure: Exposure::Auto,
            tone_map: ToneMap::default(),
            relative_epsilon: RELATIVE_EPSILON,
            pixels_per_degree: PIXELS_PER_DEGREE,
        }
    }
}

/// Radiance and, where it was estimated from random samples, how sure it is.
#[derive(Clone, Copy, Debug)]
pub struct Estimate<'a> {
    /// Linear radiance.
    pub image: &'a Image,
    /// Variances of the pixels' means.
    pub variance: Option<&'a Variance>,
}

impl<'a> From<&'a Image> for Estimate<'a> {
    fn from(image: &'a Image) -> Self {
        Self {
            image,
            variance: None,
        }
    }
}

/// Everything that was measured.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Of the values given: linear radiance or display values.
    pub errors: Errors,
    /// Of the images as a display shows them.
    pub shown: Shown,
    /// Of radiance only.
    pub hdr_flip: Option<HdrFlip>,
    /// Of radiance with the variances of at least one image.
    pub z_score: Option<ZScore>,
    /// LDR-FLIP of each pixel.
    #[serde(skip)]
    pub flip_map: ErrorMap,
}

/// Measures of display values in [0, 1], not rounded to levels.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Shown {
    /// Exposure of both images in stops; `None` for pictures that came as display values.
    pub stops: Option<f32>,
    /// Tone map of both; likewise.
    pub tone_map: Option<ToneMap>,
    /// Root of the mean squared difference of red, green and blue.
    pub rmse: f64,
    /// PSNR in dB with the peak 1; infinite (in JSON `null`) for equal pictures.
    pub psnr: f64,
    /// Mean structural similarity; `None` where a side is shorter than 11 pixels.
    pub ssim: Option<f64>,
    /// LDR-FLIP.
    pub flip: Pooled,
    /// Pixels per degree of sight that FLIP took.
    pub pixels_per_degree: f64,
}

/// An error map in two numbers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Pooled {
    /// Mean error.
    pub mean: f64,
    /// Largest error.
    pub largest: f64,
}

impl From<&ErrorMap> for Pooled {
    fn from(map: &ErrorMap) -> Self {
        Self {
            mean: map.mean(),
            largest: map.largest(),
        }
    }
}

/// HDR-FLIP.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct HdrFlip {
    /// Mean and largest error.
    #[serde(flatten)]
    pub error: Pooled,
    /// What the images were seen at.
    pub exposures: Exposures,
}

/// Compares radiance: values, then both as shown with the same exposure, then HDR-FLIP, then
/// z-scores where there is a variance.
///
/// # Errors
///
/// When the sizes differ, an image is empty or has NaNs or infinities, or a variance is negative,
/// not finite or missing for a pixel.
pub fn compare_images<'a>(
    found: impl Into<Estimate<'a>>,
    reference: impl Into<Estimate<'a>>,
    options: &CompareOptions,
) -> Result<Comparison, CompareError> {
    let (found, reference) = (found.into(), reference.into());
    let (a, b) = (found.image, reference.image);
    let size = check::size(Size::of_image(a), Size::of_image(b))?;
    for (side, estimate) in [(Side::Found, found), (Side::Reference, reference)] {
        check::finite(side, size.width, &estimate.image.pixels)?;
        check::variance(side, estimate.image, estimate.variance)?;
    }
    let values = Values::Radiance {
        relative_epsilon: options.relative_epsilon,
    };
    let mapping = ToneMapping {
        stops: expose(b, options.exposure),
        operator: options.tone_map,
    };
    let show = |image| to_display(image, &mapping, Alpha::Opaque);
    let (mut shown, flip_map) = shown(&show(a), &show(b), options)?;
    shown.stops = Some(mapping.stops);
    shown.tone_map = Some(mapping.operator);
    let (hdr_map, exposures) = hdr_flip(a, b, options.pixels_per_degree)?;
    Ok(Comparison {
        width: size.width,
        height: size.height,
        errors: errors(size.width, &a.pixels, &b.pixels, values),
        shown,
        hdr_flip: Some(HdrFlip {
            error: Pooled::from(&hdr_map),
            exposures,
        }),
        z_score: scores(found, reference),
        flip_map,
    })
}

fn scores(found: Estimate, reference: Estimate) -> Option<ZScore> {
    found.variance.or(reference.variance)?;
    Some(z_score(
        found.image.width,
        &found.image.pixels,
        &reference.image.pixels,
        found.variance.map(|v| &*v.pixels),
        reference.variance.map(|v| &*v.pixels),
    ))
}

/// Compares pictures that are display values already, such as PNGs.
///
/// # Errors
///
/// When the sizes differ, a picture is empty or has NaNs or infinities.
pub fn compare_displays(
    found: &Display,
    reference: &Display,
    options: &CompareOptions,
) -> Result<Comparison, CompareError> {
    let size = check::size(Size::of_display(found), Size::of_display(reference))?;
    check::finite(Side::Found, size.width, &found.pixels)?;
    check::finite(Side::Reference, size.width, &reference.pixels)?;
    let (shown, flip_map) = shown(found, reference, options)?;
    Ok(Comparison {
        width: size.width,
        height: size.height,
        errors: errors(
            size.width,
            &found.pixels,
            &reference.pixels,
            Values::Display,
        ),
        shown,
        hdr_flip: None,
        z_score: None,
        flip_map,
    })
}

fn shown(
    found: &Display,
    reference: &Display,
    options: &CompareOptions,
) -> Result<(Shown, ErrorMap), CompareError> {
    let map = ldr_flip(found, reference, options.pixels_per_degree)?;
    let errors = errors(
        found.width,
        &found.pixels,
        &reference.pixels,
        Values::Display,
    );
    let shown = Shown {
        stops: None,
        tone_map: None,
        rmse: errors.rmse,
        psnr: psnr(errors.rmse, 1.0),
        ssim: ssim(found, reference),
        flip: Pooled::from(&map),
        pixels_per_degree: options.pixels_per_degree,
    };
    Ok((shown, map))
}
