//! What a histogram says about background and foreground.

use crate::volume::Statistics;

/// Voxels of a histogram with, at its lower end, a value that only marks where there are no data.
const PADDING_SHARE: std::ops::Range<f64> = 0.01..0.5;
/// Share of the range that is empty above such a value.
const PADDING_GAP: f64 = 0.1;

/// The part of the range that a relative transfer function is stretched over, in data units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Window {
    /// Upper foot of the background: nothing is visible at or below.
    pub(super) low: f64,
    /// Otsu's threshold between background and foreground; `low <= split <= high`.
    pub(super) split: f64,
    /// Bright end of the foreground, > `low`.
    pub(super) high: f64,
}

/// A histogram with equal bins and the questions asked of it.
#[derive(Clone, Debug)]
pub(super) struct Histogram {
    min: f64,
    bin_width: f64,
    bins: Vec<f64>,
}

impl Histogram {
    /// Of all finite voxels; `None` where they do not span a range.
    pub(super) fn of(statistics: &Statistics) -> Option<Self> {
        let extent = statistics.max - statistics.min;
        let bins: Vec<f64> = statistics.histogram.iter().map(|&n| n as f64).collect();
        let usable = extent > 0.0 && extent.is_finite() && bins.iter().any(|&n| n > 0.0);
        usable.then(|| Self {
            min: statistics.min,
            bin_width: extent / bins.len() as f64,
            bins,
        })
    }

    /// Share of the voxels in `[from, to)`, in [0, 1]; a bin counts by its centre.
    pub(super) fn share(&self, from: f64, to: f64) -> f64 {
        let inside: f64 = self
            .bins
            .iter()
            .enumerate()
            .filter(|&(i, _)| (from..to).contains(&self.edge(i as f64 + 0.5)))
            .map(|(_, n)| n)
            .sum();
        inside / self.bins.iter().sum::<f64>()
    }

    /// Share of the voxels in the lowest bin, in [0, 1].
    pub(super) fn lowest_share(&self) -> f64 {
        self.bins[0] / self.bins.iter().sum::<f64>()
    }

    /// Value of the fullest bin in `[from, to)` after smoothing.
    pub(super) fn mode(&self, from: f64, to: f64) -> f64 {
        let smooth = smoothed(&self.bins);
        let best = (0..smooth.len())
            .filter(|&i| (from..to).contains(&self.edge(i as f64 + 0.5)))
            .max_by(|&a, &b| smooth[a].total_cmp(&smooth[b]));
        best.map_or(from, |i| self.edge(i as f64 + 0.5))
    }

    /// Finds background and foreground.
    pub(super) fn window(&self) -> Window {
        let mut bins = self.bins.clone();
        if self.is_padded() {
            bins[0] = 0.0;
        }
        let split = otsu(&bins);
        let low = background_foot(&bins, split);
        let foreground = &bins[low.ceil() as usize..];
        // 0.5 % of the foreground, not of all voxels: vessels may be all that there is to see.
        let bright = low.ceil() + quantile(foreground, 0.995);
        let last = bins.len() as f64;
        Window {
            low: self.edge(low),
            split: self.edge(split),
            high: self.edge(bright.clamp((split + 1.0).min(last), last)),
        }
    }

    /// Whether the lowest bin is a marker apart from the data (outside a scanner's circle).
    fn is_padded(&self) -> bool {
        let gap = self.bins.iter().skip(1).take_while(|&&n| n == 0.0).count();
        PADDING_SHARE.contains(&self.lowest_share())
            && gap as f64 > PADDING_GAP * self.bins.len() as f64
            // A mask has two values, and its lower one is its background.
            && self.bins.iter().filter(|&&n| n > 0.0).count() > 8
    }

    /// Value at a position in bins; 0 is `min`.
    fn edge(&self, position: f64) -> f64 {
        self.min + position * self.bin_width
    }
}

/// Position, in bins, of the upper foot of the background below `split`: the larger of where the
/// background's peak has fallen to a twentieth, and of Otsu's threshold *within* the part below
/// `split`, which parts a noise floor from the haze between background and foreground.
fn background_foot(bins: &[f64], split: f64) -> f64 {
    let below = &bins[..(split.ceil() as usize).clamp(1, bins.len())];
    let smooth = smoothed(below);
    let peak = (0..smooth.len())
        .max_by(|&a, &b| smooth[a].total_cmp(&smooth[b]))
        .unwrap_or(0);
    let foot = smooth[peak..]
        .iter()
        .position(|&n| n < 0.05 * smooth[peak])
        .map_or(split, |steps| (peak + steps) as f64);
    // At least the lowest bin is background.
    foot.max(otsu(below)).min(split).max(1.0)
}

/// Means over nine bins, which closes the gaps that integers leave in a histogram.
fn smoothed(bins: &[f64]) -> Vec<f64> {
    (0..bins.len())
        .map(|i| {
            let around = &bins[i.saturating_sub(4)..(i + 5).min(bins.len())];
            around.iter().sum::<f64>() / around.len() as f64
        })
        .collect()
}

/// Otsu's threshold as a position in bins: the greatest variance between the two sides.
/// On a plateau (empty bins between the sides) its middle. 0 where all voxels are in one bin.
fn otsu(bins: &[f64]) -> f64 {
    let total: f64 = bins.iter().sum();
    let total_moment: f64 = bins.iter().enumerate().map(|(i, n)| i as f64 * n).sum();
    let (mut weight, mut moment) = (0.0, 0.0);
    let (mut best, mut from, mut to) = (0.0, 0, 0);
    for (i, n) in bins.iter().enumerate() {
        weight += n;
        moment += i as f64 * n;
        let product = weight * (total - weight);
        if product <= 0.0 {
            continue;
        }
        let difference = total_moment * weight / total - moment;
        let between = difference * difference / product;
        if between > best * (1.0 + 1e-9) {
            (best, from, to) = (between, i + 1, i + 1);
        } else if between >= best * (1.0 - 1e-9) && best > 0.0 {
            to = i + 1;
        }
    }
    0.5 * (from + to) as f64
}

/// Position, in bins, below which the share `q` of the counts lies.
fn quantile(bins: &[f64], q: f64) -> f64 {
    let wanted = q * bins.iter().sum::<f64>();
    let mut sum = 0.0;
    for (i, &n) in bins.iter().enumerate() {
        if n > 0.0 && sum + n >= wanted {
            return i as f64 + ((wanted - sum) / n).clamp(0.0, 1.0);
        }
        sum += n;
    }
    bins.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn otsu_is_in_the_middle_of_a_gap() {
        assert_eq!(otsu(&[8.0, 2.0, 0.0, 0.0, 0.0, 0.0, 3.0, 7.0]), 4.0);
        assert_eq!(otsu(&[5.0, 0.0]), 0.0);
        assert_eq!(otsu(&[]), 0.0);
    }

    #[test]
    fn quantiles_interpolate_within_a_bin() {
        assert_eq!(quantile(&[4.0, 0.0, 4.0], 0.25), 0.5);
        assert_eq!(quantile(&[4.0, 0.0, 4.0], 0.75), 2.5);
        assert_eq!(quantile(&[0.0, 0.0], 0.5), 2.0);
    }
}
