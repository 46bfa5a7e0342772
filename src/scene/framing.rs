//! Automatic camera and lights: a three-quarter view that fills the image with what is visible.

use glam::{BVec3, DMat3, DVec2, DVec3, UVec3, Vec3};
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
    /// Up in the image unless the scene says otherwise: +z, or what is level when looking along z.
    pub up: DVec3,
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
        let to_eye = level * elevation.cos() + DVec3::Z * elevation.sin();
        let up = if parallel(to_eye, DVec3::Z) {
            -level * elevation.sin().signum()
        } else {
            DVec3::Z
        };
        Self { to_eye, up }
    }
}

/// Whether two directions are the same or opposite.
pub(super) fn parallel(a: DVec3, b: DVec3) -> bool {
    a.normalize_or_zero().cross(b.normalize_or_zero()).length() < 1e-6
}

/// Points, in world units, around all visible voxels inside the clips: the corners of the visible
/// rectangle of every slice looked at. The corners of the whole volume if nothing is visible.
#[must_use]
pub fn visible_outline(volume: &Volume, tf: &TransferFunction, clip: &Clip) -> Vec<DVec3> {
    let grid = &volume.grid;
    let stride = UVec3::new(
        grid.dims.x.div_ceil(LOOKS),
        grid.dims.y.div_ceil(LOOKS),
        grid.dims.z.div_ceil(LOOKS),
    );
    let stored = volume.stored_dims() - 1;
    let kept = |i: UVec3| {
        let x = grid.world_from_index.transform_point3(i.as_dvec3());
        clip.bounds
            .is_none_or(|(lo, hi)| x.cmpge(lo).all() && x.cmple(hi).all())
            && clip.plane.is_none_or(|p| p.normal.dot(x - p.point) >= 0.0)
    };
    let rectangle = |z: u32| {
        let (mut lo, mut hi) = (UVec3::MAX, UVec3::ZERO);
        for y in (0..grid.dims.y).step_by(stride.y as usize) {
            for x in (0..grid.dims.x).step_by(stride.x as usize) {
                let i = UVec3::new(x, y, z);
                let value = volume.value(grid.linear_index(i.min(stored)));
                let present = volume.share_at(i.as_dvec3()) > 0.0;
                if present && value.is_finite() && tf.evaluate(value).1 > VISIBLE && kept(i) {
                    (lo, hi) = (lo.min(i), hi.max(i));
                }
            }
        }
        lo.cmple(hi).all().then_some((lo, hi))
    };
    let slices: Vec<u32> = (0..grid.dims.z).step_by(stride.z as usize).collect();
    let rectangles: Vec<_> = slices.into_par_iter().filter_map(rectangle).collect();
    if rectangles.is_empty() {
        return grid.corners().to_vec();
    }
    // What lies between two looks may be visible too; voxels reach half a voxel further.
    let margin = stride.as_dvec3() - 0.5;
    let last = grid.dims.as_dvec3() - 0.5;
    let corners = |(lo, hi): (UVec3, UVec3)| {
        let lo = (lo.as_dvec3() - margin).max(DVec3::splat(-0.5));
        let hi = (hi.as_dvec3() + margin).min(last);
        (0..8).map(move |i| {
            let high = BVec3::new(i & 1 > 0, i & 2 > 0, i & 4 > 0);
            grid.world_from_index
                .transform_point3(DVec3::select(high, hi, lo))
        })
    };
    rectangles.into_iter().flat_map(corners).collect()
}

/// The middle of the axis-aligned box around points.
#[must_use]
pub fn centre(outline: &[DVec3]) -> DVec3 {
    let first = outline.first().copied().unwrap_or_default();
    let (lo, hi) = outline
        .iter()
        .fold((first, first), |(lo, hi), p| (lo.min(*p), hi.max(*p)));
    0.5 * lo + 0.5 * hi
}

/// What the automatic camera may choose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wish {
    /// World point at the image's centre; `None`: the outline is centred in the image.
    pub target: Option<DVec3>,
    /// Up in the image.
    pub up: DVec3,
    /// Perspective or orthographic.
    pub projection: Projection,
    /// Where the camera stands.
    pub direction: Direction,
    /// Image width over height.
    pub aspect: f64,
    /// Magnification over the frame that just fits.
    pub zoom: f64,
}

/// The camera that sees every point of the outline.
#[must_use]
pub fn frame(outline: &[DVec3], wish: &Wish) -> Camera {
    let target = wish.target.unwrap_or_else(|| centre(outline));
    let mut camera = fit(outline, target, wish);
    if wish.target.is_none() {
        // Perspective shifts the outline's middle: a few rounds bring it to the image's centre.
        for _ in 0..4 {
            let f = camera.frame();
            let shift = image_middle(outline, &camera);
            let depth = (camera.target - camera.eye).dot(f.forward);
            let target = camera.target + depth * (shift.x * f.right + shift.y * f.up);
            camera = fit(outline, target, wish);
        }
    }
    camera
}

/// The nearest camera towards `target` that sees every point.
fn fit(outline: &[DVec3], target: DVec3, wish: &Wish) -> Camera {
    let eye = target + wish.direction.to_eye;
    let toward = Camera {
        eye,
        target,
        up: wish.up,
        projection: wish.projection,
    };
    let f = toward.frame();
    let relative = outline.iter().map(|p| *p - target);
    let distance = match wish.projection {
        Projection::Perspective { vfov_deg } => {
            let tan = (0.5 * vfov_deg).to_radians().tan() * FILL * wish.zoom;
            // |p . up| <= tan (distance + p . forward), and likewise across.
            let needed = relative.map(|p| {
                let across = p.dot(f.right).abs() / wish.aspect;
                p.dot(f.up).abs().max(across) / tan - p.dot(f.forward)
            });
            needed.fold(0.0, f64::max)
        }
        Projection::Orthographic { .. } => relative.map(|p| 2.0 * p.length()).fold(0.0, f64::max),
    };
    let distance = if distance > 0.0 { distance } else { 1.0 };
    Camera {
        eye: target + wish.direction.to_eye * distance,
        ..toward
    }
}

/// Middle of the outline's picture, as tangents to the image's right and top.
fn image_middle(outline: &[DVec3], camera: &Camera) -> DVec2 {
    let f = camera.frame();
    let eye_distance = (camera.target - camera.eye).dot(f.forward);
    let project = |p: &DVec3| {
        let d = *p - camera.eye;
        let depth = match camera.projection {
            Projection::Perspective { .. } => d.dot(f.forward).max(1e-6 * eye_distance),
            Projection::Orthographic { .. } => eye_distance,
        };
        DVec2::new(d.dot(f.right), d.dot(f.up)) / depth
    };
    let (mut lo, mut hi) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    for p in outline.iter().map(project) {
        (lo, hi) = (lo.min(p), hi.max(p));
    }
    0.5 * (lo + hi)
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
