//! The function as a table of equidistant entries, as the GPU samples it.

use super::TransferFunction;

/// Table sizes that [`TransferFunction::entries_needed`] chooses from.
const ENTRIES: std::ops::RangeInclusive<usize> = 1024..=16384;

/// Entries across the narrowest segment: extinction is not linear in opacity, and with eight the
/// table follows it to a few parts in a thousand.
const ENTRIES_PER_SEGMENT: f64 = 8.0;

impl TransferFunction {
    /// Table of `(r, g, b, sigma_t)` over `[min, max]`: linear colour and extinction per world unit,
    /// entry `i` at the value `min + (max - min) * i / (entries - 1)`.
    ///
    /// `sigma_t = -ln(1 - min(opacity, OPACITY_MAX)) / opacity_unit_distance * density_scale`, or the
    /// extinction given times `density_scale`.
    /// Where `min == max`, or `entries` is 1, every entry is the value at `min`. An empty function
    /// bakes to zeros.
    ///
    /// Entries are exact, with one exception: a peak of opacity so narrow that it falls between two
    /// entries and loses more than half its height there is moved to the nearer one, so that no
    /// structure vanishes. A table of [`Self::entries_needed`] entries has no such peak unless that
    /// number is at its limit.
    #[must_use]
    pub fn bake(&self, min: f64, max: f64, entries: usize, density_scale: f64) -> Vec<[f32; 4]> {
        let last = entries.saturating_sub(1);
        let mut samples: Vec<_> = (0..entries)
            .map(|i| {
                // The upper end exactly: a rounding error below a jump would miss it.
                let value = match i {
                    0 => min,
                    _ if i == last => max,
                    _ => min + (max - min) * (i as f64 / last as f64),
                };
                self.evaluate(value)
            })
            .collect();
        if last > 0 && max > min {
            self.keep_narrow_peaks(min, max, &mut samples);
        }
        samples
            .into_iter()
            .map(|(color, opacity)| {
                let sigma_t = self.sigma_t_of(opacity) * density_scale;
                [color.x, color.y, color.z, sigma_t as f32]
            })
            .collect()
    }

    /// How many entries a table over `[min, max]` needs so that every segment of the function within
    /// it is at least eight entries wide: a power of two from 1024 to 16384. Where gradients decide too, that
    /// of a table over both: from 512 to 2048.
    #[must_use]
    pub fn entries_needed(&self, min: f64, max: f64) -> usize {
        if self.has_gradients() {
            return self.values_needed(min, max);
        }
        let extent = max - min;
        let narrowest = self
            .points
            .windows(2)
            .map(|pair| (pair[0].value, pair[1].value))
            // A segment outside the table needs none, a jump cannot be resolved by any number.
            .filter(|&(a, b)| b > a && b > min && a < max)
            .map(|(a, b)| b - a)
            .fold(f64::INFINITY, f64::min);
        if !(extent > 0.0 && narrowest > 0.0) {
            return *ENTRIES.start();
        }
        // `as` saturates: a ratio beyond usize ends at the limit.
        let wanted = (ENTRIES_PER_SEGMENT * extent / narrowest).ceil() as usize;
        wanted
            .clamp(*ENTRIES.start(), *ENTRIES.end())
            .next_power_of_two()
    }

    /// Raises the entry nearest to a control point that both neighbouring entries would lose.
    fn keep_narrow_peaks(&self, min: f64, max: f64, samples: &mut [(glam::Vec3, f64)]) {
        let last = samples.len() - 1;
        for p in &self.points {
            if p.value < min || p.value > max {
                continue;
            }
            let position = (p.value - min) / (max - min) * last as f64;
            let below = (position.floor() as usize).min(last);
            let above = (position.ceil() as usize).min(last);
            let kept = samples[below].1.max(samples[above].1);
            if kept < 0.5 * p.opacity {
                samples[(position.round() as usize).min(last)] = (p.color, p.opacity);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{ControlPoint, Quantity};
    use super::*;
    use glam::Vec3;

    fn function(nodes: &[(f64, f64)]) -> TransferFunction {
        TransferFunction {
            name: String::new(),
            points: nodes
                .iter()
                .map(|&(value, opacity)| ControlPoint {
                    value,
                    color: Vec3::new(1.0, 0.5, 0.25),
                    opacity,
                })
                .collect(),
            quantity: Quantity::Opacity,
            primitives: Vec::new(),
            opacity_unit_distance: 1.0,
        }
    }

    #[test]
    fn entries_needed_follows_the_narrowest_segment() {
        assert_eq!(function(&[]).entries_needed(0.0, 1.0), 1024);
        assert_eq!(
            function(&[(0.0, 0.0), (1.0, 1.0)]).entries_needed(0.0, 1.0),
            1024
        );
        let spike = function(&[(0.499, 0.0), (0.5, 1.0), (0.501, 0.0)]);
        assert_eq!(spike.entries_needed(0.0, 1.0), 8192);
        assert_eq!(spike.entries_needed(0.6, 1.0), 1024);
        assert_eq!(spike.entries_needed(0.0, 1e9), 16384);
        assert_eq!(spike.entries_needed(0.5, 0.5), 1024);
        let jump = function(&[(0.5, 0.0), (0.5, 1.0)]);
        assert_eq!(jump.entries_needed(0.0, 1.0), 1024);
    }

    #[test]
    fn a_peak_between_two_entries_survives_in_the_nearer_one() {
        let spike = function(&[(0.4000, 0.0), (0.4001, 0.9), (0.4002, 0.0)]);
        let table = spike.bake(0.0, 1.0, 11, 2.0);
        assert!((table[4][3] - (-(0.1f64.ln()) * 2.0) as f32).abs() < 1e-5);
        assert_eq!(table.iter().filter(|e| e[3] > 0.0).count(), 1);
    }

    #[test]
    fn a_resolved_peak_stays_exact() {
        let tent = function(&[(0.0, 0.0), (0.55, 0.8), (1.0, 0.0)]);
        for (i, entry) in tent.bake(0.0, 1.0, 11, 1.0).iter().enumerate() {
            assert_eq!(entry[3], tent.sigma_t(i as f64 / 10.0) as f32);
        }
    }
}
