//! Cutting the volume open.

use glam::DVec3;

/// A half-space: points `x` with `normal . (x - point) >= 0` are kept.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// A point on the plane, world units.
    pub point: DVec3,
    /// Points into the kept side; any length but 0.
    pub normal: DVec3,
}

/// What of the volume is kept: the intersection of everything given. Outside is vacuum.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Clip {
    /// World-axis-aligned box (min, max) that is kept.
    pub bounds: Option<(DVec3, DVec3)>,
    /// A plane whose front side is kept.
    pub plane: Option<Plane>,
}
