//! Deterministic gradient noise: the same bits on every machine, no tables to seed.
//!
//! Perlin's improved noise `[Perlin2002]` on a lattice whose gradients come from an integer hash.
//! Only additions, products and comparisons of f64 are used, all of them exactly specified.

use glam::DVec3;

/// The directions to the middles of a cube's edges; four are repeated to make the count a power
/// of two.
const GRADIENTS: [[f64; 3]; 16] = [
    [1.0, 1.0, 0.0],
    [-1.0, 1.0, 0.0],
    [1.0, -1.0, 0.0],
    [-1.0, -1.0, 0.0],
    [1.0, 0.0, 1.0],
    [-1.0, 0.0, 1.0],
    [1.0, 0.0, -1.0],
    [-1.0, 0.0, -1.0],
    [0.0, 1.0, 1.0],
    [0.0, -1.0, 1.0],
    [0.0, 1.0, -1.0],
    [0.0, -1.0, -1.0],
    [1.0, 1.0, 0.0],
    [-1.0, 1.0, 0.0],
    [0.0, -1.0, 1.0],
    [0.0, -1.0, -1.0],
];

/// Not 2, so that the octaves' lattices do not coincide and show their cells.
const LACUNARITY: f64 = 2.03;

/// Shift between octaves, for the same reason.
const OCTAVE_SHIFT: DVec3 = DVec3::new(17.31, -5.77, 9.13);

/// Gradient noise, roughly in [-1, 1], 0 at lattice points, features about one unit wide.
pub(super) fn gradient_noise(p: DVec3, seed: u32) -> f64 {
    let (ix, fx) = split(p.x);
    let (iy, fy) = split(p.y);
    let (iz, fz) = split(p.z);
    let x = hash_axis(ix, 0x9e37_79b1);
    let y = hash_axis(iy, 0x85eb_ca77);
    let z = hash_axis(iz, 0xc2b2_ae3d);
    let corner = |cx: usize, cy: usize, cz: usize| {
        let g = GRADIENTS[(mix(x[cx] ^ y[cy] ^ z[cz] ^ seed) >> 28) as usize];
        g[0] * (fx - cx as f64) + g[1] * (fy - cy as f64) + g[2] * (fz - cz as f64)
    };
    let (u, v, w) = (fade(fx), fade(fy), fade(fz));
    let row = |cy, cz| lerp(corner(0, cy, cz), corner(1, cy, cz), u);
    let near = lerp(row(0, 0), row(1, 0), v);
    let far = lerp(row(0, 1), row(1, 1), v);
    lerp(near, far, w)
}

/// Three independent noises: a displacement.
pub(super) fn vector_noise(p: DVec3, seed: u32) -> DVec3 {
    DVec3::new(
        gradient_noise(p, seed ^ 0x1b56_c4e9),
        gradient_noise(p, seed ^ 0x7feb_352d),
        gradient_noise(p, seed ^ 0x846c_a68b),
    )
}

/// Fractional Brownian motion: `octaves` noises, each half as strong and twice as fine as the one
/// before; roughly in [-1, 1].
pub(super) fn fbm(p: DVec3, octaves: u32, seed: u32) -> f64 {
    sum_octaves(p, octaves, seed, |n| n)
}

/// Billows in [0, 1]: rounded bulges (near 1) that meet in sharp creases (0).
pub(super) fn billow(p: DVec3, octaves: u32, seed: u32) -> f64 {
    sum_octaves(p, octaves, seed, |n| (1.6 * n.abs()).min(1.0))
}

/// Ridged multifractal in [0, 1]: narrow crests (1) where the noise crosses 0, finer crests
/// mostly on coarser ones `[Musgrave1994]`.
pub(super) fn ridged(p: DVec3, octaves: u32, seed: u32) -> f64 {
    let (mut q, mut amplitude, mut weight) = (p, 1.0, 1.0);
    let (mut sum, mut total) = (0.0, 0.0);
    for octave in 0..octaves {
        let n = gradient_noise(q, seed.wrapping_add(octave)).abs();
        // |n|, rounded at 0: a crest with an edge would be thinner than any voxel.
        let crest = (1.0 - 1.6 * n * n / (n + 0.08)).max(0.0);
        let crest = crest * crest * weight;
        sum += amplitude * crest;
        total += amplitude;
        weight = (2.0 * crest).min(1.0);
        amplitude *= 0.4;
        q = q * LACUNARITY + OCTAVE_SHIFT;
    }
    sum / total
}

/// 0 below `from`, 1 above `to`, a smooth cubic between; `from` may be the larger one.
pub(super) fn smoothstep(from: f64, to: f64, x: f64) -> f64 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

fn sum_octaves(p: DVec3, octaves: u32, seed: u32, shape: impl Fn(f64) -> f64) -> f64 {
    let (mut q, mut amplitude) = (p, 1.0);
    let (mut sum, mut total) = (0.0, 0.0);
    for octave in 0..octaves {
        sum += amplitude * shape(gradient_noise(q, seed.wrapping_add(octave)));
        total += amplitude;
        amplitude *= 0.5;
        q = q * LACUNARITY + OCTAVE_SHIFT;
    }
    sum / total
}

/// Cell and position in it. A cast, which truncates, is much cheaper than `floor` without SSE 4.
fn split(x: f64) -> (i32, f64) {
    let cut = x as i32;
    let cell = cut - i32::from(f64::from(cut) > x);
    (cell, x - f64::from(cell))
}

/// The part of a lattice point's hash that one coordinate gives, for a cell's two ends.
fn hash_axis(cell: i32, factor: u32) -> [u32; 2] {
    let low = (cell as u32).wrapping_mul(factor);
    [low, low.wrapping_add(factor)]
}

/// Avalanche of the bits; the high ones are used.
fn mix(mut h: u32) -> u32 {
    h ^= h >> 16;
    h = h.wrapping_mul(0x7feb_352d);
    h ^= h >> 15;
    h.wrapping_mul(0x846c_a68b)
}

fn fade(t: f64) -> f64 {
    t * t * t * (t * (t * 6.0 - 15.0) + 10.0)
}

fn lerp(a: f64, b: f64, t: f64) -> f64 {
    a + (b - a) * t
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points() -> impl Iterator<Item = DVec3> {
        (0..4000).map(|i| {
            let i = f64::from(i);
            DVec3::new(i * 0.137 - 200.0, i * -0.071 + 3.0, i * 0.0437 - 90.0)
        })
    }

    #[test]
    fn noise_is_bounded_centred_and_not_flat() {
        let values: Vec<f64> = points().map(|p| gradient_noise(p, 7)).collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let variance = values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64;
        assert!(values.iter().all(|v| v.abs() <= 1.04));
        assert!(mean.abs() < 0.03, "{mean}");
        assert!((0.04..0.15).contains(&variance), "{variance}");
    }

    #[test]
    fn noise_vanishes_on_the_lattice_and_is_continuous_across_cells() {
        for (x, y, z) in [(0, 0, 0), (-3, 5, 1), (1000, -1000, 2)] {
            let p = DVec3::new(f64::from(x), f64::from(y), f64::from(z));
            assert_eq!(gradient_noise(p, 1), 0.0);
            let edge = p + DVec3::new(0.0, 0.3, 0.6);
            let step = DVec3::new(1e-9, 0.0, 0.0);
            let jump = gradient_noise(edge - step, 1) - gradient_noise(edge + step, 1);
            assert!(jump.abs() < 1e-7, "{jump}");
        }
    }

    #[test]
    fn seeds_give_different_noise() {
        let p = DVec3::new(0.3, 0.4, 0.7);
        assert_ne!(gradient_noise(p, 1), gradient_noise(p, 2));
    }

    #[test]
    fn sums_stay_in_their_ranges() {
        for p in points() {
            assert!((0.0..=1.0).contains(&ridged(p, 4, 3)));
            assert!((0.0..=1.0).contains(&billow(p, 4, 3)));
            assert!(fbm(p, 4, 3).abs() <= 1.04);
        }
    }

    #[test]
    fn smoothstep_runs_both_ways() {
        assert_eq!(smoothstep(0.0, 2.0, -1.0), 0.0);
        assert_eq!(smoothstep(0.0, 2.0, 1.0), 0.5);
        assert_eq!(smoothstep(2.0, 0.0, 3.0), 0.0);
        assert_eq!(smoothstep(2.0, 0.0, -1.0), 1.0);
    }
}
