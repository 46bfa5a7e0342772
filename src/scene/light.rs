//! Light sources.

use std::sync::Arc;

use glam::{DMat3, DQuat, DVec3, Vec3};
use serde::{Deserialize, Serialize};

use super::LatLongMap;

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
#[derive(Clone, Debug, PartialEq)]
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
    /// Radiance from a picture of the whole sphere.
    EnvironmentMap {
        /// The picture.
        map: Arc<LatLongMap>,
        /// Factor on its radiance.
        scale: Vec3,
        /// World direction of the picture's top; unit length.
        up: DVec3,
        /// Degrees by which it is turned about `up`, counterclockwise from above.
        rotation_deg: f64,
    },
}

/// Turns the map space of a [`LatLongMap`], where +y is up, into the world: the shortest way to `up`,
/// after a turn about +y.
#[must_use]
pub fn world_from_map(up: DVec3, rotation_deg: f64) -> DMat3 {
    let turn = DQuat::from_rotation_y(rotation_deg.to_radians());
    DMat3::from_quat(DQuat::from_rotation_arc(DVec3::Y, up) * turn)
}
