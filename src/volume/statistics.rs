//! What is in a volume: range, histogram, non-finite voxels.

mod union;

use rayon::prelude::*;
use serde::Serialize;

use super::{Rescale, Volume, Voxels};

/// Voxels summed as one unit. Fixed, so that floating point sums are grouped alike, and have the
/// same bits, whatever the number of threads.
const CHUNK: usize = 1 << 19;

/// Statistics of the finite data values (rescaled) of a volume.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Statistics {
    /// Smallest finite data value; 0 if there is none.
    pub min: f64,
    /// Largest finite data value; 0 if there is none.
    pub max: f64,
    /// Mean of the finite data values; 0 if there is none.
    pub mean: f64,
    /// Number of NaN voxels.
    pub nan: u64,
    /// Number of infinite voxels (also those that only the rescaling makes infinite).
    pub infinite: u64,
    /// Voxel counts in equal bins from `min` to `max`; a constant volume is all in the first bin.
    pub histogram: Vec<u64>,
}

impl Statistics {
    /// Bins of the histogram.
    pub const BINS: usize = 1024;

    /// Gathers the statistics of a volume.
    ///
    /// Voxels of at most 16 bits are counted into a table, one pass over memory; wider ones take
    /// a pass for the range and one for mean and histogram. The result does not depend on the
    /// number of threads.
    #[must_use]
    pub fn of(volume: &Volume) -> Self {
        let rescale = volume.rescale;
        match &volume.voxels {
            Voxels::U8(v) => of_narrow(v, 0, 1 << 8, rescale),
            Voxels::I8(v) => of_narrow(v, i32::from(i8::MIN), 1 << 8, rescale),
            Voxels::U16(v) => of_narrow(v, 0, 1 << 16, rescale),
            Voxels::I16(v) => of_narrow(v, i32::from(i16::MIN), 1 << 16, rescale),
            Voxels::U32(v) => of_wide(v, rescale),
            Voxels::I32(v) => of_wide(v, rescale),
            Voxels::F32(v) => of_wide(v, rescale),
            Voxels::F64(v) => of_wide(v, rescale),
        }
    }

    /// Number of voxels with a finite data value.
    #[must_use]
    pub fn finite(&self) -> u64 {
        self.histogram.iter().sum()
    }

    /// Number of NaN and infinite voxels.
    #[must_use]
    pub const fn non_finite(&self) -> u64 {
        self.nan + self.infinite
    }

    /// The data value below which a share `q` (limited to [0, 1]) of the finite voxels lies, with
    /// values taken as evenly spread within a bin: right to `(max - min) / BINS` of the value's
    /// rank. `quantile(0)` is `min`, `quantile(1)` is `max`; a NaN counts as 0.
    #[must_use]
    pub fn quantile(&self, q: f64) -> f64 {
        let q = if q.is_nan() { 0.0 } else { q.clamp(0.0, 1.0) };
        let target = q * self.finite() as f64;
        if target <= 0.0 {
            return self.min;
        }
        let mut below = 0.0;
        for (bin, &count) in self.histogram.iter().enumerate() {
            let count = count as f64;
            if count > 0.0 && below + count >= target {
                let t = (bin as f64 + (target - below) / count) / Self::BINS as f64;
                // Not min + t * (max - min): the difference of extreme values overflows.
                return (self.min * (1.0 - t) + self.max * t).clamp(self.min, self.max);
            }
            below += count;
        }
        self.max
    }
}

/// Statistics of 8 and 16 bit voxels, whose smallest possible value is `lowest`.
fn of_narrow<T>(voxels: &[T], lowest: i32, values: usize, rescale: Rescale) -> Statistics
where
    T: Copy + Into<i32> + Sync,
{
    let counts = voxels
        .par_chunks(CHUNK)
        .fold(
            || vec![0u64; values],
            |mut counts, chunk| {
                for &v in chunk {
                    counts[(v.into() - lowest) as usize] += 1;
                }
                counts
            },
        )
        .reduce(|| vec![0; values], add_counts);
    let present = || {
        (lowest..)
            .zip(&counts)
            .filter(|&(_, &count)| count > 0)
            .map(|(stored, &count)| (rescale.apply(f64::from(stored)), count))
    };
    let mut extent = Extent::EMPTY;
    present().for_each(|(value, count)| extent.add(value, count));
    let axis = Axis::new(&extent);
    let mut shape = Shape::new();
    present().for_each(|(value, count)| shape.add(&axis, value, count));
    finish(&extent, &axis, shape.sum, shape.histogram)
}

/// Statistics of 32 and 64 bit voxels.
fn of_wide<T>(voxels: &[T], rescale: Rescale) -> Statistics
where
    T: Copy + Into<f64> + Sync,
{
    let extent = voxels
        .par_chunks(CHUNK)
        .map(|chunk| {
            let mut extent = Extent::EMPTY;
            for &v in chunk {
                extent.add(rescale.apply(v.into()), 1);
            }
            extent
        })
        .reduce(|| Extent::EMPTY, Extent::union);
    let axis = Axis::new(&extent);
    let shapes: Vec<Shape> = voxels
        .par_chunks(CHUNK)
        .map(|chunk| {
            let mut shape = Shape::new();
            for &v in chunk {
                shape.add(&axis, rescale.apply(v.into()), 1);
            }
            shape
        })
        .collect();
    // One after the other, in storage order: a parallel reduction would group the sums by thread.
    let total = shapes.into_iter().fold(Shape::new(), Shape::union);
    finish(&extent, &axis, total.sum, total.histogram)
}

/// Range and counts of a set of data values.
#[derive(Clone, Copy)]
struct Extent {
    /// Infinity if nothing is finite.
    min: f64,
    /// Negative infinity if nothing is finite.
    max: f64,
    finite: u64,
    nan: u64,
    infinite: u64,
}

impl Extent {
    const EMPTY: Self = Self {
        min: f64::INFINITY,
        max: f64::NEG_INFINITY,
        finite: 0,
        nan: 0,
        infinite: 0,
    };

    fn add(&mut self, value: f64, count: u64) {
        if value.is_finite() {
            self.min = self.min.min(value);
            self.max = self.max.max(value);
            self.finite += count;
        } else if value.is_nan() {
            self.nan += count;
        } else {
            self.infinite += count;
        }
    }

    fn union(self, other: Self) -> Self {
        Self {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
            finite: self.finite + other.finite,
            nan: self.nan + other.nan,
            infinite: self.infinite + other.infinite,
        }
    }
}

/// Data value to position in the range, [0, 1].
struct Axis {
    /// 1, or 1/2 where `max - min` would overflow.
    scale: f64,
    /// Scaled smallest value.
    low: f64,
    /// Scaled `max - min`; 1 for a constant volume, so that its voxels are all at 0.
    width: f64,
}

impl Axis {
    fn new(extent: &Extent) -> Self {
        if extent.finite == 0 || extent.min == extent.max {
            return Self {
                scale: 1.0,
                low: if extent.finite == 0 { 0.0 } else { extent.min },
                width: 1.0,
            };
        }
        let fits = (extent.max - extent.min).is_finite();
        let scale = if fits { 1.0 } else { 0.5 };
        let low = extent.min * scale;
        Self {
            scale,
            low,
            width: extent.max * scale - low,
        }
    }

    /// A division, not a product with the inverse, which is infinite for denormal widths.
    fn position(&self, value: f64) -> f64 {
        (value * self.scale - self.low) / self.width
    }

    fn value(&self, position: f64) -> f64 {
        (self.low + position * self.width) / self.scale
    }
}

/// Sum of positions and histogram.
struct Shape {
    sum: f64,
    histogram: Vec<u64>,
}

impl Shape {
    fn new() -> Self {
        Self {
            sum: 0.0,
            histogram: vec![0; Statistics::BINS],
        }
    }

    fn add(&mut self, axis: &Axis, value: f64, count: u64) {
        if !value.is_finite() {
            return;
        }
        let position = axis.position(value);
        let bin = (position * Statistics::BINS as f64) as usize;
        self.histogram[bin.min(Statistics::BINS - 1)] += count;
        self.sum += position * count as f64;
    }

    fn union(self, other: Self) -> Self {
        Self {
            sum: self.sum + other.sum,
            histogram: add_counts(self.histogram, other.histogram),
        }
    }
}

fn add_counts(mut a: Vec<u64>, b: Vec<u64>) -> Vec<u64> {
    a.iter_mut().zip(b).for_each(|(a, b)| *a += b);
    a
}

fn finish(extent: &Extent, axis: &Axis, sum: f64, histogram: Vec<u64>) -> Statistics {
    let (min, max, mean) = if extent.finite == 0 {
        (0.0, 0.0, 0.0)
    } else {
        let mean = axis.value(sum / extent.finite as f64);
        // Rounding of the sum must not carry the mean out of the range.
        (extent.min, extent.max, mean.clamp(extent.min, extent.max))
    };
    Statistics {
        min,
        max,
        mean,
        nan: extent.nan,
        infinite: extent.infinite,
        histogram,
    }
}

#[cfg(test)]
mod tests {
    use glam::{DVec3, UVec3};

    use super::*;
    use crate::volume::{Grid, ScalarType};

    fn statistics(voxels: Voxels, rescale: Rescale) -> Statistics {
        let dims = UVec3::new(voxels.len() as u32, 1, 1);
        Statistics::of(&Volume {
            name: "test".into(),
            grid: Grid::centred(dims, DVec3::ONE),
            voxels,
            rescale,
            spatial_unit: None,
            height_field: None,
        })
    }

    fn f64s(values: &[f64]) -> Statistics {
        statistics(Voxels::F64(values.to_vec()), Rescale::IDENTITY)
    }

    /// The stored values 0, 1, 1, 100 as any type.
    fn small_values(scalar_type: ScalarType) -> Voxels {
        match scalar_type {
            ScalarType::U8 => Voxels::U8(vec![0, 1, 1, 100]),
            ScalarType::I8 => Voxels::I8(vec![0, 1, 1, 100]),
            ScalarType::U16 => Voxels::U16(vec![0, 1, 1, 100]),
            ScalarType::I16 => Voxels::I16(vec![0, 1, 1, 100]),
            ScalarType::U32 => Voxels::U32(vec![0, 1, 1, 100]),
            ScalarType::I32 => Voxels::I32(vec![0, 1, 1, 100]),
            ScalarType::F32 => Voxels::F32(vec![0.0, 1.0, 1.0, 100.0]),
            ScalarType::F64 => Voxels::F64(vec![0.0, 1.0, 1.0, 100.0]),
        }
    }

    #[test]
    fn every_scalar_type_counts_alike() {
        for scalar_type in ScalarType::ALL {
            let s = statistics(small_values(scalar_type), Rescale::IDENTITY);
            assert_eq!((s.min, s.max), (0.0, 100.0), "{scalar_type}");
            assert!((s.mean - 25.5).abs() < 1e-12, "{scalar_type}: {}", s.mean);
            assert_eq!(s.histogram.len(), Statistics::BINS);
            assert_eq!(s.histogram[0], 1, "{scalar_type}");
            assert_eq!(s.histogram[10], 2, "{scalar_type}: 1/100 of 1024 bins");
            assert_eq!(s.histogram[Statistics::BINS - 1], 1, "{scalar_type}");
            assert_eq!((s.finite(), s.non_finite()), (4, 0), "{scalar_type}");
        }
    }

    #[test]
    fn a_negative_slope_swaps_the_ends() {
        let rescale = Rescale {
            slope: -2.0,
            intercept: 5.0,
        };
        for scalar_type in ScalarType::ALL {
            let s = statistics(small_values(scalar_type), rescale);
            assert_eq!((s.min, s.max), (-195.0, 5.0), "{scalar_type}");
            assert!((s.mean + 46.0).abs() < 1e-12, "{scalar_type}: {}", s.mean);
            assert_eq!(s.histogram[0], 1, "{scalar_type}");
            assert_eq!(s.histogram[Statistics::BINS - 1], 1, "{scalar_type}");
        }
    }

    #[test]
    fn the_whole_range_of_every_integer_type_fits() {
        let ends = [
            (Voxels::U8(vec![0, u8::MAX]), 0.0, 255.0),
            (Voxels::I8(vec![i8::MIN, i8::MAX]), -128.0, 127.0),
            (Voxels::U16(vec![0, u16::MAX]), 0.0, 65535.0),
            (Voxels::I16(vec![i16::MIN, i16::MAX]), -32768.0, 32767.0),
            (Voxels::U32(vec![0, u32::MAX]), 0.0, f64::from(u32::MAX)),
            (
                Voxels::I32(vec![i32::MIN, i32::MAX]),
                f64::from(i32::MIN),
                f64::from(i32::MAX),
            ),
        ];
        for (voxels, min, max) in ends {
            let s = statistics(voxels, Rescale::IDENTITY);
            assert_eq!((s.min, s.max), (min, max));
            assert_eq!((s.histogram[0], s.histogram[1023]), (1, 1));
            assert_eq!(s.mean, (min + max) / 2.0);
        }
    }

    #[test]
    fn nothing_finite_is_all_zero() {
        let s = f64s(&[f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::NAN]);
        assert_eq!((s.min, s.max, s.mean), (0.0, 0.0, 0.0));
        assert_eq!((s.nan, s.infinite, s.finite()), (2, 2, 0));
        assert_eq!(s.quantile(0.5), 0.0);
        let s = statistics(Voxels::F32(vec![f32::NAN; 3]), Rescale::IDENTITY);
        assert_eq!((s.nan, s.non_finite(), s.finite()), (3, 3, 0));
    }

    #[test]
    fn non_finite_voxels_do_not_touch_the_rest() {
        let s = f64s(&[f64::NAN, 1.0, f64::INFINITY, 3.0]);
        assert_eq!((s.min, s.max, s.mean), (1.0, 3.0, 2.0));
        assert_eq!((s.nan, s.infinite, s.finite()), (1, 1, 2));
    }

    #[test]
    fn a_constant_volume_is_in_the_first_bin() {
        for value in [0.0, -7.5, f64::MAX, f64::MIN_POSITIVE] {
            let s = f64s(&[value; 5]);
            assert_eq!((s.min, s.max, s.mean), (value, value, value));
            assert_eq!(s.histogram[0], 5);
            assert_eq!((s.quantile(0.3), s.quantile(1.0)), (value, value));
        }
    }

    #[test]
    fn extremes_neither_overflow_nor_vanish() {
        let s = f64s(&[f64::MIN, 0.0, f64::MAX]);
        assert_eq!((s.min, s.max, s.mean), (f64::MIN, f64::MAX, 0.0));
        assert_eq!(
            (s.histogram[0], s.histogram[512], s.histogram[1023]),
            (1, 1, 1)
        );
        assert!(s.quantile(0.4).is_finite());
        let tiny = f64::from_bits(1);
        let s = f64s(&[0.0, tiny, 2.0 * tiny, 2.0 * tiny]);
        assert_eq!((s.histogram[0], s.histogram[1023]), (1, 2));
        let s = statistics(Voxels::F32(vec![f32::MIN, f32::MAX]), Rescale::IDENTITY);
        assert_eq!((s.mean, s.histogram[0], s.histogram[1023]), (0.0, 1, 1));
    }

    #[test]
    fn a_rescale_that_overflows_counts_as_infinite() {
        let rescale = Rescale {
            slope: 1e308,
            intercept: 0.0,
        };
        let s = statistics(Voxels::U16(vec![0, 1, 65535]), rescale);
        assert_eq!((s.min, s.max, s.infinite), (0.0, 1e308, 1));
    }

    #[test]
    fn quantiles_of_an_even_spread() {
        let s = statistics(Voxels::U16((0..=u16::MAX).collect()), Rescale::IDENTITY);
        for q in [0.0, 0.001, 0.25, 0.5, 0.99, 1.0] {
            assert!((s.quantile(q) - q * 65535.0).abs() <= 64.0, "{q}");
        }
        assert_eq!((s.quantile(-3.0), s.quantile(9.0)), (0.0, 65535.0));
        assert_eq!(s.quantile(f64::NAN), 0.0);
    }

    #[test]
    fn quantiles_skip_empty_bins() {
        let s = f64s(&[0.0, 0.0, 0.0, 1024.0]);
        assert!(s.quantile(0.75) <= 1.0);
        assert!(s.quantile(0.76) >= 1023.0);
    }

    #[test]
    fn the_same_bits_for_any_number_of_threads() {
        let voxels: Vec<f32> = (0..2 * CHUNK + 17)
            .map(|i| (i as f32 * 0.37).sin() * 1e3)
            .collect();
        let voxels = Voxels::F32(voxels);
        let of = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            pool.map(|pool| pool.install(|| statistics(voxels.clone(), Rescale::IDENTITY)))
                .ok()
        };
        let one = of(1);
        assert!(one.is_some());
        assert_eq!(one, of(3));
    }
}
