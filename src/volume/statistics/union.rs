//! Statistics of several volumes, as of the steps of one that changes with time.

use super::{Axis, Extent, Shape, Statistics, finish};

impl Statistics {
    /// The statistics of two volumes taken as one. What lies in a bin of a narrower range is counted
    /// where the bin's middle lies in the common range.
    #[must_use]
    pub fn union(&self, other: &Self) -> Self {
        let sides = [self, other].map(|s| (s, s.finite()));
        let mut extent = Extent {
            nan: self.nan + other.nan,
            infinite: self.infinite + other.infinite,
            ..Extent::EMPTY
        };
        for (s, count) in sides.iter().filter(|side| side.1 > 0) {
            extent.add(s.min, *count);
            extent.add(s.max, 0);
        }
        let axis = Axis::new(&extent);
        let mut shape = Shape::new();
        let mut sum = 0.0;
        for (s, count) in sides.iter().filter(|side| side.1 > 0) {
            sum += axis.position(s.mean) * *count as f64;
            for (bin, n) in (0..Self::BINS).zip(&s.histogram) {
                shape.add(&axis, s.middle(bin), *n);
            }
        }
        finish(&extent, &axis, sum, shape.histogram)
    }

    /// The data value in the middle of a bin; a constant volume has one value.
    fn middle(&self, bin: usize) -> f64 {
        let t = (bin as f64 + 0.5) / Self::BINS as f64;
        if self.min == self.max {
            return self.min;
        }
        (self.min * (1.0 - t) + self.max * t).clamp(self.min, self.max)
    }
}

#[cfg(test)]
mod tests {
    use glam::{DVec3, UVec3};

    use super::*;
    use crate::volume::{Grid, Rescale, Volume, Voxels};

    fn of(values: &[f64]) -> Statistics {
        let dims = UVec3::new(values.len() as u32, 1, 1);
        Statistics::of(&Volume {
            name: "test".into(),
            grid: Grid::centred(dims, DVec3::ONE),
            voxels: Voxels::F64(values.to_vec()),
            rescale: Rescale::IDENTITY,
            spatial_unit: None,
            height_field: None,
        })
    }

    #[test]
    fn the_union_counts_both() {
        let (a, b) = (of(&[0.0, 1.0, f64::NAN]), of(&[-10.0, 4.0, 5.0, 10.0]));
        let both = a.union(&b);
        assert_eq!((both.min, both.max, both.nan), (-10.0, 10.0, 1));
        assert_eq!(both.finite(), 6);
        assert!((both.mean - 10.0 / 6.0).abs() < 1e-12, "{}", both.mean);
        assert_eq!(both, b.union(&a));
        // Of nothing, and of constants.
        assert_eq!(both.union(&of(&[])).histogram, both.histogram);
        let constant = of(&[3.0; 4]).union(&of(&[3.0; 2]));
        assert_eq!(constant, of(&[3.0; 6]));
        let s = of(&[3.0; 4]).union(&of(&[4.0; 2]));
        assert_eq!((s.histogram[0], s.histogram[1023]), (4, 2));
        let nothing = of(&[]).union(&of(&[f64::INFINITY]));
        assert_eq!(
            (nothing.min, nothing.finite(), nothing.infinite),
            (0.0, 0, 1)
        );
    }

    #[test]
    fn the_union_with_itself_keeps_the_shape() {
        let even: Vec<f64> = (0..4096).map(f64::from).collect();
        let s = of(&even);
        let twice: Vec<u64> = s.histogram.iter().map(|n| 2 * n).collect();
        assert_eq!(s.union(&s).histogram, twice);
    }
}
