//! What the stages read: jobs and push constants.

use bytemuck::{Pod, Zeroable};

use super::optics::decay;
use crate::gpu::{BindingKind, Specialization, StageLayout, shader};

use BindingKind::StorageBuffer;

/// Angles of one job, at most.
pub const ANGLES: usize = 256;
/// Albedos of one job, at most.
pub const MAX_ALBEDOS: usize = 8;
/// Paths that a workgroup follows side by side.
pub const LANES: u32 = 64;
/// Paths of an invocation and batch, a multiple of 6, the cycle of strategies.
pub const PATHS: u32 = 36;
/// Bytes that an invocation keeps between dispatches; only the shader reads them.
pub const LANE_BYTES: usize = 64;

/// Names of the stages, everywhere.
pub mod stage {
    /// Radiance out of spheres, one path for all angles to the light.
    pub const PREINTEGRATE: &str = "ambient_scattering.preintegrate";
    /// The same by one plain path an angle, to measure the former against.
    pub const PREINTEGRATE_PLAIN: &str = "ambient_scattering.preintegrate_plain";
}

const fn layout(shader: shader::Shader, bindings: &'static [BindingKind]) -> StageLayout {
    StageLayout {
        shader,
        bindings,
        push_bytes: size_of::<PreintegratePush>() as u32,
    }
}

/// The interfaces of `preintegrate` and of the plain estimator beside it.
pub const LAYOUTS: &[StageLayout] = &[
    layout(
        shader::AMBIENT_SCATTERING_PREINTEGRATE,
        &[StorageBuffer, StorageBuffer, StorageBuffer, StorageBuffer],
    ),
    layout(
        shader::AMBIENT_SCATTERING_PREINTEGRATE_PLAIN,
        &[StorageBuffer, StorageBuffer, StorageBuffer],
    ),
];

/// Specialisation constants of `preintegrate` for so many albedos.
#[must_use]
pub const fn constants(albedos: u32) -> [Specialization; 1] {
    [Specialization {
        id: 0,
        name: "ALBEDOS",
        value: albedos,
    }]
}

/// Push constants of both stages.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[allow(
    missing_docs,
    reason = "documented in glsl/ambient_scattering/sphere.glsl"
)]
pub struct PreintegratePush {
    pub seed: u32,
    pub job_count: u32,
    pub rounds: u32,
    pub resumed: u32,
    pub log2_albedo: [f32; MAX_ALBEDOS],
}

impl PreintegratePush {
    /// For at most [`MAX_ALBEDOS`] albedos, the largest first.
    #[must_use]
    pub fn new(seed: u32, job_count: u32, rounds: u32, albedos: &[f64]) -> Self {
        let mut log2_albedo = [0.0; MAX_ALBEDOS];
        for (to, albedo) in log2_albedo.iter_mut().zip(albedos) {
            // Its first power is 0 in 32 bits where the albedo is, its zeroth still 1.
            *to = albedo.log2().max(-200.0) as f32;
        }
        Self {
            seed,
            job_count,
            rounds,
            resumed: 0,
            log2_albedo,
        }
    }
}

/// A batch of a column's paths, std430.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[allow(
    missing_docs,
    reason = "documented in glsl/ambient_scattering/sphere.glsl"
)]
pub struct Job {
    pub sigma_t: f32,
    pub g: f32,
    pub key: u32,
    pub batch: u32,
    pub stretch: [f32; 2],
    pub decay: f32,
    pub theta_first: f32,
    pub theta_step: f32,
    pub even: f32,
    pub paths: u32,
}

impl Job {
    /// One batch of [`PATHS`] paths of a column, sent where a medium of `albedo` needs them. `angles` are the
    /// first and the step, radians.
    #[must_use]
    pub fn new(
        [sigma_t, g]: [f64; 2],
        albedo: f64,
        angles: [f64; 2],
        [key, batch]: [u32; 2],
    ) -> Self {
        // Paths that are led further, or kept for longer, cost more than they bring: measured.
        let stretch = decay(albedo.clamp(0.95, 0.99), g);
        Self {
            sigma_t: sigma_t as f32,
            g: g as f32,
            key,
            batch,
            stretch: [stretch as f32, (0.5 * (stretch + 0.95)) as f32],
            decay: (stretch * sigma_t) as f32,
            theta_first: angles[0] as f32,
            theta_step: angles[1] as f32,
            even: if g.abs() > 0.5 { 0.2 } else { 0.0 },
            paths: PATHS,
        }
    }
}
