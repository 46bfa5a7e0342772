//! Cameras.

use glam::DVec3;

/// How rays leave the eye.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// All rays through the eye.
    Perspective {
        /// Full vertical angle, degrees, in (0, 180).
        vfov_deg: f64,
    },
    /// All rays parallel to the viewing direction.
    Orthographic {
        /// Full vertical extent of the image, world units, > 0.
        height: f64,
    },
}

/// A pinhole or parallel camera in world units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Position of the eye.
    pub eye: DVec3,
    /// Any point on the optical axis in front of the eye.
    pub target: DVec3,
    /// A direction that is up in the image; not parallel to the optical axis.
    pub up: DVec3,
    /// Perspective or orthographic.
    pub projection: Projection,
}

/// Right-handed camera frame: `right` and `up` span the image, rays go along `forward`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Unit vector to the image's right.
    pub right: DVec3,
    /// Unit vector to the image's top.
    pub up: DVec3,
    /// Unit viewing direction.
    pub forward: DVec3,
}

impl Camera {
    /// The camera's orthonormal frame; where `up` is parallel to the view, any perpendicular is up.
    #[must_use]
    pub fn frame(&self) -> Frame {
        let forward = (self.target - self.eye).normalize_or(-DVec3::Z);
        let side = forward.cross(self.up.normalize_or(DVec3::Z));
        let right = if side.length() > 1e-9 {
            side.normalize()
        } else {
            forward.any_orthonormal_vector()
        };
        Frame {
            right,
            up: right.cross(forward),
            forward,
        }
    }

    /// The same camera turned about `target` by `degrees` around `up` (positive: eastwards, the eye
    /// moves to the image's right).
    #[must_use]
    pub fn orbit(&self, degrees: f64) -> Self {
        let axis = self.up.normalize_or(DVec3::Z);
        let turn = glam::DQuat::from_axis_angle(axis, degrees.to_radians());
        Self {
            eye: self.target + turn * (self.eye - self.target),
            ..*self
        }
    }
}
