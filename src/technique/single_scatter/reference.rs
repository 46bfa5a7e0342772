//! The equations of `single_scatter`, written naively on the CPU in f64: the check of the GPU stages.
//!
//! No table, no cache, no skipping, no early end: a shadow ray from the middle of every sample, midpoint
//! sums along both rays.

use glam::{DVec2, DVec3, DVec4};

use super::layout::step_length;
use crate::scene::{Falloff, Light, Scene, SingleScatterParams};
use crate::technique::phase_hg;
use crate::technique::reference_medium::ReferenceMedium;
use crate::technique::reference_ray::{camera_ray, interval};

/// Radiance (rgb) and `1 - transmittance` (w) of a point of the image; `(0, 0)` is the top left
/// corner, `(1, 1)` the bottom right one.
#[must_use]
pub fn march(scene: &Scene, params: &SingleScatterParams, at: DVec2) -> DVec4 {
    let (origin, direction, t_min) = camera_ray(scene, at);
    let background = scene.image.background.as_dvec3();
    let Some((t0, t1)) = interval(scene, origin, direction, t_min) else {
        return background.extend(0.0);
    };
    let eye = Eye {
        scene,
        medium: ReferenceMedium::new(scene),
        shadow_step: params.shadow_step * scene.volume.grid.spacing().min_element(),
    };
    let (count, dt) = steps(t1 - t0, step_length(scene, params));
    let medium = &scene.medium;
    let (mut radiance, mut tau) = (DVec3::ZERO, 0.0_f64);
    for i in 0..count {
        let x = origin + (t0 + (i as f64 + 0.5) * dt) * direction;
        let q = eye.medium.index(x);
        let (color, sigma_t) = eye.medium.material(q);
        let dtau = sigma_t * dt;
        let lit: DVec3 = scene.lights.iter().map(|l| eye.lit(l, x, direction)).sum();
        let source = medium.emission * color + medium.albedo * eye.medium.albedo(q, color) * lit;
        radiance += (-tau).exp() * -(-dtau).exp_m1() * source;
        tau += dtau;
    }
    (radiance + (-tau).exp() * background).extend(-(-tau).exp_m1())
}

struct Eye<'a> {
    scene: &'a Scene,
    medium: ReferenceMedium<'a>,
    shadow_step: f64,
}

impl Eye<'_> {
    /// Radiance per unit albedo that a light, dimmed on its way to `x`, scatters against `direction`.
    fn lit(&self, light: &Light, x: DVec3, direction: DVec3) -> DVec3 {
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
                let to = position - x;
                let weaker = match falloff {
                    Falloff::None => 1.0,
                    Falloff::InverseSquare => to.length_squared(),
                };
                (to.normalize(), to.length(), intensity.as_dvec3() / weaker)
            }
            Light::Environment { .. } | Light::EnvironmentMap { .. } => return DVec3::ZERO,
        };
        let tau = interval(self.scene, x, w_i, 0.0).map_or(0.0, |(start, end)| {
            let end = end.min(far);
            let (count, dt) = steps(end - start, self.shadow_step);
            let at = |i: u64| {
                let place = x + (start + (i as f64 + 0.5) * dt) * w_i;
                self.medium.sigma_t(self.medium.index(place))
            };
            (0..count).map(at).sum::<f64>() * dt
        });
        let phase = phase_hg(w_i.dot(direction), self.scene.medium.phase_g);
        irradiance * phase * (-tau).exp()
    }
}

/// Number and length of equal steps, none longer than `largest`.
fn steps(length: f64, largest: f64) -> (u64, f64) {
    let count = (length / largest - 1e-3).ceil().max(1.0);
    (count as u64, length.max(0.0) / count)
}
