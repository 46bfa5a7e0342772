//! Rays of the CPU references, in f64.

use glam::{DVec2, DVec3};

use crate::scene::{Projection, Scene};

/// Origin, unit direction and the smallest `t` of the ray through a point of the image; `(0, 0)` is the top
/// left corner, `(1, 1)` the bottom right one.
pub(super) fn camera_ray(scene: &Scene, at: DVec2) -> (DVec3, DVec3, f64) {
    let camera = &scene.camera;
    let frame = camera.frame();
    let aspect = f64::from(scene.image.width) / f64::from(scene.image.height);
    let (x, y) = ((2.0 * at.x - 1.0) * aspect, 1.0 - 2.0 * at.y);
    match camera.projection {
        Projection::Perspective { vfov_deg } => {
            let tan = (0.5 * vfov_deg).to_radians().tan();
            let d = frame.forward + tan * (x * frame.right + y * frame.up);
            (camera.eye, d.normalize(), 0.0)
        }
        Projection::Orthographic { height } => {
            let offset = 0.5 * height * (x * frame.right + y * frame.up);
            (camera.eye + offset, frame.forward, 0.0)
        }
    }
}

/// Where the ray is inside box and clips.
pub(super) fn interval(scene: &Scene, o: DVec3, d: DVec3, t_min: f64) -> Option<(f64, f64)> {
    let texture_from_world = scene.volume.grid.world_from_texture().inverse();
    let (p, dp) = (
        texture_from_world.transform_point3(o),
        texture_from_world.transform_vector3(d),
    );
    let mut t = (t_min, f64::INFINITY);
    let mut keep = |height: f64, slope: f64| {
        // Kept where height + slope t >= 0.
        if slope > 0.0 {
            t.0 = t.0.max(-height / slope);
        } else if slope < 0.0 {
            t.1 = t.1.min(-height / slope);
        } else if height < 0.0 {
            t.1 = f64::NEG_INFINITY;
        }
    };
    for axis in 0..3 {
        keep(p[axis], dp[axis]);
        keep(1.0 - p[axis], -dp[axis]);
        if let Some((min, max)) = scene.clip.bounds {
            keep(o[axis] - min[axis], d[axis]);
            keep(max[axis] - o[axis], -d[axis]);
        }
    }
    if let Some(plane) = scene.clip.plane {
        keep(plane.normal.dot(o - plane.point), plane.normal.dot(d));
    }
    (t.0 < t.1).then_some(t)
}
