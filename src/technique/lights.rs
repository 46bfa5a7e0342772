//! Lights as shaders read them (`glsl/shared/lights.glsl`).

use bytemuck::{Pod, Zeroable};
use glam::{DVec3, Vec3};

use super::PlanError;
use super::view::vec4;
use crate::scene::{Falloff, Light, Scene};

/// Most directional and point lights that a shader takes.
pub const MAX_LIGHTS: usize = 32;

/// One light of a uniform block.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[allow(missing_docs, reason = "documented in glsl/shared/lights.glsl")]
pub struct LightUniform {
    pub place: [f32; 4],
    pub irradiance: [f32; 4],
}

/// Number of directional and point lights, and whether there are point lights.
///
/// # Errors
/// There are more than `technique` takes.
pub(super) fn count(scene: &Scene, technique: &str) -> Result<(u32, bool), PlanError> {
    let is_lamp = |l: &&Light| matches!(l, Light::Directional { .. } | Light::Point { .. });
    let count = scene.lights.iter().filter(is_lamp).count();
    if count > MAX_LIGHTS {
        return Err(PlanError::Limit {
            what: "lights".to_owned(),
            found: format!("{count} directional and point lights"),
            limit: format!("{technique} takes {MAX_LIGHTS}"),
            fix: "remove some".to_owned(),
        });
    }
    let is_point = |l: &Light| matches!(l, Light::Point { .. });
    let count = u32::try_from(count).unwrap_or(0);
    Ok((count, scene.lights.iter().any(is_point)))
}

/// Whether any light weakens with distance.
pub(super) fn weaken(scene: &Scene) -> bool {
    let weakens = |l: &Light| {
        matches!(
            l,
            Light::Point {
                falloff: Falloff::InverseSquare,
                ..
            }
        )
    };
    scene.lights.iter().any(weakens)
}

/// Sum of the constant environments' radiance.
pub(super) fn environment(lights: &[Light]) -> Vec3 {
    let radiance = |l: &Light| match l {
        Light::Environment { radiance } => *radiance,
        _ => Vec3::ZERO,
    };
    lights.iter().map(radiance).sum()
}

/// Radiance of all environments, mean over all directions.
pub(super) fn mean_environment(lights: &[Light]) -> Vec3 {
    let mean = |l: &Light| match l {
        Light::EnvironmentMap { map, scale, .. } => *scale * map.mean().as_vec3(),
        _ => Vec3::ZERO,
    };
    environment(lights) + lights.iter().map(mean).sum::<Vec3>()
}

/// Directional and point lights, relative to the volume's centre; unused places are zero.
pub(super) fn uniforms(lights: &[Light], centre: DVec3) -> [LightUniform; MAX_LIGHTS] {
    let local = |light: &Light| match *light {
        Light::Directional {
            direction,
            irradiance,
        } => Some(LightUniform {
            place: vec4(-direction.normalize_or(-DVec3::Z), 0.0),
            irradiance: irradiance.extend(0.0).to_array(),
        }),
        Light::Point {
            position,
            intensity,
            falloff,
        } => Some(LightUniform {
            place: vec4(position - centre, 1.0),
            irradiance: intensity
                .extend(if falloff == Falloff::InverseSquare {
                    1.0
                } else {
                    0.0
                })
                .to_array(),
        }),
        Light::Environment { .. } | Light::EnvironmentMap { .. } => None,
    };
    let mut uniforms = [LightUniform::default(); MAX_LIGHTS];
    for (to, light) in uniforms.iter_mut().zip(lights.iter().filter_map(local)) {
        *to = light;
    }
    uniforms
}
