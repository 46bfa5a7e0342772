//! Telling the object from its background by the histogram.

use super::Statistics;

/// A lowest bin with this share of the voxels is background by itself.
const SOLID_BACKGROUND: f64 = 0.4;

/// An empty stretch of this share of the range, above the lowest bin, makes that bin padding.
const PADDING_GAP: f64 = 0.1;

/// Share of the foreground's voxels that lie below its bright end.
const BRIGHT_END: f64 = 0.995;

impl Statistics {
    /// Share of the finite voxels with a data value in `[low, high]`, to a bin.
    #[must_use]
    pub fn share(&self, low: f64, high: f64) -> f64 {
        let inside = self
            .bins()
            .filter(|(value, _)| (low..=high).contains(value));
        inside.map(|(_, count)| count).sum::<f64>() / (self.finite() as f64).max(1.0)
    }

    /// Share of the finite voxels in the lowest bin.
    #[must_use]
    pub fn background_share(&self) -> f64 {
        self.histogram.first().map_or(0.0, |n| *n as f64) / (self.finite() as f64).max(1.0)
    }

    /// Where the background ends and where the foreground's bright end is, as data values.
    ///
    /// Padding (a negative lowest value far from all others) is ignored. Where the lowest bin holds much of
    /// the volume it is the background; otherwise Otsu's threshold between the two classes of the
    /// histogram decides, taken a little lower so that blurred edges stay in.
    #[must_use]
    pub fn foreground(&self) -> (f64, f64) {
        let bins: Vec<_> = self.bins().collect();
        let populated = |from: usize| (from..bins.len()).find(|i| bins[*i].1 > 0.0);
        let start = match (populated(0), populated(1)) {
            (Some(0), Some(next))
                if self.min < 0.0 && next as f64 > PADDING_GAP * bins.len() as f64 =>
            {
                next
            }
            _ => 0,
        };
        let bins = &bins[start..];
        let total: f64 = bins.iter().map(|b| b.1).sum();
        let first = bins.first().map_or(0.0, |b| b.1);
        if total <= first || self.max <= self.min {
            return (self.min, self.min + self.min.abs().max(1.0));
        }
        let threshold = if first > SOLID_BACKGROUND * total {
            1
        } else {
            otsu(bins, total)
        };
        let high = bright_end(bins, threshold);
        let (low_value, high_value) = (bins[threshold].0, bins[high].0);
        let base = bins[0].0;
        let low = if threshold == 1 {
            base + 0.06 * (high_value - base)
        } else {
            base + 0.8 * (low_value - base)
        };
        (
            low,
            high_value.max(low + (self.max - self.min) / Self::BINS as f64),
        )
    }

    /// Middle value and count of every bin.
    fn bins(&self) -> impl Iterator<Item = (f64, f64)> {
        let n = self.histogram.len().max(1) as f64;
        self.histogram.iter().enumerate().map(move |(i, count)| {
            let t = (i as f64 + 0.5) / n;
            (self.min * (1.0 - t) + self.max * t, *count as f64)
        })
    }
}

/// The bin at which the variance between the two classes is largest [Otsu1979]; the brightest two
/// parts in a thousand are left out, or a few hot voxels would pull it up.
fn otsu(bins: &[(f64, f64)], total: f64) -> usize {
    let mut end = bins.len();
    let mut bright = 0.0;
    while end > 2 && bright + bins[end - 1].1 < 0.002 * total {
        end -= 1;
        bright += bins[end].1;
    }
    let bins = &bins[..end];
    let total: f64 = bins.iter().map(|b| b.1).sum();
    let moment = |b: &[(f64, f64)]| {
        b.iter()
            .enumerate()
            .map(|(i, b)| i as f64 * b.1)
            .sum::<f64>()
    };
    let all = moment(bins);
    let (mut below, mut below_moment) = (0.0, 0.0);
    // First and last bin of the best plateau: between two clear peaks every bin is as good.
    let (mut first, mut last, mut best) = (1, 1, 0.0);
    for i in 1..bins.len() {
        below += bins[i - 1].1;
        below_moment += (i - 1) as f64 * bins[i - 1].1;
        let above = total - below;
        if below <= 0.0 || above <= 0.0 {
            continue;
        }
        let apart = below_moment / below - (all - below_moment) / above;
        let variance = below * above * apart * apart;
        if variance > best * (1.0 + 1e-9) {
            (first, best) = (i, variance);
        }
        if variance >= best * (1.0 - 1e-9) {
            last = i;
        }
    }
    first.midpoint(last)
}

/// The bin below which most of the foreground lies.
fn bright_end(bins: &[(f64, f64)], threshold: usize) -> usize {
    let total: f64 = bins[threshold..].iter().map(|b| b.1).sum();
    let mut sum = 0.0;
    for (i, bin) in bins.iter().enumerate().skip(threshold) {
        sum += bin.1;
        if sum >= BRIGHT_END * total {
            return i;
        }
    }
    bins.len() - 1
}

#[cfg(test)]
mod tests {
    use super::*;

    fn statistics(min: f64, max: f64, counts: &[(usize, u64)]) -> Statistics {
        let mut histogram = vec![0; Statistics::BINS];
        for (bin, count) in counts {
            histogram[*bin] = *count;
        }
        Statistics {
            min,
            max,
            mean: 0.0,
            nan: 0,
            infinite: 0,
            histogram,
        }
    }

    #[test]
    fn threshold_lies_between_two_peaks() {
        let s = statistics(
            0.0,
            1023.0,
            &[(50, 5000), (60, 4000), (600, 4000), (700, 3000)],
        );
        let (low, high) = s.foreground();
        assert!(
            low > 61.0 && low < 600.0 && (699.0..702.0).contains(&high),
            "{low} {high}"
        );
    }

    #[test]
    fn padding_and_empty_background_are_not_foreground() {
        let s = statistics(
            -2000.0,
            4095.0,
            &[(0, 90_000), (340, 20_000), (345, 20_000), (720, 9_000)],
        );
        let (low, _) = s.foreground();
        assert!(low > 100.0 && low < 2300.0, "{low}");
        let (low, high) =
            statistics(0.0, 255.0, &[(0, 99_000), (400, 500), (900, 500)]).foreground();
        assert!(low > 0.0 && low < 90.0 && high > 220.0, "{low} {high}");
    }

    #[test]
    fn constant_and_empty_volumes_have_a_range_all_the_same() {
        for s in [statistics(3.0, 3.0, &[(0, 10)]), statistics(0.0, 0.0, &[])] {
            let (low, high) = s.foreground();
            assert!(low < high);
        }
    }
}
