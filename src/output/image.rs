//! The two kinds of picture: linear radiance, and what a display shows.

use std::path::Path;

use super::OutputError;

/// Most pixels a picture read from a file may have: the largest image Tyndall renders.
///
/// A damaged header must not make the reader ask for all of the memory.
pub const MAX_PIXELS: u64 = 16384 * 16384;

/// Linear radiance, as rendered.
///
/// RGB is the radiance that arrives at the camera, Rec.709 primaries, background included:
/// `L + T L_b`. Alpha is `1 - T`, the opacity of the volume alone.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Image {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// RGBA, row by row from the top left.
    pub pixels: Vec<[f32; 4]>,
}

impl Image {
    /// The pixel in column `x` (0 is the left) and row `y` (0 is the top), if it exists.
    #[must_use]
    pub fn pixel(&self, x: u32, y: u32) -> Option<[f32; 4]> {
        let index = y as usize * self.width as usize + x as usize;
        (x < self.width && y < self.height).then(|| self.pixels.get(index).copied())?
    }

    /// Number of pixels with a NaN or an infinity in any channel.
    ///
    /// A PNG shows them as 0 in all channels; an EXR keeps them as they are.
    #[must_use]
    pub fn non_finite(&self) -> usize {
        self.pixels.iter().filter(|p| !is_finite(p)).count()
    }

    /// An error that names `path` unless there is one pixel for each position.
    pub(super) fn check(&self, path: &Path) -> Result<(), OutputError> {
        check(path, self.width, self.height, self.pixels.len())
    }
}

/// How sure an [`Image`] of random samples is.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Variance {
    /// Variance of each pixel's mean (its squared standard error): red, green, blue, in squared
    /// radiance, in the order of the image's pixels.
    pub pixels: Vec<[f32; 3]>,
}

impl Variance {
    /// An error that names `path` unless there is one variance for each pixel of `image`.
    pub(super) fn check(&self, path: &Path, image: &Image) -> Result<(), OutputError> {
        check(path, image.width, image.height, self.pixels.len())
    }
}

/// What a display shows: sRGB-encoded values in [0, 1] with straight alpha.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Display {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// RGBA, row by row from the top left.
    pub pixels: Vec<[f32; 4]>,
}

impl Display {
    /// The nearest 8-bit levels.
    #[must_use]
    pub fn levels(&self) -> Vec<[u8; 4]> {
        self.pixels.iter().map(|p| p.map(level_8)).collect()
    }

    /// An error that names `path` unless there is one pixel for each position.
    pub(super) fn check(&self, path: &Path) -> Result<(), OutputError> {
        check(path, self.width, self.height, self.pixels.len())
    }
}

/// Whether no channel is NaN or infinite.
pub(super) fn is_finite(pixel: &[f32; 4]) -> bool {
    pixel.iter().all(|v| v.is_finite())
}

/// The nearest of 256 levels; no dithering, so the same value is always the same level.
///
/// `as` saturates: values outside [0, 1] go to the nearest end, NaN to 0.
pub(super) fn level_8(value: f32) -> u8 {
    (value * 255.0 + 0.5) as u8
}

/// The nearest of 65536 levels.
pub(super) fn level_16(value: f32) -> u16 {
    (value * 65535.0 + 0.5) as u16
}

fn check(path: &Path, width: u32, height: u32, pixels: usize) -> Result<(), OutputError> {
    let expected = u64::from(width) * u64::from(height);
    if expected == 0 || expected != pixels as u64 {
        return Err(OutputError::Size {
            path: path.to_owned(),
            width,
            height,
            pixels,
        });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_are_the_nearest() {
        for level in 0..=255_u8 {
            let value = f32::from(level) / 255.0;
            assert_eq!(level_8(value), level);
            assert_eq!(level_8(value + 0.49 / 255.0), level);
            assert_eq!(level_8(value - 0.49 / 255.0), level);
        }
        for level in 0..=u16::MAX {
            assert_eq!(level_16(f32::from(level) / 65535.0), level);
        }
    }

    #[test]
    fn levels_saturate() {
        for (value, level) in [
            (-1.0, 0),
            (2.0, 255),
            (f32::INFINITY, 255),
            (f32::NAN, 0),
            (f32::NEG_INFINITY, 0),
        ] {
            assert_eq!(level_8(value), level, "{value}");
        }
        assert_eq!(level_16(2.0), 65535);
        assert_eq!(level_16(f32::NAN), 0);
    }

    #[test]
    fn non_finite_pixels_are_counted_once() {
        let image = Image {
            width: 3,
            height: 1,
            pixels: vec![
                [f32::NAN, f32::NAN, 0.0, 1.0],
                [0.0; 4],
                [0.0, 0.0, f32::NEG_INFINITY, 1.0],
            ],
        };
        assert_eq!(image.non_finite(), 2);
    }
}
