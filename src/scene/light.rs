//! Light sources.

use glam::{DVec3, Vec3};
use serde::{Deserialize, Serialize};

/// How a point light weakens with distance.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum Falloff {
    /// Irradiance is `intensity / distance^2` (physical).
    #[default]
    InverseSquare,
    /// Irradiance is `intensity` everywhere (the look of several papers).
    None,
}

/// A light source, linear RGB.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Light {
    /// Parallel light.
    Directional {
        /// The direction the light travels; any length but 0.
        direction: DVec3,
        /// Irradiance on a plane that faces the light.
        irradiance: Vec3,
    },
    /// An isotropic point source.
    Point {
        /// World position.
        position: DVec3,
        /// Radiant intensity, W/sr.
        intensity: Vec3,
        /// How it weakens with distance.
        falloff: Falloff,
    },
    /// The same radiance from every direction.
    Environment {
        /// Radiance.
        radiance: Vec3,
    },
}
