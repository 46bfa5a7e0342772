//! How far two pictures are apart, in 8-bit levels.

use super::Display;

/// The distance of two pictures of the same size.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Difference {
    /// Largest difference of any channel of any pixel, in levels.
    pub max_level: u8,
    /// Pixels in which some channel differs by more than the tolerance.
    pub pixels_beyond: usize,
    /// Root of the mean squared difference over all four channels, in levels.
    pub rmse: f64,
}

/// Two pictures of different size cannot be compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "found a picture of {found_width} x {found_height}, expected {expected_width} x {expected_height}"
)]
pub struct SizeMismatch {
    /// Pixels across of the first picture.
    pub found_width: u32,
    /// Pixels down of the first picture.
    pub found_height: u32,
    /// Pixels across of the second picture.
    pub expected_width: u32,
    /// Pixels down of the second picture.
    pub expected_height: u32,
}

/// Compares two pictures after rounding both to 8 bits.
///
/// # Errors
///
/// When their sizes differ.
pub fn compare(
    found: &Display,
    expected: &Display,
    tolerance: u8,
) -> Result<Difference, SizeMismatch> {
    let mut difference = Difference::default();
    let mut squares = 0_u64;
    for pixel in distances(found, expected)? {
        let largest = pixel.into_iter().fold(0, u8::max);
        difference.max_level = difference.max_level.max(largest);
        difference.pixels_beyond += usize::from(largest > tolerance);
        squares += pixel.iter().map(|&d| u64::from(d).pow(2)).sum::<u64>();
    }
    let channels = 4 * found.pixels.len().max(1);
    difference.rmse = (squares as f64 / channels as f64).sqrt();
    Ok(difference)
}

/// An opaque picture of the differences, each multiplied by `gain`, black where there is none.
///
/// A difference in alpha lightens all three channels.
///
/// # Errors
///
/// When the sizes differ.
pub fn picture(found: &Display, expected: &Display, gain: f32) -> Result<Display, SizeMismatch> {
    let pixels = distances(found, expected)?
        .map(|[r, g, b, a]| {
            let shown = |d: u8| (f32::from(d.max(a)) / 255.0 * gain).clamp(0.0, 1.0);
            [shown(r), shown(g), shown(b), 1.0]
        })
        .collect();
    Ok(Display {
        width: found.width,
        height: found.height,
        pixels,
    })
}

/// Absolute differences of the levels, pixel by pixel.
fn distances(
    found: &Display,
    expected: &Display,
) -> Result<impl Iterator<Item = [u8; 4]>, SizeMismatch> {
    if (found.width, found.height) != (expected.width, expected.height) {
        return Err(SizeMismatch {
            found_width: found.width,
            found_height: found.height,
            expected_width: expected.width,
            expected_height: expected.height,
        });
    }
    let pairs = found.levels().into_iter().zip(expected.levels());
    Ok(pairs.map(|(a, b)| std::array::from_fn(|i| a[i].abs_diff(b[i]))))
}
