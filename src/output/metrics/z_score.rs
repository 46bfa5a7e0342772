//! Whether noise explains a difference: z-scores from the variances of the pixels' means.

use serde::Serialize;

use super::errors::CHANNELS;

/// `|z|` that noise passes in 0.27 % of all channels.
const FAR: f64 = 3.0;

/// Differences in units of their standard errors, `z = (a - b) / sqrt(var a + var b)`.
///
/// Where only noise tells two images apart, `z` is close to standard normal: RMS 1, 0.27 % beyond
/// 3. An image without variances counts as exact. A variance of few samples can be far too small,
/// and `z` then far too large: let a pixel have a hundred or more.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ZScore {
    /// Channels of pixels that have a variance; the next three numbers are about them.
    pub channels: u64,
    /// Root of the mean of `z^2`; `None` where no channel has a variance.
    pub rms: Option<f64>,
    /// Share of `|z| > 3`.
    pub share_beyond_3: Option<f64>,
    /// The largest `|z|`.
    pub largest: Option<LargestZ>,
    /// Difference of the means of both images over its standard error `sqrt(sum var) / N`: red,
    /// green, blue. It takes the noise of different pixels as independent.
    pub mean: [Option<f64>; 3],
    /// Probability that noise gives a `|mean|` as large as the largest, at most (as
    /// [`LargestZ::probability`]).
    pub mean_probability: Option<f64>,
    /// Channels of pixels for which both variances are 0.
    pub exact: Exact,
}

/// The channel that noise explains least.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LargestZ {
    /// `(a - b) / sqrt(var a + var b)`, with its sign.
    pub z: f64,
    /// Column, 0 is the left.
    pub x: u32,
    /// Row, 0 is the top.
    pub y: u32,
    /// `R`, `G` or `B`.
    pub channel: char,
    /// Probability that noise gives such a `|z|` anywhere in the image, at most
    /// ([`probability_among`]).
    pub probability: f64,
}

/// Channels without noise on either side: there is no z-score, they are equal or they are not.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Exact {
    /// Channels with the same value.
    pub equal: u64,
    /// Channels with different values.
    pub unequal: u64,
    /// The largest difference among them.
    pub largest_difference: f64,
}

/// Probability that at least one of `count` standard normal numbers is beyond `|z|` on either side:
/// `1 - (1 - erfc(|z| / sqrt 2))^count`.
///
/// Exact for independent numbers; dependent ones, like the channels of a pixel, make it an upper
/// bound `[Sidak1967]`.
#[must_use]
pub fn probability_among(z: f64, count: u64) -> f64 {
    let one = libm::erfc(z.abs() / std::f64::consts::SQRT_2);
    // The straight formula would lose every probability below 1e-16.
    -libm::expm1(count as f64 * libm::log1p(-one))
}

/// Scores of two images of the same pixels, `width` a row (above 0).
///
/// The slices are as long as each other; `None` stands for variances of 0. Variances are finite
/// and not negative.
#[must_use]
pub fn z_score(
    width: u32,
    found: &[[f32; 4]],
    reference: &[[f32; 4]],
    found_variance: Option<&[[f32; 3]]>,
    reference_variance: Option<&[[f32; 3]]>,
) -> ZScore {
    let width = width.max(1) as usize;
    let mut sums = Sums::default();
    for (i, (a, b)) in found.iter().zip(reference).enumerate() {
        let of = |variance: Option<&[[f32; 3]]>| {
            let pixel = variance.and_then(|v| v.get(i)).copied();
            pixel.unwrap_or_default().map(f64::from)
        };
        let (a_variance, b_variance) = (of(found_variance), of(reference_variance));
        for channel in 0..3 {
            let difference = f64::from(a[channel]) - f64::from(b[channel]);
            let variance = a_variance[channel] + b_variance[channel];
            sums.add((i % width, i / width, channel), difference, variance);
        }
    }
    sums.finish()
}

#[derive(Default)]
struct Sums {
    squares: f64,
    beyond: u64,
    /// `z` and where it is: column, row, channel.
    largest: Option<(f64, (usize, usize, usize))>,
    differences: [f64; 3],
    variances: [f64; 3],
    score: ZScore,
}

impl Sums {
    fn add(&mut self, place: (usize, usize, usize), difference: f64, variance: f64) {
        self.differences[place.2] += difference;
        self.variances[place.2] += variance;
        if variance == 0.0 {
            let exact = &mut self.score.exact;
            exact.equal += u64::from(difference == 0.0);
            exact.unequal += u64::from(difference != 0.0);
            exact.largest_difference = exact.largest_difference.max(difference.abs());
            return;
        }
        let z = difference / variance.sqrt();
        self.score.channels += 1;
        self.squares += z * z;
        self.beyond += u64::from(z.abs() > FAR);
        if self.largest.is_none_or(|(old, _)| z.abs() > old.abs()) {
            self.largest = Some((z, place));
        }
    }

    fn finish(self) -> ZScore {
        let channels = self.score.channels;
        let share = |sum: f64| (channels > 0).then(|| sum / channels as f64);
        // The number of pixels cancels: (sum d / N) / (sqrt(sum var) / N).
        let mean: [Option<f64>; 3] = std::array::from_fn(|i| {
            (self.variances[i] > 0.0).then(|| self.differences[i] / self.variances[i].sqrt())
        });
        let means = mean.iter().flatten().count() as u64;
        let largest_mean = mean.iter().flatten().map(|z| z.abs()).reduce(f64::max);
        ZScore {
            rms: share(self.squares).map(f64::sqrt),
            share_beyond_3: share(self.beyond as f64),
            largest: self.largest.map(|(z, (x, y, channel))| LargestZ {
                z,
                x: x as u32,
                y: y as u32,
                channel: CHANNELS[channel],
                probability: probability_among(z, channels),
            }),
            mean,
            mean_probability: largest_mean.map(|z| probability_among(z, means)),
            ..self.score
        }
    }
}
