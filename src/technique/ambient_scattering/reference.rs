//! The equations of `ambient_scattering`, written naively on the CPU in f64: the check of the GPU stages.
//!
//! The mean extinction is summed over all voxels for each node of its grid, the light at every sample is
//! followed along its own tube: no summed-area table, no cache, no interval, no skipping, no early end.

use glam::{DVec2, DVec3, DVec4, IVec3};

use super::choice;
use super::layout::{SPREAD_COSINE, step_length};
use super::slab::Slab;
use super::table::optics::unscattered;
use super::table::{Shipped, Slice};
use crate::scene::{AmbientScatteringParams, Falloff, Gather, Light, Scene, Tube};
use crate::technique::phase_hg;
use crate::technique::reference_medium::ReferenceMedium;
use crate::technique::reference_ray::{camera_ray, interval};
use crate::technique::summed_area::box_side;

/// A scene, seen through the equations: grey albedo, a node of mean extinction a voxel.
pub struct Reference<'a> {
    scene: &'a Scene,
    params: AmbientScatteringParams,
    radius: f64,
    medium: ReferenceMedium<'a>,
    // Mean extinction about every voxel, per world unit.
    ambient: Vec<f64>,
    slice: Slice,
    slab: Slab,
}

impl<'a> Reference<'a> {
    /// Sums the extinction about every voxel; the albedo is that of the first channel.
    #[must_use]
    pub fn new(scene: &'a Scene, params: &AmbientScatteringParams, shipped: &Shipped) -> Self {
        let albedo = choice::albedo(scene).x;
        let g = f64::from(scene.medium.phase_g as f32);
        let mut reference = Self {
            scene,
            params: *params,
            radius: choice::radius(scene, params.radius),
            medium: ReferenceMedium::new(scene),
            ambient: Vec::new(),
            slice: shipped.slice(g, albedo),
            slab: Slab::new(albedo, g),
        };
        let dims = scene.volume.grid.dims;
        let voxel = |i: usize| {
            let (x, y) = (dims.x as usize, dims.y as usize);
            IVec3::new((i % x) as i32, (i / x % y) as i32, (i / x / y) as i32)
        };
        let count = scene.volume.grid.voxel_count() as usize;
        reference.ambient = (0..count).map(|i| reference.mean_about(voxel(i))).collect();
        reference
    }

    /// Mean over a cube with the sphere's volume, voxels cut by its faces counted in part.
    fn mean_about(&self, centre: IVec3) -> f64 {
        let grid = &self.scene.volume.grid;
        let half = 0.5 * box_side(self.radius) / grid.spacing();
        let reach = half.ceil().as_ivec3();
        let mut sum = 0.0;
        for z in -reach.z..=reach.z {
            for y in -reach.y..=reach.y {
                for x in -reach.x..=reach.x {
                    let offset = IVec3::new(x, y, z);
                    let (low, high) = (offset.as_dvec3() - 0.5, offset.as_dvec3() + 0.5);
                    let share = (high.min(half) - low.max(-half)).max(DVec3::ZERO);
                    let at = centre + offset;
                    if share.min_element() > 0.0
                        && at.min_element() >= 0
                        && at.cmplt(grid.dims.as_ivec3()).all()
                    {
                        sum += share.element_product() * self.medium.sigma_t(at.as_dvec3());
                    }
                }
            }
        }
        sum / (8.0 * half.element_product())
    }

    /// Optical depth of a radius at the mean extinction about x: linear between voxels.
    fn depth(&self, x: DVec3) -> f64 {
        let dims = self.scene.volume.grid.dims;
        let last = dims.as_dvec3() - 1.0;
        let q = self.medium.index(x).clamp(DVec3::ZERO, last);
        let low = q.floor();
        let f = q - low;
        let mut sum = 0.0;
        for corner in 0..8 {
            let upper = DVec3::new(
                f64::from(corner & 1),
                f64::from(corner >> 1 & 1),
                f64::from(corner >> 2 & 1),
            );
            let weight = (upper * f + (1.0 - upper) * (1.0 - f)).element_product();
            let at = (low + upper).min(last).as_uvec3();
            sum += weight * self.ambient[self.scene.volume.grid.linear_index(at)];
        }
        sum * self.radius
    }

    /// Radiance (rgb) and `1 - transmittance` (w) of a point of the image; `(0, 0)` is the top left
    /// corner, `(1, 1)` the bottom right one.
    #[must_use]
    pub fn march(&self, at: DVec2) -> DVec4 {
        let (origin, direction, t_min) = camera_ray(self.scene, at);
        let background = self.scene.image.background.as_dvec3();
        let Some((t0, t1)) = interval(self.scene, origin, direction, t_min) else {
            return background.extend(0.0);
        };
        let count = ((t1 - t0) / step_length(self.scene, &self.params) - 1e-3)
            .ceil()
            .max(1.0);
        let dt = (t1 - t0) / count;
        let literal = self.params.gather == Gather::Literal;
        let m = &self.scene.medium;
        let (mut radiance, mut tau, mut tau_from) = (DVec3::ZERO, 0.0_f64, 0.0_f64);
        for i in 0..count as u64 {
            let t = t0 + (i as f64 + 0.5) * dt;
            let x = origin + t * direction;
            let (color, sigma_t) = self.medium.material(self.medium.index(x));
            let dtau = sigma_t * dt;
            let lit: DVec3 = self
                .scene
                .lights
                .iter()
                .map(|l| self.lit(l, x, direction))
                .sum();
            let source = m.albedo * color * lit;
            let weight = if literal {
                (-tau_from).exp() * dtau
            } else {
                (-tau).exp() * -(-dtau).exp_m1()
            };
            radiance += weight * source;
            tau += dtau;
            if t - self.radius > t0 - 0.5 * dt {
                let nearer = self.medium.index(x - self.radius * direction);
                tau_from += self.medium.sigma_t(nearer) * dt;
            }
        }
        (radiance + (-tau).exp() * background).extend(-(-tau).exp_m1())
    }

    /// Radiance per unit albedo that a light scatters at x against `direction`.
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
        let cos_theta = w_i.dot(direction).clamp(-1.0, 1.0);
        let depth = self.depth(x);
        let [all, direct] = self.arriving(x, w_i, far);
        let theta = cos_theta.acos();
        let about = self.slice.radiance(theta, depth);
        if self.params.gather == Gather::Literal {
            return irradiance * all * about;
        }
        let g = self.scene.medium.phase_g;
        // Half a step: from where the light enters the sphere.
        let passed = match self.params.tube {
            Tube::Slab => self.transmission(depth, 1.0),
            _ => self.slice.radiance(0.0, 0.5 * depth) / self.slice.radiance(0.0, 0.0),
        };
        let spread = (all * passed - direct).max(0.0);
        let local = about - unscattered(theta, depth, g);
        irradiance
            * (all * local
                + direct * phase_hg(cos_theta, g)
                + spread * phase_hg(cos_theta, SPREAD_COSINE * g))
    }

    /// Share of a light that enters the sphere about x, and that which comes straight to x.
    fn arriving(&self, x: DVec3, w_i: DVec3, far: f64) -> [f64; 2] {
        let Some((t0, t1)) = interval(self.scene, x, w_i, 0.0) else {
            return [1.0, 1.0];
        };
        let (t1, radius) = (t1.min(far), self.radius);
        if t0 >= t1 {
            return [1.0, 1.0];
        }
        let begin = (t0 + radius).min(t1);
        let along = |a: f64, b: f64| self.depth(x + 0.5 * (a + b) * w_i);
        let mut direct = (begin - t0) / radius * along(t0, begin);
        let (mut all, mut near) = (1.0, begin);
        while near < t1 - 1e-3 * 2.0 * radius {
            let end = (near + 2.0 * radius).min(t1);
            let (depth, share) = (along(near, end), (end - near) / radius);
            all *= self.transmission(depth, share);
            direct += share * depth;
            near = end;
        }
        [all, (-direct).exp()]
    }

    /// Of a step of `share` radii, each of optical depth `depth`.
    fn transmission(&self, depth: f64, share: f64) -> f64 {
        let straight = self.slice.radiance(0.0, depth);
        let linear = |whole: f64| 1.0 + 0.5 * share * (whole - 1.0);
        match self.params.tube {
            Tube::Slab => (-share * depth * self.slab.dimming(share * depth)).exp(),
            Tube::Literal => linear(straight),
            Tube::Normalized => linear(straight / self.slice.radiance(0.0, 0.0)),
        }
    }
}
