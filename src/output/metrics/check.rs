//! What two images must fulfil before any measure says something.

use super::flip::ErrorMap;
use crate::output::difference::SizeMismatch;
use crate::output::{Display, Image, Variance};

/// Which of the two images.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// The one that is judged.
    Found,
    /// The one it is judged by.
    Reference,
}

/// Two images that cannot be compared. The texts name no image; [`CompareError::side`] does.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CompareError {
    /// The sizes differ.
    #[error("{0}; render both at the same size")]
    Size(#[from] SizeMismatch),
    /// The image is empty or does not fill its own size.
    #[error("{width} x {height} picture with {pixels} pixels; expected one for each position")]
    Incomplete {
        /// Which image.
        side: Side,
        /// Pixels across.
        width: u32,
        /// Pixels down.
        height: u32,
        /// Pixels given.
        pixels: usize,
    },
    /// NaN or infinity makes every mean meaningless.
    #[error(
        "{count} of {pixels} pixels are NaN or infinite, the first in column {x}, row {y} \
         {pixel:?}; expected finite values: find out which step made them and render again"
    )]
    NonFinite {
        /// Which image.
        side: Side,
        /// Pixels with a NaN or an infinity in any channel.
        count: usize,
        /// All pixels.
        pixels: usize,
        /// Column of the first, 0 is the left.
        x: usize,
        /// Row of the first, 0 is the top.
        y: usize,
        /// Its RGBA.
        pixel: [f32; 4],
    },
    /// The variances are not those of this image, or none at all.
    #[error("variance layer: {reason}; expected one finite number of 0 or more for each channel")]
    Variance {
        /// Which image.
        side: Side,
        /// What was found.
        reason: String,
    },
}

impl CompareError {
    /// The image at fault; `None` where both are.
    #[must_use]
    pub const fn side(&self) -> Option<Side> {
        match self {
            Self::Size(_) => None,
            Self::Incomplete { side, .. }
            | Self::NonFinite { side, .. }
            | Self::Variance { side, .. } => Some(*side),
        }
    }
}

/// Pixels across and down, and how many there are.
#[derive(Clone, Copy, PartialEq)]
pub(super) struct Size {
    pub(super) width: u32,
    pub(super) height: u32,
    pixels: usize,
}

impl Size {
    pub(super) fn of_image(image: &Image) -> Self {
        Self {
            width: image.width,
            height: image.height,
            pixels: image.pixels.len(),
        }
    }

    pub(super) fn of_display(display: &Display) -> Self {
        Self {
            width: display.width,
            height: display.height,
            pixels: display.pixels.len(),
        }
    }

    /// The size of both, if they are the same and filled.
    pub(super) fn common(found: Self, reference: Self) -> Result<Self, SizeMismatch> {
        if found == reference && found.is_filled() {
            return Ok(found);
        }
        Err(SizeMismatch {
            found_width: found.width,
            found_height: found.height,
            expected_width: reference.width,
            expected_height: reference.height,
        })
    }

    /// Whether there is a pixel, and one for each position.
    fn is_filled(self) -> bool {
        self.pixels > 0 && u64::from(self.width) * u64::from(self.height) == self.pixels as u64
    }

    pub(super) fn map(self, values: Vec<f32>) -> ErrorMap {
        ErrorMap {
            width: self.width,
            height: self.height,
            values,
        }
    }
}

/// The size of both; an error where one is not filled or they differ.
pub(super) fn size(found: Size, reference: Size) -> Result<Size, CompareError> {
    for (side, size) in [(Side::Found, found), (Side::Reference, reference)] {
        if !size.is_filled() {
            return Err(CompareError::Incomplete {
                side,
                width: size.width,
                height: size.height,
                pixels: size.pixels,
            });
        }
    }
    Ok(Size::common(found, reference)?)
}

/// An error unless every channel of every pixel is finite.
pub(super) fn finite(side: Side, width: u32, pixels: &[[f32; 4]]) -> Result<(), CompareError> {
    let is_bad = |pixel: &&[f32; 4]| pixel.iter().any(|v| !v.is_finite());
    let Some(first) = pixels.iter().position(|p| is_bad(&p)) else {
        return Ok(());
    };
    let width = width.max(1) as usize;
    Err(CompareError::NonFinite {
        side,
        count: pixels.iter().filter(is_bad).count(),
        pixels: pixels.len(),
        x: first % width,
        y: first / width,
        pixel: pixels[first],
    })
}

/// An error unless the variances, if there are any, are those of this image.
pub(super) fn variance(
    side: Side,
    image: &Image,
    variance: Option<&Variance>,
) -> Result<(), CompareError> {
    let Some(variance) = variance else {
        return Ok(());
    };
    if variance.pixels.len() != image.pixels.len() {
        let reason = format!(
            "found {} pixels beside {} of colour",
            variance.pixels.len(),
            image.pixels.len()
        );
        return Err(CompareError::Variance { side, reason });
    }
    let is_bad = |pixel: &[f32; 3]| pixel.iter().any(|v| !(v.is_finite() && *v >= 0.0));
    let Some(first) = variance.pixels.iter().position(is_bad) else {
        return Ok(());
    };
    let width = image.width.max(1) as usize;
    let reason = format!(
        "found {:?} in column {}, row {}",
        variance.pixels[first],
        first % width,
        first / width
    );
    Err(CompareError::Variance { side, reason })
}
