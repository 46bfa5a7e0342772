//! From linear radiance to display values: exposure, tone map, sRGB encoding, in this order.

use glam::Vec3;
use rayon::prelude::*;

use super::image::is_finite;
use super::{Display, Image};
use crate::scene::{Exposure, ToneMap, srgb_from_linear};

/// Automatic exposure stays within this many stops, so that the noise of an all but black image
/// is not made white.
pub const MAX_AUTO_STOPS: f32 = 20.0;

/// Stops given by hand stay within this, where `2^stops` is a finite number above 0.
const MAX_STOPS: f32 = 100.0;

/// Share of the covered pixels that automatic exposure keeps at or below [`AUTO_TARGET`].
const AUTO_PERCENTILE: f64 = 0.99;

/// Exposed luminance of the pixel at [`AUTO_PERCENTILE`].
const AUTO_TARGET: f32 = 0.8;

/// Exposed radiance is cut here: far beyond white for every operator, far from overflow.
const MAX_EXPOSED: f32 = 1e6;

/// How radiance becomes display values; exposure is resolved by [`expose`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ToneMapping {
    /// Radiance is multiplied by `2^stops`.
    pub stops: f32,
    /// The curve after it.
    pub operator: ToneMap,
}

/// What becomes of alpha.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Alpha {
    /// The background stays in the colour; every pixel is opaque.
    #[default]
    Opaque,
    /// The background is taken out of the colour again and alpha is stored beside it.
    ///
    /// Pixels hold `L + T L_b`. `L = pixel - (1 - alpha) L_b` is what the volume itself sends, and
    /// is premultiplied: `L / alpha` is the radiance of an opaque thing of this look. That
    /// straight colour is exposed, tone-mapped and encoded; alpha is stored as it is. So the
    /// picture lies over any page like a layer. A curve is not linear, so laying it over the
    /// scene's own background gives the opaque picture only up to the curve; and a part that
    /// glows but hardly covers, `L > alpha`, is cut at the display's white.
    Straight {
        /// The scene's background `L_b`, linear RGB.
        background: Vec3,
    },
}

/// Luminance of linear RGB with Rec.709 primaries.
#[must_use]
pub fn luminance(rgb: Vec3) -> f32 {
    rgb.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}

/// Resolves an exposure to stops.
///
/// `Auto` brings the 99th percentile (nearest rank) of the luminance of the covered pixels, those
/// with alpha > 0, to 0.8, within ±[`MAX_AUTO_STOPS`]. Pixels that are not finite do not count.
/// With nothing covered, or all of it black, the answer is 0.
#[must_use]
pub fn expose(image: &Image, exposure: Exposure) -> f32 {
    match exposure {
        Exposure::Auto => automatic_stops(image),
        Exposure::Stops(stops) if stops.is_finite() => stops.clamp(-MAX_STOPS, MAX_STOPS),
        Exposure::Stops(_) => 0.0,
    }
}

fn automatic_stops(image: &Image) -> f32 {
    let mut covered: Vec<f32> = image
        .pixels
        .iter()
        .filter(|p| is_finite(p) && p[3] > 0.0)
        .map(|&[r, g, b, _]| luminance(Vec3::new(r, g, b)))
        .collect();
    if covered.is_empty() {
        return 0.0;
    }
    let rank = (AUTO_PERCENTILE * covered.len() as f64).ceil() as usize;
    let index = rank.clamp(1, covered.len()) - 1;
    let (_, &mut bright, _) = covered.select_nth_unstable_by(index, f32::total_cmp);
    // Also false for the sum of huge channels that is not finite.
    if bright > 0.0 && bright.is_finite() {
        let stops = AUTO_TARGET.log2() - bright.log2();
        stops.clamp(-MAX_AUTO_STOPS, MAX_AUTO_STOPS)
    } else {
        0.0
    }
}

/// Brings exposed linear RGB into [0, 1], still linear. Negative radiance counts as 0.
#[must_use]
pub fn apply(operator: ToneMap, rgb: Vec3) -> Vec3 {
    let rgb = rgb.clamp(Vec3::ZERO, Vec3::splat(MAX_EXPOSED));
    let mapped = match operator {
        ToneMap::Clamp => rgb,
        // On luminance: hue and saturation stay, so a pure colour can still leave the range.
        ToneMap::Reinhard => rgb / (1.0 + luminance(rgb)),
        ToneMap::Filmic => filmic(rgb),
    };
    mapped.min(Vec3::ONE)
}

/// Narkowicz's rational fit of the ACES curve, channel by channel.
fn filmic(x: Vec3) -> Vec3 {
    (x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14)
}

/// The display values of an image; a pixel that is not finite becomes 0 in all channels (see
/// [`Image::non_finite`]).
#[must_use]
pub fn to_display(image: &Image, mapping: &ToneMapping, alpha: Alpha) -> Display {
    let factor = expose(image, Exposure::Stops(mapping.stops)).exp2();
    let pixel = |&pixel: &[f32; 4]| {
        if !is_finite(&pixel) {
            return [0.0; 4];
        }
        let (colour, opacity) = layer(pixel, alpha);
        let rgb = apply(mapping.operator, colour * factor);
        let [r, g, b] = rgb.to_array().map(srgb_from_linear);
        [r, g, b, opacity]
    };
    Display {
        width: image.width,
        height: image.height,
        pixels: image.pixels.par_iter().map(pixel).collect(),
    }
}

/// Linear straight colour and opacity of a finite pixel.
fn layer([r, g, b, a]: [f32; 4], alpha: Alpha) -> (Vec3, f32) {
    let colour = Vec3::new(r, g, b);
    match alpha {
        Alpha::Opaque => (colour, 1.0),
        Alpha::Straight { background } => {
            let a = a.clamp(0.0, 1.0);
            if a == 0.0 {
                return (Vec3::ZERO, 0.0);
            }
            ((colour - (1.0 - a) * background) / a, a)
        }
    }
}
