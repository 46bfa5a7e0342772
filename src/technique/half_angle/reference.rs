//! The sweeps of `half_angle`, written naively on the CPU in f64: the check of the GPU stages.
//!
//! Whole buffers and whole images for every slice: no bounds, no skipping, no early end, no table of colours, no
//! surfaces. One ray a pixel, through its centre.

use std::f64::consts::FRAC_PI_2;

use glam::{DVec2, DVec3, DVec4, IVec2};

use super::frustum::{LightFrustum, Place};
use super::layout::LONGEST_WAY;
use super::plan::HalfAnglePlan;
use super::sweep::Sweep;
use super::tables;
use crate::scene::{Falloff, HalfAngleParams, Light, Lighting, Scene, TransportColor};
use crate::technique::phase_hg;
use crate::technique::reference_medium::ReferenceMedium;
use crate::technique::reference_ray::{camera_ray, interval};

/// Radiance (rgb) and `1 - transmittance` (w) of every pixel, row by row from the top.
#[must_use]
pub fn image(scene: &Scene, params: &HalfAngleParams, plan: &HalfAnglePlan) -> Vec<DVec4> {
    let world = World::new(scene, params, plan);
    let [width, height] = plan.image;
    let mut sum = vec![DVec4::ZERO; width as usize * height as usize];
    for (index, sweep) in plan.sweeps.iter().enumerate() {
        let first = index == 0;
        for (to, seen) in sum.iter_mut().zip(world.sweep(sweep, first)) {
            let behind = (-seen.w).exp() * scene.image.background.as_dvec3();
            let once = if first { 1.0 } else { 0.0 };
            *to += (seen.truncate() + once * behind).extend(once * -(-seen.w).exp_m1());
        }
    }
    sum
}

/// Scattered light, a share of the irradiance, and optical depth to the light.
pub type Texel = DVec4;

struct World<'a> {
    scene: &'a Scene,
    params: &'a HalfAngleParams,
    plan: &'a HalfAnglePlan,
    medium: ReferenceMedium<'a>,
}

/// The medium at a place.
struct Sample {
    sigma_t: f64,
    color: DVec3,
    albedo: DVec3,
    decay: DVec3,
}

impl<'a> World<'a> {
    fn new(scene: &'a Scene, params: &'a HalfAngleParams, plan: &'a HalfAnglePlan) -> Self {
        Self {
            scene,
            params,
            plan,
            medium: ReferenceMedium::new(scene),
        }
    }

    fn sample(&self, x: DVec3) -> Sample {
        let medium = &self.scene.medium;
        let q = self.medium.index(x);
        let (color, sigma_t) = self.medium.material(q);
        let albedo = medium.albedo * self.medium.albedo(q, color);
        let decay = match &self.params.transport_color {
            _ if self.params.lighting != Lighting::Indirect => DVec3::ONE,
            TransportColor::Auto => {
                DVec3::from(albedo.to_array().map(|a| tables::decay(a, medium.phase_g)))
            }
            TransportColor::Points(rows) => DVec3::from(
                tables::transport_color(rows, self.medium.value(q)).map(tables::decay_of),
            ),
        };
        Sample {
            sigma_t,
            color,
            albedo,
            decay,
        }
    }

    /// What every pixel sees in one sweep: radiance and optical depth.
    fn sweep(&self, sweep: &Sweep, first: bool) -> Vec<DVec4> {
        let [width, height] = self.plan.image;
        let size = DVec2::new(width.into(), height.into());
        let pixels = width as usize * height as usize;
        let mut seen = vec![DVec4::ZERO; pixels];
        let texels = sweep
            .light
            .as_ref()
            .map_or(1, |l| l.texels.element_product());
        let mut light = vec![Texel::ZERO; texels as usize];
        for slice in 0..sweep.slices {
            for (i, seen) in seen.iter_mut().enumerate() {
                let pixel = DVec2::new((i % width as usize) as f64, (i / width as usize) as f64);
                let ray = camera_ray(self.scene, (pixel + 0.5) / size);
                self.shade(sweep, slice, first, ray, &light, seen);
            }
            if let Some(frustum) = &sweep.light {
                light = self.propagate(sweep, slice, frustum, &light);
            }
        }
        seen
    }

    /// The stretch of a ray in a slice, in equal steps.
    fn stretches(
        &self,
        sweep: &Sweep,
        slice: u32,
        (o, d, t_min): (DVec3, DVec3, f64),
    ) -> Vec<(f64, f64)> {
        let centre = self.scene.volume.grid.centre();
        let slope = d.dot(sweep.axis);
        let faces = [sweep.face(slice), sweep.face(slice + 1)]
            .map(|f| (f - (o - centre).dot(sweep.axis)) / slope);
        let Some((near, far)) = interval(self.scene, o, d, t_min) else {
            return Vec::new();
        };
        let near = near.max(faces[0].min(faces[1]));
        let far = far.min(faces[0].max(faces[1]));
        if near >= far {
            return Vec::new();
        }
        let count = ((far - near) / (LONGEST_WAY * sweep.thickness) - 1e-3)
            .ceil()
            .max(1.0);
        let dt = (far - near) / count;
        let step = |i: u32| (near + f64::from(i) * dt, near + f64::from(i + 1) * dt);
        (0..count as u32).map(step).collect()
    }

    fn shade(
        &self,
        sweep: &Sweep,
        slice: u32,
        first: bool,
        (o, d, t_min): (DVec3, DVec3, f64),
        light: &[Texel],
        seen: &mut DVec4,
    ) {
        let onward = d.dot(sweep.axis) > 0.0;
        let before = if onward { seen.w } else { 0.0 };
        let (mut tau, mut radiance) = (before, DVec3::ZERO);
        for (start, end) in self.stretches(sweep, slice, (o, d, t_min)) {
            let m = self.sample(o + 0.5 * (start + end) * d);
            let dtau = m.sigma_t * (end - start);
            let emission = match self.params.lighting {
                Lighting::None => 1.0,
                _ if first => self.scene.medium.emission,
                _ => 0.0,
            };
            radiance += emission * m.color * (-tau).exp() * -(-dtau).exp_m1();
            if let Some(frustum) = &sweep.light {
                let lit = Stretch {
                    ray: (o, d),
                    t: (start, end),
                    tau,
                    face: sweep.face(slice),
                };
                radiance += self.scattered(sweep, frustum, &lit, &m, light);
            }
            tau += dtau;
        }
        let dtau = tau - before;
        let dimmed = if onward { 1.0 } else { (-dtau).exp() };
        *seen = (dimmed * seen.truncate() + radiance).extend(seen.w + dtau);
    }

    fn scattered(
        &self,
        sweep: &Sweep,
        frustum: &LightFrustum,
        s: &Stretch,
        m: &Sample,
        light: &[Texel],
    ) -> DVec3 {
        let (o, d) = s.ray;
        let (start, end) = self.lit(frustum, s);
        if start >= end {
            return DVec3::ZERO;
        }
        let (near, far) = (o + start * d, o + end * d);
        let x = 0.5 * (near + far);
        let (w_i, irradiance) = self.arriving(frustum, x, far - near);
        let centre = self.scene.volume.grid.centre();
        let (found, rise) = look(frustum, x - centre, far - near, light);
        let way = [near, far].map(|x| m.sigma_t * self.way(sweep, frustum, x, w_i, s.face));
        let tau = [start, end].map(|t| s.tau + m.sigma_t * (t - s.t.0));
        // Both exponents rise evenly: the mean of the exponential between.
        let mean = |decay: f64, rise: f64| {
            let [a, b] = [(0, -rise), (1, rise)].map(|(i, rise)| tau[i] + decay * way[i] + rise);
            if (b - a).abs() < 1e-9 {
                (-a).exp()
            } else {
                ((-a).exp() - (-b).exp()) / (b - a)
            }
        };
        let dtau = m.sigma_t * (end - start);
        let direct = dtau * (-found.w).exp() * mean(1.0, rise);
        let cos_theta = w_i.dot(d);
        let g = self.scene.medium.phase_g;
        let mut sum = direct * self.phase(cos_theta);
        if self.params.lighting == Lighting::Indirect {
            let arrived = found.truncate() + (-found.w).exp();
            let all = [0, 1, 2].map(|c| {
                // At no end more than the light brings.
                let most = (-arrived[c].ln()).max(0.0);
                arrived[c] * mean(m.decay[c], (m.decay[c] * rise).clamp(-most, most))
            });
            let all = dtau * DVec3::from(all);
            sum += phase_hg(cos_theta, 0.5 * g) * (all - direct).max(DVec3::ZERO);
        }
        m.albedo * irradiance * sum
    }

    fn phase(&self, cos_theta: f64) -> DVec3 {
        let rows = tables::phase(self.params);
        if self.params.phase_table.is_none() {
            return DVec3::splat(phase_hg(cos_theta, self.scene.medium.phase_g));
        }
        let at = (0.5 + 0.5 * cos_theta).clamp(0.0, 1.0) * (rows.len() - 1) as f64;
        let row = |i: usize| DVec4::from(rows[i.min(rows.len() - 1)].map(f64::from)).truncate();
        let low = at.floor();
        row(low as usize).lerp(row(low as usize + 1), at - low)
    }

    /// Direction to the light at x, and its irradiance along `way` about x.
    fn arriving(&self, frustum: &LightFrustum, x: DVec3, way: DVec3) -> (DVec3, DVec3) {
        let is_lamp = |l: &&Light| matches!(l, Light::Directional { .. } | Light::Point { .. });
        let mut lamps = self.scene.lights.iter().filter(is_lamp);
        match lamps.nth(frustum.light as usize) {
            Some(Light::Directional { irradiance, .. }) => (-frustum.axis, irradiance.as_dvec3()),
            Some(Light::Point {
                position,
                intensity,
                falloff,
            }) => {
                let to = *position - x;
                let weakened = match falloff {
                    Falloff::None => 1.0,
                    Falloff::InverseSquare => {
                        // The mean of 1 / d^2.
                        let (length, along) = (way.length(), to.dot(way.normalize()));
                        let beside = (to.length_squared() - along * along).max(1e-12).sqrt();
                        let angle = |s: f64| ((s - along) / beside).atan();
                        (angle(0.5 * length) - angle(-0.5 * length)) / (beside * length)
                    }
                };
                (to.normalize(), weakened * intensity.as_dvec3())
            }
            _ => (-frustum.axis, DVec3::ZERO),
        }
    }

    /// The part of a stretch that the frustum's light shines on.
    fn lit(&self, frustum: &LightFrustum, s: &Stretch) -> (f64, f64) {
        let (mut start, mut end) = s.t;
        let Place::At(place) = frustum.place else {
            return (start, end);
        };
        if frustum.is_part {
            let (o, d) = s.ray;
            let from = o - self.scene.volume.grid.centre() - place;
            let [u, v] = frustum.across;
            for side in [u, -u, v, -v].map(|u| frustum.axis + u) {
                let (height, slope) = (from.dot(side), d.dot(side));
                if slope > 0.0 {
                    start = start.max(-height / slope);
                } else if slope < 0.0 {
                    end = end.min(-height / slope);
                } else if height < 0.0 {
                    end = start;
                }
            }
        }
        (start, end)
    }

    /// Length of the way of light to x within the slice and the medium.
    fn way(&self, sweep: &Sweep, frustum: &LightFrustum, x: DVec3, w_i: DVec3, face: f64) -> f64 {
        let local = x - self.scene.volume.grid.centre();
        let from_face = (local.dot(sweep.axis) - face) / -sweep.axis.dot(w_i);
        // A rounding error within the medium, so that the way out is found from its surface too.
        let out = interval(self.scene, x + 1e-9 * w_i, w_i, 0.0).map_or(0.0, |t| t.1);
        let to_light = match frustum.place {
            Place::Far => f64::INFINITY,
            Place::At(place) => local.distance(place),
        };
        from_face.min(out).min(to_light).max(0.0)
    }

    /// Every texel's light where it leaves a slice.
    fn propagate(
        &self,
        sweep: &Sweep,
        slice: u32,
        frustum: &LightFrustum,
        light: &[Texel],
    ) -> Vec<Texel> {
        let width = frustum.texels.x as usize;
        let centre = self.scene.volume.grid.centre();
        let texel = |(i, here): (usize, &Texel)| {
            let at = IVec2::new((i % width) as i32, (i / width) as i32);
            let place = frustum.low + (at.as_dvec2() + 0.5) * frustum.texel_size;
            let beside = place.x * frustum.across[0] + place.y * frustum.across[1];
            let ray = match frustum.place {
                Place::Far => (centre + beside, frustum.axis, f64::NEG_INFINITY),
                Place::At(p) => (centre + p, (frustum.axis + beside).normalize(), 0.0),
            };
            let (mut tau, mut tau_i, mut way) = (0.0, DVec3::ZERO, 0.0);
            let mut depth = 1.0;
            for (start, end) in self.stretches(sweep, slice, ray) {
                let m = self.sample(ray.0 + 0.5 * (start + end) * ray.1);
                tau += m.sigma_t * (end - start);
                tau_i += m.sigma_t * (end - start) * m.decay;
                way += end - start;
                if frustum.place != Place::Far {
                    depth = (end - 0.5 * way) * ray.1.dot(frustum.axis);
                }
            }
            if tau <= 0.0 || self.params.lighting != Lighting::Indirect {
                return here.truncate().extend(here.w + tau);
            }
            let turns = way * -(-tau / way * self.plan.free_path).exp_m1();
            let size = frustum.texel_size * depth;
            let variance = self.plan.spread * turns / (size * size);
            let around = self.spread(frustum, light, (at, slice), variance);
            let direct = (-here.w).exp();
            let turned = (-tau_i).exp() - DVec3::splat((-tau).exp());
            let most = -(-here.w - tau).exp_m1();
            let scattered = (-tau_i).exp() * around + direct * turned.max(DVec3::ZERO);
            scattered.min(DVec3::splat(most)).extend(here.w + tau)
        };
        light.iter().enumerate().map(texel).collect()
    }

    /// The spread of the shader, with its noise in f32, where a bit may move an offset.
    fn spread(
        &self,
        f: &LightFrustum,
        light: &[Texel],
        (at, slice): (IVec2, u32),
        variance: f64,
    ) -> DVec3 {
        let place = at.as_vec2() + 5.588_238 * (slice & 63) as f32;
        let dot = place.x * 0.067_110_56 + place.y * 0.005_837_15;
        let turn = f64::from((52.982_918_f32 * dot.fract()).fract());
        let quads = self.params.blur_samples / 4;
        let offset = |i: u32| {
            let ring = ((f64::from(i) + 0.5) / (0.5 * f64::from(quads))).sqrt();
            let radius = (ring * (2.0 * variance).sqrt() + 0.71).max(1.0);
            let angle = FRAC_PI_2 * (turn + 0.618_034 * f64::from(i)).fract();
            (radius * DVec2::new(angle.cos(), angle.sin()))
                .round()
                .as_ivec2()
        };
        let offsets: Vec<_> = (0..quads).map(offset).collect();
        let squares: i32 = offsets.iter().map(|o| o.length_squared()).sum();
        let share = (2.0 * variance * f64::from(quads) / f64::from(squares)).min(1.0);
        let size = f.texels.as_ivec2();
        let around = offsets.iter().flat_map(|&o| {
            let turned = [o, IVec2::new(-o.y, o.x), -o, IVec2::new(o.y, -o.x)];
            turned.map(|o| {
                let on = (at + o).clamp(IVec2::ZERO, size - 1);
                let there = on == at + o || f.is_part;
                light[(on.x + on.y * size.x) as usize].truncate() * f64::from(u8::from(there))
            })
        });
        let mean = around.sum::<DVec3>() / f64::from(4 * quads);
        let here = light[(at.x + at.y * size.x) as usize].truncate();
        here.lerp(mean, share)
    }
}

/// A stretch of a ray with one sample, the depth before it, and the slice's face.
struct Stretch {
    ray: (DVec3, DVec3),
    t: (f64, f64),
    tau: f64,
    face: f64,
}

/// The light buffer between its texels' centres, and the depth's rise along half of `way` about x.
fn look(frustum: &LightFrustum, x: DVec3, way: DVec3, light: &[Texel]) -> (Texel, f64) {
    let size = frustum.texels.as_ivec2();
    let place = |x: DVec3| frustum.texel(x).unwrap_or(DVec2::ZERO) - 0.5;
    let half_way = (place(x + 1e-5 * way) - place(x - 1e-5 * way)) / 4e-5;
    let at = place(x).clamp(DVec2::ZERO, size.as_dvec2() - 1.0);
    let low = at.floor();
    let f = at - low;
    let texel = |x: i32, y: i32| {
        let i = (low.as_ivec2() + IVec2::new(x, y)).min(size - 1);
        light[(i.x + i.y * size.x) as usize]
    };
    let [a, b, c, d] = [texel(0, 0), texel(1, 0), texel(0, 1), texel(1, 1)];
    let found = a.lerp(b, f.x).lerp(c.lerp(d, f.x), f.y);
    let slope = DVec2::new(
        (b.w - a.w) * (1.0 - f.y) + (d.w - c.w) * f.y,
        (c.w - a.w) * (1.0 - f.x) + (d.w - b.w) * f.x,
    );
    (found, slope.dot(half_way).clamp(-found.w, found.w))
}
