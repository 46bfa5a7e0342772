//! Errors of the values themselves: RMSE, relative MSE, bias, the largest difference.

use serde::Serialize;

use super::psnr::psnr;

/// The `epsilon` of [`Errors::relative_mse`] unless told otherwise, in squared units of the values.
pub const RELATIVE_EPSILON: f64 = 0.01;

/// How far two images are apart, in the units of their values: linear radiance or display values.
///
/// Means go over all pixels and over red, green and blue; alpha has its own number.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Errors {
    /// Root of the mean of `(a - b)^2`.
    pub rmse: f64,
    /// Mean of `(a - b)^2 / (b^2 + epsilon)`, where `b` is the reference; without unit. Only of
    /// radiance: encoded display values are no quantity to take ratios of.
    pub relative_mse: Option<f64>,
    /// The `epsilon` of `relative_mse`; it keeps dark pixels from deciding alone.
    pub relative_epsilon: f64,
    /// Mean of `a - b` over all channels.
    pub bias: f64,
    /// Mean of `a - b`: red, green, blue.
    pub channel_bias: [f64; 3],
    /// `bias` over the reference's mean; `None` where that is 0.
    pub relative_bias: Option<f64>,
    /// `channel_bias` over the reference's mean of the channel; `None` where that is 0.
    pub relative_channel_bias: [Option<f64>; 3],
    /// `20 log10(peak / rmse)` in dB; infinite (in JSON `null`) for equal images.
    pub psnr: f64,
    /// The `peak` of `psnr`: 1 for display values, the reference's largest channel for radiance.
    pub peak: f64,
    /// RMSE of alpha.
    pub alpha_rmse: f64,
    /// Where red, green or blue differs most; the first such place.
    pub largest: LargestDifference,
}

/// The largest difference of one channel.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct LargestDifference {
    /// `|a - b|`.
    pub difference: f64,
    /// Column, 0 is the left.
    pub x: u32,
    /// Row, 0 is the top.
    pub y: u32,
    /// `R`, `G` or `B`.
    pub channel: char,
    /// The value there.
    pub found: f64,
    /// The reference's value there.
    pub reference: f64,
}

/// Names of the channels of a pixel.
pub(super) const CHANNELS: [char; 3] = ['R', 'G', 'B'];

/// What is known of the values to be compared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Values {
    /// Linear radiance; relative MSE is taken with this epsilon.
    Radiance {
        /// Above 0, in squared radiance.
        relative_epsilon: f64,
    },
    /// Display values in [0, 1].
    Display,
}

/// Compares pixel by pixel; `width` pixels a row, above 0. Pixels without a partner do not count.
#[must_use]
pub fn errors(width: u32, found: &[[f32; 4]], reference: &[[f32; 4]], values: Values) -> Errors {
    let mut sums = Sums::default();
    let epsilon = match values {
        Values::Radiance { relative_epsilon } => relative_epsilon,
        Values::Display => RELATIVE_EPSILON,
    };
    for (i, (a, b)) in found.iter().zip(reference).enumerate() {
        let position = (i % width.max(1) as usize, i / width.max(1) as usize);
        sums.add(position, a.map(f64::from), b.map(f64::from), epsilon);
    }
    sums.finish(found.len().min(reference.len()), values, epsilon)
}

#[derive(Default)]
struct Sums {
    squares: f64,
    relative_squares: f64,
    alpha_squares: f64,
    differences: [f64; 3],
    references: [f64; 3],
    peak: f64,
    largest: LargestDifference,
}

impl Sums {
    fn add(&mut self, (x, y): (usize, usize), a: [f64; 4], b: [f64; 4], epsilon: f64) {
        for (i, channel) in CHANNELS.into_iter().enumerate() {
            let difference = a[i] - b[i];
            self.squares += difference * difference;
            self.relative_squares += difference * difference / (b[i] * b[i] + epsilon);
            self.differences[i] += difference;
            self.references[i] += b[i];
            self.peak = self.peak.max(b[i]);
            let first = (x, y, i) == (0, 0, 0);
            if first || difference.abs() > self.largest.difference {
                self.largest = LargestDifference {
                    difference: difference.abs(),
                    x: x as u32,
                    y: y as u32,
                    channel,
                    found: a[i],
                    reference: b[i],
                };
            }
        }
        self.alpha_squares += (a[3] - b[3]).powi(2);
    }

    fn finish(self, pixels: usize, values: Values, relative_epsilon: f64) -> Errors {
        let pixels = pixels.max(1) as f64;
        let sum = |channels: [f64; 3]| channels.iter().sum::<f64>();
        let ratio = |a: f64, b: f64| (b != 0.0).then(|| a / b);
        let rmse = (self.squares / (3.0 * pixels)).sqrt();
        let (is_display, peak) = match values {
            Values::Display => (true, 1.0),
            Values::Radiance { .. } => (false, self.peak),
        };
        Errors {
            rmse,
            relative_mse: (!is_display).then(|| self.relative_squares / (3.0 * pixels)),
            relative_epsilon,
            bias: sum(self.differences) / (3.0 * pixels),
            channel_bias: self.differences.map(|d| d / pixels),
            relative_bias: ratio(sum(self.differences), sum(self.references)),
            relative_channel_bias: std::array::from_fn(|i| {
                ratio(self.differences[i], self.references[i])
            }),
            psnr: psnr(rmse, peak),
            peak,
            alpha_rmse: (self.alpha_squares / pixels).sqrt(),
            largest: self.largest,
        }
    }
}
