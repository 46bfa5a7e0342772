//! Automatic camera and lights: a three-quarter view that fills the image with what is visible.

use glam::{DMat3, DVec3, UVec3, Vec3};
use rayon::prelude::*;

use super::{Camera, Clip, Light, Projection, TransferFunction};
use crate::volume::{Space, Volume};

/// Vertical angle of the automatic camera.
pub const VFOV_DEG: f64 = 30.0;

/// Share of the image's smaller side that the visible box may fill.
const FILL: f64 = 0.92;

/// Opacity a unit distance above which a voxel counts as visible.
const VISIBLE: f64 = 0.01;

/// Voxels looked at along each axis.
const LOOKS: u32 = 128;

/// Where the camera stands, as seen from the target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Direction {
    /// Unit vector from the target to the eye.
    pub to_eye: DVec3,
}

impl Direction {
    /// `azimuth_deg` from the front towards the image's right, `elevation_deg` above the horizon.
    /// The front is anterior (+y) for patients, who then face the camera, and -y for other data.
    #[must_use]
    pub fn new(space: Space, azimuth_deg: Option<f64>, elevation_deg: Option<f64>) -> Self {
        let front = match space {
            Space::PatientRas => DVec3::Y,
            Space::Unspecified => -DVec3::Y,
        };
        let azimuth = azimuth_deg.unwrap_or(30.0).to_radians();
        let elevation = elevation_deg.unwrap_or(15.0).to_radians();
        let level = DMat3::from_rotation_z(azimuth) * front;
        Self {
            to_eye: level * elevation.cos() + DVec3::Z * elevation.sin(),
        }
    }
}

/// Corners, in world units, of the box around all visible voxels inside the clip box; of the whole
/// volume if nothing is visible.
#[must_use]
pub fn visible_corners(volume: &Volume, tf: &TransferFunction, clip: &Clip) -> [DVec3; 8] {
    let grid = &volume.grid;
    let stride = UVec3::new(
        grid.dims.x.div_ceil(LOOKS),
        grid.dims.y.div_ceil(LOOKS),
        grid.dims.z.div_ceil(LOOKS),
    );
    let kept = |i: UVec3| {
        let x = grid.world_from_index.transform_point3(i.as_dvec3());
        clip.bounds
            .is_none_or(|(lo, hi)| x.cmpge(lo).all() && x.cmple(hi).all())
            && clip.plane.is_none_or(|p| p.normal.dot(x - p.point) >= 0.0)
    };
    let slice = |z: u32| {
        let mut bounds = (UVec3::MAX, UVec3::ZERO);
        for y in (0..grid.dims.y).step_by(stride.y as usize) {
            for x in (0..grid.dims.x).step_by(stride.x as usize) {
                let i = UVec3::new(x, y, z);
                let value = volume.value(grid.linear_index(i));
                if value.is_finite() && tf.evaluate(value).1 > VISIBLE && kept(i) {
                    bounds = (bounds.0.min(i), bounds.1.max(i));
                }
            }
        }
        bounds
    };
    let slices: Vec<u32> = (0..grid.dims.z).step_by(stride.z as usize).collect();
    let (lo, hi) = slices.into_par_iter().map(slice).reduce(
        || (UVec3::MAX, UVec3::ZERO),
        |a, b| (a.0.min(b.0), a.1.max(b.1)),
    );
    if lo.cmpgt(hi).any() {
        return grid.corners();
    }
    // What lies between two looks may be visible too; voxels reach half a voxel further.
    let lo = lo.as_dvec3() - stride.as_dvec3() + 0.5;
    let hi = hi.as_dvec3() + stride.as_dvec3() - 0.5;
    let (lo, hi) = (
        lo.max(DVec3::splat(-0.5)),
        hi.min(grid.dims.as_dvec3() - 0.5),
    );
    std::array::from_fn(|i| {
        let high = glam::BVec3::new(i & 1 > 0, i & 2 > 0, i & 4 > 0);
        grid.world_from_index
            .transform_point3(DVec3::select(high, hi, lo))
    })
}

/// The middle of a box.
#[must_use]
pub fn centre(corners: &[DVec3; 8]) -> DVec3 {
    0.5 * (corners[0] + corners[7])
}

/// The camera that sees every corner, in the given direction from the target.
#[must_use]
pub fn frame(
    corners: &[DVec3; 8],
    target: DVec3,
    up: DVec3,
    projection: Projection,
    direction: Direction,
    aspect: f64,
    zoom: f64,
) -> Camera {
    let toward = Camera {
        eye: target + direction.to_eye,
        target,
        up,
        projection,
    };
    let f = toward.frame();
    let relative = corners.iter().map(|c| *c - target);
    let distance = match projection {
        Projection::Perspective { vfov_deg } => {
            let tan = (0.5 * vfov_deg).to_radians().tan() * FILL / zoom;
            // |c . up| <= tan (distance + c . forward), and likewise across.
            let needed = relative.map(|c| {
                let across = c.dot(f.right).abs() / aspect;
                c.dot(f.up).abs().max(across) / tan - c.dot(f.forward)
            });
            needed.fold(0.0, f64::max)
        }
        Projection::Orthographic { .. } => relative.map(|c| 2.0 * c.length()).fold(0.0, f64::max),
    };
    Camera {
        eye: target + direction.to_eye * distance.max(f64::MIN_POSITIVE),
        ..toward
    }
}

/// A key light from the camera's upper left, 45 degrees aside and 40 up, and a faint environment.
/// A white diffuse surface that faces the key has radiance 1.
#[must_use]
pub fn lights(camera: &Camera) -> Vec<Light> {
    let f = camera.frame();
    let (aside, up) = (45f64.to_radians(), 40f64.to_radians());
    let level = -f.forward * aside.cos() - f.right * aside.sin();
    let to_light = level * up.cos() + f.up * up.sin();
    vec![
        Light::Directional {
            direction: -to_light,
            irradiance: Vec3::splat(std::f32::consts::PI),
        },
        Light::Environment {
            radiance: Vec3::splat(0.15),
        },
    ]
}
