//! The equations of `ambient_occlusion`, written naively on the CPU in f64: the check of the GPU stages.
//!
//! [`Occlusion`] is what the stages compute, without table and levels; [`visibility`] what it stands for, the
//! mean over directions. [`march`] has no table, no skipping, no early end, and looks at every sample.

use std::f64::consts::PI;

use glam::{DVec2, DVec3, DVec4, UVec3};

use super::layout::step_length;
use crate::scene::{AmbientOcclusionParams, Scene};
use crate::technique::lights::mean_environment;
use crate::technique::reference_medium::ReferenceMedium;
use crate::technique::reference_ray::{camera_ray, interval};
use crate::technique::summed_area::{FieldPlan, reference};

/// Share of the environment's light that reaches the centres of cells.
pub struct Occlusion {
    cells: UVec3,
    /// Cells a unit of texture coordinate of the volume.
    per_texture: DVec3,
    values: Vec<f64>,
}

impl Occlusion {
    /// Sums boxes cell by cell.
    #[must_use]
    pub fn new(scene: &Scene, plan: &FieldPlan) -> Self {
        Self {
            cells: plan.area.cells,
            per_texture: plan.scale * plan.area.cells.as_dvec3(),
            values: reference::field(scene, plan),
        }
    }

    /// Trilinear between the centres of cells; `p`: texture coordinates of the volume.
    #[must_use]
    pub fn at(&self, p: DVec3) -> f64 {
        let last = self.cells - 1;
        let q = (p * self.per_texture - 0.5).clamp(DVec3::ZERO, last.as_dvec3());
        let (base, f) = (q.floor(), q.fract());
        (0..8u32)
            .map(|corner| {
                let o = UVec3::new(corner & 1, (corner >> 1) & 1, corner >> 2);
                let i = (base.as_uvec3() + o).min(last);
                let w = DVec3::select(o.cmpeq(UVec3::ONE), f, 1.0 - f);
                let index = i.x + self.cells.x * (i.y + self.cells.y * i.z);
                w.element_product() * self.values[index as usize]
            })
            .sum()
    }
}

/// Radiance (rgb) and `1 - transmittance` (w) of a point of the image; `(0, 0)` is the top left
/// corner, `(1, 1)` the bottom right one.
#[must_use]
pub fn march(
    scene: &Scene,
    params: &AmbientOcclusionParams,
    occlusion: &Occlusion,
    at: DVec2,
) -> DVec4 {
    let (origin, direction, t_min) = camera_ray(scene, at);
    let background = scene.image.background.as_dvec3();
    let Some((t0, t1)) = interval(scene, origin, direction, t_min) else {
        return background.extend(0.0);
    };
    let medium = ReferenceMedium::new(scene);
    let texture_from_world = scene.volume.grid.world_from_texture().inverse();
    let environment = mean_environment(&scene.lights).as_dvec3();
    let (count, dt) = steps(t1 - t0, step_length(scene, params));
    let m = &scene.medium;
    let (mut radiance, mut tau) = (DVec3::ZERO, 0.0_f64);
    for i in 0..count {
        let x = origin + (t0 + (i as f64 + 0.5) * dt) * direction;
        let q = medium.index(x);
        let (color, sigma_t) = medium.material(q);
        let dtau = sigma_t * dt;
        let albedo = medium.albedo(q, color);
        let share = occlusion.at(texture_from_world.transform_point3(x));
        let source = m.emission * color + m.albedo * albedo * environment * share;
        radiance += (-tau).exp() * -(-dtau).exp_m1() * source;
        tau += dtau;
    }
    (radiance + (-tau).exp() * background).extend(-(-tau).exp_m1())
}

/// Share of even light from all around that is not absorbed within `radius` of `x`: the mean over `directions`
/// directions of `exp(-optical depth)`, by midpoint sums over steps of at most `step`; world units.
#[must_use]
pub fn visibility(scene: &Scene, x: DVec3, radius: f64, directions: u32, step: f64) -> f64 {
    let medium = ReferenceMedium::new(scene);
    let sum: f64 = (0..directions)
        .map(|i| {
            let w_i = spiral(i, directions);
            let tau = interval(scene, x, w_i, 0.0).map_or(0.0, |(start, end)| {
                let (count, dt) = steps(end.min(radius) - start, step);
                let at = |k: u64| {
                    let place = x + (start + (k as f64 + 0.5) * dt) * w_i;
                    medium.sigma_t(medium.index(place))
                };
                (0..count).map(at).sum::<f64>() * dt
            });
            (-tau).exp()
        })
        .sum();
    sum / f64::from(directions)
}

/// Directions evenly over the sphere, along a spiral from pole to pole.
fn spiral(i: u32, count: u32) -> DVec3 {
    let z = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(count);
    // The golden angle.
    let phi = f64::from(i) * PI * (3.0 - 5f64.sqrt());
    let r = (1.0 - z * z).max(0.0).sqrt();
    DVec3::new(r * phi.cos(), r * phi.sin(), z)
}

/// Number and length of equal steps, none longer than `largest`.
fn steps(length: f64, largest: f64) -> (u64, f64) {
    let count = (length / largest - 1e-3).ceil().max(1.0);
    (count as u64, length.max(0.0) / count)
}
