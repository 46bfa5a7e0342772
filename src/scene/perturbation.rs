//! Noise that gives a coarse volume detail `[Kniss2003, III.D]`: it moves the places at which the volume is looked
//! up, and varies the material found there.
//!
//! One small tile of noise repeats through space; octaves are copies of it at other scales. The noise is at rest in
//! the world: a place has the same, whatever the volume's resolution or the step of a march.

use glam::{DVec3, Vec3};

/// Texels along each edge of the tile of noise.
pub const NOISE_SIZE: usize = 32;

/// Most octaves.
pub const MOST_OCTAVES: usize = 8;

/// What noise does to a medium.
#[derive(Clone, Debug, PartialEq)]
pub struct Perturbation {
    /// Chooses the noise.
    pub seed: u32,
    /// Copies of the noise at different scales, which add up; 1 to 8.
    pub octaves: Vec<Octave>,
    /// The moment that is shown.
    pub time: f64,
}

/// The noise at one scale. Its four components are in [0, 1] and 1/2 on average.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Octave {
    /// Texels of the noise a world unit, > 0: features are about as wide as two texels, and 32 repeat.
    pub frequency: f64,
    /// Furthest that it moves a place along each axis of the world, world units, >= 0.
    pub displacement: f64,
    /// Largest change of extinction, up or down, as a share of it; in [0, 1], of all octaves together too.
    pub opacity: f64,
    /// Largest share by which it darkens the transfer function's colour, per channel; in [0, 1], of all octaves
    /// together too.
    pub color: Vec3,
    /// Where the noise lies, world units.
    pub offset: DVec3,
    /// How it moves, world units a unit of time.
    pub velocity: DVec3,
}

/// What noise does at a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Perturbed {
    /// From the place to where the volume is looked up, world units.
    pub displacement: DVec3,
    /// Factor on the extinction, >= 0.
    pub extinction: f64,
    /// Factor on the transfer function's colour, in [0, 1].
    pub color: DVec3,
}

impl Octave {
    /// Whether it changes the material found.
    #[must_use]
    pub fn varies(&self) -> bool {
        self.opacity > 0.0 || self.color.max_element() > 0.0
    }

    /// Coordinates of the noise, of which the tile's edge is 1, at a world position; in [0, 1).
    #[must_use]
    pub fn tile_at(&self, x: DVec3, time: f64) -> DVec3 {
        let at = (x - self.offset - time * self.velocity) * self.tiles();
        at - at.floor()
    }

    /// Tiles of noise a world unit.
    #[must_use]
    pub fn tiles(&self) -> f64 {
        self.frequency / NOISE_SIZE as f64
    }
}

impl Perturbation {
    /// Furthest that a place is moved along any axis of the world, world units.
    #[must_use]
    pub fn largest_displacement(&self) -> f64 {
        self.octaves.iter().map(|o| o.displacement).sum()
    }

    /// Largest change of extinction as a share of it, in [0, 1].
    #[must_use]
    pub fn largest_variation(&self) -> f64 {
        let sum: f64 = self.octaves.iter().map(|o| o.opacity).sum();
        sum.min(1.0)
    }

    /// Factor on the transfer function's colour, on average.
    #[must_use]
    pub fn mean_color(&self) -> DVec3 {
        let darkest: DVec3 = self.octaves.iter().map(|o| o.color.as_dvec3()).sum();
        1.0 - 0.5 * darkest
    }

    /// Whether it changes with time.
    #[must_use]
    pub fn moves(&self) -> bool {
        self.octaves.iter().any(|o| o.velocity != DVec3::ZERO)
    }

    /// What the noise does at a world position.
    #[must_use]
    pub fn at(&self, noise: &Noise, x: DVec3) -> Perturbed {
        let (mut displacement, mut extinction) = (DVec3::ZERO, 1.0);
        let mut color = DVec3::ONE;
        for octave in &self.octaves {
            let [r, g, b, a] = noise.sample(octave.tile_at(x, self.time));
            let rgb = DVec3::new(r, g, b);
            displacement += octave.displacement * (2.0 * rgb - 1.0);
            extinction += octave.opacity * (2.0 * a - 1.0);
            color -= octave.color.as_dvec3() * rgb;
        }
        Perturbed {
            displacement,
            extinction: extinction.max(0.0),
            color: color.max(DVec3::ZERO),
        }
    }
}

/// The tile of noise.
#[derive(Clone, Debug)]
pub struct Noise {
    texels: Vec<[f32; 4]>,
}

impl Noise {
    /// Random bytes, slightly blurred so that trilinear filtering does not show them, and stretched to the whole of
    /// [0, 1] about 1/2; repeating along every axis.
    #[must_use]
    pub fn new(seed: u32) -> Self {
        let count = NOISE_SIZE * NOISE_SIZE * NOISE_SIZE;
        let mut state = u64::from(seed) << 32;
        let mut texels: Vec<_> = (0..count)
            .map(|_| {
                let bytes = splitmix64(&mut state).to_le_bytes();
                [bytes[0], bytes[1], bytes[2], bytes[3]].map(|b| f64::from(b) / 255.0)
            })
            .collect();
        for stride in [1, NOISE_SIZE, NOISE_SIZE * NOISE_SIZE] {
            texels = blurred(&texels, stride);
        }
        stretch(&mut texels);
        Self {
            texels: texels.iter().map(|t| t.map(|c| c as f32)).collect(),
        }
    }

    /// Texels, x fastest.
    #[must_use]
    pub fn texels(&self) -> &[[f32; 4]] {
        &self.texels
    }

    /// Trilinear, as the device's repeating filter; the tile's edge is 1.
    #[must_use]
    pub fn sample(&self, place: DVec3) -> [f64; 4] {
        let at = place * NOISE_SIZE as f64 - 0.5;
        let (low, f) = (at.floor(), at - at.floor());
        let last = NOISE_SIZE as i64 - 1;
        let mut sum = [0.0; 4];
        for corner in 0..8_i64 {
            let high = [corner & 1, (corner >> 1) & 1, corner >> 2];
            let (mut weight, mut index) = (1.0, 0);
            for axis in [2, 1, 0] {
                weight *= if high[axis] == 1 {
                    f[axis]
                } else {
                    1.0 - f[axis]
                };
                let wrapped = (low[axis] as i64 + high[axis]) & last;
                index = index * NOISE_SIZE + wrapped as usize;
            }
            for (total, texel) in sum.iter_mut().zip(self.texels[index]) {
                *total += weight * f64::from(texel);
            }
        }
        sum
    }
}

/// A quarter, a half, a quarter along one axis, repeating.
fn blurred(texels: &[[f64; 4]], stride: usize) -> Vec<[f64; 4]> {
    let along = |i: usize, step: usize| {
        let place = i / stride % NOISE_SIZE;
        i - place * stride + (place + step) % NOISE_SIZE * stride
    };
    let texel = |i: usize| {
        let (behind, here, ahead) = (
            texels[along(i, NOISE_SIZE - 1)],
            texels[i],
            texels[along(i, 1)],
        );
        std::array::from_fn(|c| 0.25 * behind[c] + 0.5 * here[c] + 0.25 * ahead[c])
    };
    (0..texels.len()).map(texel).collect()
}

/// Each component to a mean of 1/2, and its furthest texel from there to 0 or 1.
fn stretch(texels: &mut [[f64; 4]]) {
    for c in 0..4 {
        let mean = texels.iter().map(|t| t[c]).sum::<f64>() / texels.len() as f64;
        let furthest = texels
            .iter()
            .map(|t| (t[c] - mean).abs())
            .fold(1e-9, f64::max);
        for texel in texels.iter_mut() {
            texel[c] = 0.5 + 0.5 * (texel[c] - mean) / furthest;
        }
    }
}

/// The splitmix64 generator `[Steele2014]`.
fn splitmix64(state: &mut u64) -> u64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_fills_its_range_about_a_half_and_repeats() {
        let noise = Noise::new(7);
        for c in 0..4 {
            let values = noise.texels().iter().map(|t| f64::from(t[c]));
            let (low, high) = values
                .clone()
                .fold((1.0, 0.0), |(a, b): (f64, f64), v| (a.min(v), b.max(v)));
            assert!(low >= 0.0 && high <= 1.0 && low.min(1.0 - high) < 1e-6);
            let mean = values.sum::<f64>() / noise.texels().len() as f64;
            assert!((mean - 0.5).abs() < 1e-6);
        }
        let place = DVec3::new(0.123, 0.999, 0.001);
        let (a, b) = (
            noise.sample(place),
            noise.sample(place + DVec3::new(2.0, -1.0, 1.0)),
        );
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12));
        // At a texel's centre the texel itself.
        let centre = DVec3::new(3.5, 0.5, 31.5) / NOISE_SIZE as f64;
        let texel = noise.texels()[3 + NOISE_SIZE * NOISE_SIZE * 31];
        assert!((noise.sample(centre)[1] - f64::from(texel[1])).abs() < 1e-6);
        assert_eq!(Noise::new(7).texels(), noise.texels());
        assert_ne!(Noise::new(8).texels(), noise.texels());
    }

    #[test]
    fn a_moving_octave_is_the_still_one_elsewhere() {
        let noise = Noise::new(0);
        let octave = Octave {
            frequency: 3.0,
            displacement: 0.5,
            opacity: 0.25,
            color: Vec3::new(0.5, 0.25, 0.0),
            offset: DVec3::new(1.0, -2.0, 1e6),
            velocity: DVec3::new(0.5, 0.0, -1.0),
        };
        let still = Perturbation {
            seed: 0,
            octaves: vec![octave],
            time: 0.0,
        };
        let later = Perturbation {
            time: 4.0,
            ..still.clone()
        };
        let x = DVec3::new(0.3, 0.1, -0.2);
        let (a, b) = (
            still.at(&noise, x),
            later.at(&noise, x + 4.0 * octave.velocity),
        );
        assert!((a.displacement - b.displacement).length() < 1e-6);
        assert!(a.displacement.abs().max_element() <= still.largest_displacement());
        assert!((a.extinction - 1.0).abs() <= still.largest_variation());
        assert!(a.color.z == 1.0 && a.color.x >= 0.5 && a.color.x <= 1.0);
    }
}
