//! An error map as a picture.

use glam::Vec3;
use rayon::prelude::*;

use super::ErrorMap;
use crate::output::Display;

/// sRGB levels of errors 0, 1/8 ... 1: black over violet, red and orange to pale yellow, as in the
/// map "magma" of matplotlib (public domain).
///
/// Lightness rises evenly, so equal steps of error look equal and the order survives a grey print
/// and every colour blindness; nine points keep the path within two levels of the original.
const STOPS: [[u8; 3]; 9] = [
    [0, 0, 4],
    [28, 16, 68],
    [79, 18, 123],
    [129, 37, 129],
    [181, 54, 122],
    [229, 80, 100],
    [251, 135, 97],
    [254, 194, 135],
    [252, 253, 191],
];

/// The map as an opaque picture: black where nothing differs, pale yellow for an error of 1.
#[must_use]
pub fn picture(map: &ErrorMap) -> Display {
    let pixels = map.values.par_iter().map(|&error| {
        let [r, g, b] = color(error).to_array();
        [r, g, b, 1.0]
    });
    Display {
        width: map.width,
        height: map.height,
        pixels: pixels.collect(),
    }
}

/// Encoded colour of an error in [0, 1], straight between the stops.
fn color(error: f32) -> Vec3 {
    let last = STOPS.len() - 1;
    let position = error.clamp(0.0, 1.0) * last as f32;
    let index = (position as usize).min(last - 1);
    let stop = |i: usize| Vec3::from(STOPS[i].map(f32::from)) / 255.0;
    stop(index).lerp(stop(index + 1), position - index as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::tone_map::luminance;
    use crate::scene::linear_from_srgb;

    #[test]
    fn lightness_rises_with_the_error() {
        let luminances: Vec<f32> = (0..=100)
            .map(|i| luminance(color(i as f32 / 100.0).map(linear_from_srgb)))
            .collect();
        assert!(luminances.windows(2).all(|w| w[0] < w[1]));
    }
}
