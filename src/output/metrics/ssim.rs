//! Structural similarity `[Wang2004]`.

use super::filter::{Plane, gaussian};
use crate::output::Display;

/// Half of the window's side: it has 11 x 11 pixels.
const RADIUS: usize = 5;
/// Standard deviation of the window's Gaussian weights, in pixels.
const SIGMA: f64 = 1.5;
/// `(K1 L)^2` with `K1 = 0.01`; display values have the range `L = 1`.
const C1: f64 = 0.01 * 0.01;
/// `(K2 L)^2` with `K2 = 0.03`.
const C2: f64 = 0.03 * 0.03;

/// Mean structural similarity, at most 1, which is reached by equal pictures `[Wang2004, Eq. 13]`.
///
/// It is taken on the weighted sum of the encoded channels (Rec.709 weights), which is close to
/// what the eye sees, with Gaussian windows of 11 x 11 pixels. Only windows that lie wholly within
/// the picture count, so the outermost five rows and columns are seen through their neighbours'
/// windows alone; `None` where a side is shorter than 11 pixels or the sizes differ.
#[must_use]
pub fn ssim(found: &Display, reference: &Display) -> Option<f64> {
    let (width, height) = (found.width as usize, found.height as usize);
    let same = (found.width, found.height) == (reference.width, reference.height);
    if !same || width.min(height) <= 2 * RADIUS {
        return None;
    }
    let pairs: Vec<[f64; 2]> = found
        .pixels
        .iter()
        .zip(&reference.pixels)
        .map(|(a, b)| [luma(a), luma(b)])
        .collect();
    let weights = gaussian(RADIUS, SIGMA);
    let mean = |value: fn(&[f64; 2]) -> f64| {
        let plane = Plane::new(width, &pairs, value);
        plane.filtered(&weights, &weights).values
    };
    let (a, b) = (mean(|p| p[0]), mean(|p| p[1]));
    let (aa, bb) = (mean(|p| p[0] * p[0]), mean(|p| p[1] * p[1]));
    let ab = mean(|p| p[0] * p[1]);
    let inside = (RADIUS..height - RADIUS)
        .flat_map(|y| (RADIUS..width - RADIUS).map(move |x| y * width + x));
    let count = (height - 2 * RADIUS) * (width - 2 * RADIUS);
    let sum: f64 = inside
        .map(|i| similarity(a[i], b[i], aa[i], bb[i], ab[i]))
        .sum();
    Some(sum / count as f64)
}

/// One window, from its means and the means of its squares and products.
fn similarity(a: f64, b: f64, aa: f64, bb: f64, ab: f64) -> f64 {
    let variances = (aa - a * a) + (bb - b * b);
    let covariance = ab - a * b;
    (2.0 * a * b + C1) * (2.0 * covariance + C2) / ((a * a + b * b + C1) * (variances + C2))
}

fn luma(&[r, g, b, _]: &[f32; 4]) -> f64 {
    0.2126 * f64::from(r) + 0.7152 * f64::from(g) + 0.0722 * f64::from(b)
}
