//! The textbook estimator, on the CPU in f64: one majorant for the whole volume, analog delta tracking
//! `[Woodcock1965]`, a path goes on as long as chance (the albedo) lets it, light is met and not looked
//! for. Only lights that no path can meet, directional and point lights, are looked at from every
//! collision, and then by an analog walk too: the light gets through or it does not.
//!
//! It shares no table, no bounds, no random numbers and no estimator of transmittance with the shader.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use crate::scene::transfer_function::OPACITY_MAX;
use crate::scene::{Falloff, Light, PathTraceParams, Perturbation, Scene, world_from_map};
use crate::technique::lights::environment;
use crate::technique::phase_hg;
use crate::technique::reference_medium::ReferenceMedium;
use crate::technique::reference_ray::{camera_ray, interval};

/// Sums over the samples of a pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Estimate {
    /// Mean radiance.
    pub mean: DVec3,
    /// Variance of that mean: its squared standard error.
    pub variance: DVec3,
    /// Mean of `1 - transmittance`.
    pub alpha: f64,
}

/// Every pixel, row by row from the top left.
#[must_use]
pub fn render(scene: &Scene, params: &PathTraceParams) -> Vec<Estimate> {
    let tracer = Tracer::new(scene, params);
    let pixels = scene.image.width * scene.image.height;
    let pixel = |i: u32| {
        let mut random = Random(u64::from(params.seed) << 32 | u64::from(i));
        let corner = DVec2::new(
            f64::from(i % scene.image.width),
            f64::from(i / scene.image.width),
        );
        let (mut sum, mut squares, mut alpha) = (DVec3::ZERO, DVec3::ZERO, 0.0);
        for _ in 0..params.samples {
            let place = corner + DVec2::new(random.next(), random.next());
            let size = DVec2::new(scene.image.width.into(), scene.image.height.into());
            let (radiance, met) = tracer.path(place / size, &mut random);
            sum += radiance;
            squares += radiance * radiance;
            alpha += f64::from(u8::from(met));
        }
        let n = f64::from(params.samples);
        let mean = sum / n;
        Estimate {
            mean,
            variance: (squares / n - mean * mean) / (n - 1.0).max(1.0),
            alpha: alpha / n,
        }
    };
    (0..pixels).into_par_iter().map(pixel).collect()
}

/// The cosine of a direction drawn from the Henyey-Greenstein phase function by a uniform `u` in [0, 1);
/// 1 is straight on.
#[must_use]
pub fn sample_hg(u: f64, g: f64) -> f64 {
    if g.abs() < 1e-6 {
        return 1.0 - 2.0 * u;
    }
    let s = (1.0 - g * g) / (1.0 - g + 2.0 * g * u);
    (1.0 + g * g - s * s) / (2.0 * g)
}

struct Tracer<'a> {
    scene: &'a Scene,
    medium: ReferenceMedium<'a>,
    majorant: f64,
    max_scatter: u32,
}

impl<'a> Tracer<'a> {
    fn new(scene: &'a Scene, params: &PathTraceParams) -> Self {
        let tf = &scene.medium.transfer_function;
        let s = &scene.statistics;
        let perturbation = scene.medium.perturbation.as_ref();
        let varied = perturbation.map_or(0.0, Perturbation::largest_variation);
        // All shapes together are no denser than the sum of their peaks.
        let shapes = tf.primitives.iter().map(|p| p.opacity);
        let shapes: f64 = shapes.map(|a| -(-a.min(OPACITY_MAX)).ln_1p()).sum();
        let inside = tf.points.iter().map(|p| p.value);
        let sigma_t = inside
            .chain([s.min, s.max])
            .map(|value| tf.sigma_t(value.clamp(s.min, s.max)))
            .chain([shapes / tf.opacity_unit_distance]);
        Self {
            scene,
            medium: ReferenceMedium::new(scene),
            majorant: sigma_t.fold(1e-30, f64::max) * scene.medium.density_scale * (1.0 + varied),
            max_scatter: params.max_scatter.unwrap_or(u32::MAX),
        }
    }

    /// Radiance that arrives along one path, and whether it met the medium.
    fn path(&self, at: DVec2, random: &mut Random) -> (DVec3, bool) {
        let background = self.scene.image.background.as_dvec3();
        let (o, mut d, t_min) = camera_ray(self.scene, at);
        let Some((t0, t1)) = interval(self.scene, o, d, t_min) else {
            return (background, false);
        };
        let mut x = o + t0 * d;
        let mut t_end = t1 - t0;
        let medium = &self.scene.medium;
        let (mut throughput, mut radiance) = (DVec3::ONE, DVec3::ZERO);
        for events in 0.. {
            let Some(t) = self.collide(x, d, t_end, random) else {
                let beyond = if events == 0 {
                    background
                } else {
                    environment(&self.scene.lights).as_dvec3() + self.maps(d)
                };
                return (radiance + throughput * beyond, events > 0);
            };
            x += t * d;
            let q = self.medium.index(x);
            let (color, _) = self.medium.material(q);
            radiance += throughput * medium.emission * color;
            let albedo = medium.albedo * self.medium.albedo(q, color);
            let survival = albedo.max_element();
            if events >= self.max_scatter || random.next() >= survival {
                return (radiance, true);
            }
            throughput *= albedo / survival;
            for light in &self.scene.lights {
                radiance += throughput * self.direct(light, x, d, random);
            }
            let cos_theta = sample_hg(random.next(), medium.phase_g);
            d = turn(d, cos_theta, TAU * random.next());
            t_end = self.way_out(x, d);
        }
        (radiance, true)
    }

    /// Radiance of the environment maps that a path meets along `d`.
    fn maps(&self, d: DVec3) -> DVec3 {
        let radiance = |l: &Light| match l {
            Light::EnvironmentMap {
                map,
                scale,
                up,
                rotation_deg,
            } => {
                let map_from_world = world_from_map(*up, *rotation_deg).transpose();
                scale.as_dvec3() * map.radiance(map_from_world * d)
            }
            _ => DVec3::ZERO,
        };
        self.scene.lights.iter().map(radiance).sum()
    }

    /// Light scattered once at `x` from `light` into the path that arrived along `d`.
    fn direct(&self, light: &Light, x: DVec3, d: DVec3, random: &mut Random) -> DVec3 {
        let (w_i, far, irradiance) = match light {
            Light::Directional {
                direction,
                irradiance,
            } => (-direction.normalize(), f64::INFINITY, irradiance.as_dvec3()),
            Light::Point {
                position,
                intensity,
                falloff,
            } => {
                let to = *position - x;
                let weaker = match falloff {
                    Falloff::None => 1.0,
                    Falloff::InverseSquare => to.length_squared(),
                };
                (to.normalize(), to.length(), intensity.as_dvec3() / weaker)
            }
            Light::Environment { .. } | Light::EnvironmentMap { .. } => return DVec3::ZERO,
        };
        let t_end = self.way_out(x, w_i).min(far);
        match self.collide(x, w_i, t_end, random) {
            Some(_) => DVec3::ZERO,
            None => irradiance * phase_hg(d.dot(w_i), self.scene.medium.phase_g),
        }
    }

    /// Where the medium ends along `d` from `x`.
    fn way_out(&self, x: DVec3, d: DVec3) -> f64 {
        interval(self.scene, x, d, 0.0).map_or(0.0, |(_, end)| end)
    }

    /// Distance to the next collision, if there is one before `t_end`.
    fn collide(&self, x: DVec3, d: DVec3, t_end: f64, random: &mut Random) -> Option<f64> {
        let mut t = 0.0;
        loop {
            t -= (-random.next()).ln_1p() / self.majorant;
            if t >= t_end {
                return None;
            }
            let sigma_t = self.medium.sigma_t(self.medium.index(x + t * d));
            if random.next() * self.majorant < sigma_t {
                return Some(t);
            }
        }
    }
}

/// The direction at angle `acos(cos_theta)` from `w`, at `phi` about it.
fn turn(w: DVec3, cos_theta: f64, phi: f64) -> DVec3 {
    let x = w.any_orthonormal_vector();
    let y = w.cross(x);
    let sin_theta = (1.0 - cos_theta * cos_theta).max(0.0).sqrt();
    (sin_theta * (phi.cos() * x + phi.sin() * y) + cos_theta * w).normalize()
}

/// The splitmix64 generator `[Steele2014]`.
struct Random(u64);

impl Random {
    /// A uniform number in [0, 1).
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 * 2f64.powi(-53)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_cosine_of_phase_samples_is_g() {
        for g in [-0.99, -0.8, -0.1, 0.0, 1e-7, 0.1, 0.8, 0.99] {
            // Midpoints of equal strata: the error is that of the midpoint rule.
            let n = 200_000;
            let draw = |i: i32| sample_hg((f64::from(i) + 0.5) / f64::from(n), g);
            let mean = (0..n).map(draw).sum::<f64>() / f64::from(n);
            assert!((mean - g).abs() < 1e-6, "g {g}: {mean}");
        }
    }

    #[test]
    fn phase_samples_are_distributed_like_the_phase_function() {
        for g in [-0.8, 0.0, 0.8] {
            // The share of samples below a cosine is the integral of the phase function up to it.
            for cos_theta in [-0.9, -0.5, 0.0, 0.5, 0.9] {
                let n = 20_000;
                let at = |i: i32| -1.0 + (cos_theta + 1.0) * (f64::from(i) + 0.5) / f64::from(n);
                let integral = (0..n).map(|i| TAU * phase_hg(at(i), g)).sum::<f64>()
                    * (cos_theta + 1.0)
                    / f64::from(n);
                let below =
                    |i: &i32| sample_hg((f64::from(*i) + 0.5) / f64::from(n), g) < cos_theta;
                let share = (0..n).filter(below).count() as f64 / f64::from(n);
                assert!((share - integral).abs() < 2e-4, "g {g}, {cos_theta}");
            }
        }
    }
}
