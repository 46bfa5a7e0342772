//! `L_o` as the paper writes it, naively on the CPU in f64: the check of tables and of the GPU stages.
//!
//! Analog paths, absorbed by chance; nothing shared, split, led or known in closed form
//! `[Ament2013, Sec. 4.1.2]`.

use glam::DVec3;

use super::check::Point;
use crate::technique::phase_hg;

/// An entry's radiance, 1 / sr, with the standard error that `paths` paths leave.
#[must_use]
pub fn entry(theta: f64, sigma_t: f64, g: f64, albedo: f64, paths: u32, seed: u64) -> Point {
    let mut random = Random(seed);
    let (mut sum, mut squares) = (0.0, 0.0);
    for _ in 0..paths {
        let value = path(theta, sigma_t, g, albedo, &mut random);
        sum += value;
        squares += value * value;
    }
    let count = f64::from(paths);
    let mean = sum / count;
    let variance = (squares / count - mean * mean).max(0.0) / (count - 1.0);
    Point {
        albedo,
        g,
        sigma_t,
        theta,
        radiance: mean,
        standard_error: variance.sqrt(),
    }
}

/// What one path from the sphere's surface inwards brings.
fn path(theta: f64, sigma_t: f64, g: f64, albedo: f64, random: &mut Random) -> f64 {
    let mut x = DVec3::new(theta.sin(), 0.0, theta.cos());
    let mut v = -x;
    loop {
        let to_surface = distance_to_surface(x, v);
        let t = -(1.0 - random.next()).ln() / sigma_t;
        if t >= to_surface {
            return boundary(x + to_surface * v, -v, sigma_t, g);
        }
        if random.next() >= albedo {
            return 0.0;
        }
        x += t * v;
        v = scatter(v, g, random);
    }
}

/// `[Ament2013, Eq. 11]`: radiance that enters at `x` in direction `w`; the front travels along z.
#[must_use]
pub fn boundary(x: DVec3, w: DVec3, sigma_t: f64, g: f64) -> f64 {
    let crossed = 2.0 * x.z.max(0.0);
    (-crossed * sigma_t).exp() * phase_hg(w.z, g)
}

fn distance_to_surface(x: DVec3, v: DVec3) -> f64 {
    let along = x.dot(v);
    -along + (along * along + 1.0 - x.length_squared()).max(0.0).sqrt()
}

/// A direction by the phase function `[Henyey1941]`.
fn scatter(v: DVec3, g: f64, random: &mut Random) -> DVec3 {
    let u = random.next();
    let cos_theta = if g.abs() < 1e-3 {
        1.0 - 2.0 * u
    } else {
        let s = (1.0 - g * g) / (1.0 - g + 2.0 * g * u);
        (1.0 + g * g - s * s) / (2.0 * g)
    };
    let sin_theta = (1.0 - cos_theta * cos_theta).max(0.0).sqrt();
    let (x, y) = v.any_orthonormal_pair();
    let (sin_phi, cos_phi) = (std::f64::consts::TAU * random.next()).sin_cos();
    (sin_theta * (cos_phi * x + sin_phi * y) + cos_theta * v).normalize()
}

/// Numbers in [0, 1) `[Steele2014]`.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 * (0.5_f64).powi(53)
    }
}
