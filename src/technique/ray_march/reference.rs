//! The equations of `ray_march`, written naively on the CPU in f64: the check of the GPU stages.
//!
//! Same sample positions and the same filtering as the shader, but no table, no skipping, no early
//! end and the plain formula `1 - exp(-tau)`.

use glam::{DVec2, DVec3, DVec4};

use super::layout::step_length;
use crate::scene::{Falloff, Light, RayMarchParams, Scene, Shading};
use crate::technique::lights::mean_environment;
use crate::technique::reference_medium::ReferenceMedium;
use crate::technique::reference_ray::{camera_ray, interval};

/// Radiance (rgb) and `1 - transmittance` (w) of a point of the image; `(0, 0)` is the top left
/// corner, `(1, 1)` the bottom right one.
#[must_use]
pub fn march(scene: &Scene, params: &RayMarchParams, at: DVec2) -> DVec4 {
    let (origin, direction, t_min) = camera_ray(scene, at);
    let background = scene.image.background.as_dvec3();
    let Some((t0, t1)) = interval(scene, origin, direction, t_min) else {
        return background.extend(0.0);
    };
    let count = ((t1 - t0) / step_length(scene, params) - 1e-3)
        .ceil()
        .max(1.0);
    let dt = (t1 - t0) / count;
    let medium = ReferenceMedium::new(scene);
    let (mut radiance, mut tau) = (DVec3::ZERO, 0.0_f64);
    for i in 0..count as u64 {
        let x = origin + (t0 + (i as f64 + 0.5) * dt) * direction;
        let (color, sigma_t) = medium.material(medium.index(x));
        let dtau = sigma_t * dt;
        let source = match &params.shading {
            Some(shading) => shade(scene, shading, &medium, x, -direction, color),
            None => color,
        };
        radiance += (-tau).exp() * -(-dtau).exp_m1() * source;
        tau += dtau;
    }
    (radiance + (-tau).exp() * background).extend(-(-tau).exp_m1())
}

/// Blinn-Phong on the central-difference gradient, one voxel to either side.
fn shade(
    scene: &Scene,
    shading: &Shading,
    medium: &ReferenceMedium<'_>,
    x: DVec3,
    w_o: DVec3,
    color: DVec3,
) -> DVec3 {
    let d = medium.differences(medium.index(x));
    let n = medium.world_direction(d).normalize_or_zero();
    let n = if n.dot(w_o) < 0.0 { -n } else { n };
    let mut radiance =
        f64::from(shading.ambient) * mean_environment(&scene.lights).as_dvec3() * color;
    for light in &scene.lights {
        let (w_i, irradiance) = match *light {
            Light::Directional {
                direction,
                irradiance,
            } => (-direction.normalize(), irradiance.as_dvec3()),
            Light::Point {
                position,
                intensity,
                falloff,
            } => {
                let to = position - x;
                let weaker = if falloff == Falloff::None {
                    1.0
                } else {
                    to.length_squared()
                };
                (to.normalize(), intensity.as_dvec3() / weaker)
            }
            Light::Environment { .. } | Light::EnvironmentMap { .. } => continue,
        };
        let cos_i = n.dot(w_i);
        if cos_i > 0.0 {
            let cos_h = n.dot((w_i + w_o).normalize()).max(0.0);
            let specular = f64::from(shading.specular) * cos_h.powf(f64::from(shading.shininess));
            let reflected = f64::from(shading.diffuse) * cos_i * color + specular;
            radiance += irradiance * std::f64::consts::FRAC_1_PI * reflected;
        }
    }
    radiance
}
