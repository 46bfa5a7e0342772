//! Planes of numbers and separable filters over them, shared by SSIM and FLIP.

use std::ops::{AddAssign, Mul};

use rayon::prelude::*;

/// `f32` or `f64`.
pub(super) trait Number:
    Copy + Default + Send + Sync + Mul<Output = Self> + AddAssign
{
}

impl Number for f32 {}
impl Number for f64 {}

/// One number for each pixel, row by row from the top left; at least one pixel.
#[derive(Clone, Debug)]
pub(super) struct Plane<T> {
    /// Pixels across, above 0.
    pub(super) width: usize,
    /// `width` times the number of rows.
    pub(super) values: Vec<T>,
}

impl<T: Number> Plane<T> {
    /// The plane of a number computed from each of `pixels`.
    pub(super) fn new<P: Sync>(
        width: usize,
        pixels: &[P],
        value: impl Fn(&P) -> T + Sync + Send,
    ) -> Self {
        Self {
            width,
            values: pixels.par_iter().map(value).collect(),
        }
    }

    /// Weighted sums about each pixel; `across` and `down` have odd lengths, their middles lie on
    /// the pixel. Beyond the border the nearest pixel is repeated.
    pub(super) fn filtered(&self, across: &[T], down: &[T]) -> Self {
        self.filtered_across(across).filtered_down(down)
    }

    /// [`Plane::filtered`] along rows only.
    pub(super) fn filtered_across(&self, weights: &[T]) -> Self {
        let radius = weights.len() / 2;
        let mut values = vec![T::default(); self.values.len()];
        let rows = values.par_chunks_mut(self.width);
        rows.zip(self.values.par_chunks(self.width))
            .for_each(|(sums, row)| {
                let padded = pad(row, radius);
                for (i, &weight) in weights.iter().enumerate() {
                    add_scaled(sums, &padded[i..], weight);
                }
            });
        Self {
            width: self.width,
            values,
        }
    }

    /// [`Plane::filtered`] along columns only.
    pub(super) fn filtered_down(&self, weights: &[T]) -> Self {
        let radius = weights.len() / 2;
        let last = self.values.len() / self.width - 1;
        let mut values = vec![T::default(); self.values.len()];
        let rows = values.par_chunks_mut(self.width).enumerate();
        rows.for_each(|(y, sums)| {
            for (i, &weight) in weights.iter().enumerate() {
                let source = (y + i).saturating_sub(radius).min(last);
                add_scaled(sums, &self.values[source * self.width..], weight);
            }
        });
        Self {
            width: self.width,
            values,
        }
    }
}

/// The row with its ends repeated `radius` times.
fn pad<T: Copy>(row: &[T], radius: usize) -> Vec<T> {
    let (first, last) = (row[0], row[row.len() - 1]);
    let mut padded = Vec::with_capacity(row.len() + 2 * radius);
    padded.resize(radius, first);
    padded.extend_from_slice(row);
    padded.resize(row.len() + 2 * radius, last);
    padded
}

fn add_scaled<T: Number>(sums: &mut [T], values: &[T], weight: T) {
    for (sum, &value) in sums.iter_mut().zip(values) {
        *sum += weight * value;
    }
}

/// `value` at -`radius`..=`radius`.
pub(super) fn sampled(radius: usize, value: impl Fn(f64) -> f64) -> Vec<f64> {
    (0..=2 * radius)
        .map(|i| value(i as f64 - radius as f64))
        .collect()
}

/// Samples of a Gaussian of standard deviation `sigma` (pixels), scaled to the sum 1.
pub(super) fn gaussian(radius: usize, sigma: f64) -> Vec<f64> {
    let weights = sampled(radius, |x| (-x * x / (2.0 * sigma * sigma)).exp());
    let sum: f64 = weights.iter().sum();
    weights.iter().map(|w| w / sum).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plane(width: usize, values: &[f64]) -> Plane<f64> {
        Plane::new(width, values, |&v| v)
    }

    #[test]
    fn borders_repeat_and_order_is_kept() {
        let p = plane(3, &[1.0, 2.0, 4.0, 10.0, 20.0, 40.0]);
        let left = p.filtered_across(&[1.0, 0.0, 0.0]);
        assert_eq!(left.values, [1.0, 1.0, 2.0, 10.0, 10.0, 20.0]);
        let below = p.filtered_down(&[0.0, 0.0, 1.0]);
        assert_eq!(below.values, [10.0, 20.0, 40.0, 10.0, 20.0, 40.0]);
    }

    #[test]
    fn a_kernel_larger_than_the_plane_sees_only_the_plane() {
        let p = plane(1, &[3.0]);
        let weights = gaussian(10, 4.0);
        let found = p.filtered(&weights, &weights).values[0];
        assert!((found - 3.0).abs() < 1e-12, "{found}");
    }
}
