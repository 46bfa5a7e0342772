//! The camera, image and clip block that shaders read (`glsl/shared/view.glsl`).

use bytemuck::{Pod, Zeroable};
use glam::{DVec3, DVec4};

use super::medium::Medium;
use crate::scene::{Projection, Scene};
use crate::volume::Grid;

/// The `View` block, std140. Positions are world units relative to the volume's centre.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[allow(missing_docs, reason = "documented once, in glsl/shared/view.glsl")]
pub struct ViewUniform {
    pub pivot: [f32; 4],
    pub pivot_right: [f32; 4],
    pub pivot_up: [f32; 4],
    pub forward: [f32; 4],
    pub ray_right: [f32; 4],
    pub ray_up: [f32; 4],
    pub texture_from_world: [[f32; 4]; 3],
    pub clip_min: [f32; 4],
    pub clip_max: [f32; 4],
    pub clip_plane: [f32; 4],
    pub background: [f32; 4],
    pub image: [u32; 4],
}

impl ViewUniform {
    /// Computed in f64, so that only small numbers are rounded.
    #[must_use]
    pub fn new(scene: &Scene) -> Self {
        let centre = scene.volume.grid.centre();
        let camera = &scene.camera;
        let frame = camera.frame();
        let aspect = f64::from(scene.image.width) / f64::from(scene.image.height);
        // Rays start beside the volume, not at a possibly very distant eye; the eye itself where it
        // is inside or beyond.
        let distance = frame.forward.dot(centre - camera.eye).max(0.0);
        let pivot = camera.eye + distance * frame.forward - centre;
        let (right, up) = (frame.right * aspect, frame.up);
        let (pivot_scale, ray_scale) = match camera.projection {
            Projection::Perspective { vfov_deg } => {
                let tan = (0.5 * vfov_deg).to_radians().tan();
                (distance * tan, tan)
            }
            Projection::Orthographic { height } => (0.5 * height, 0.0),
        };
        let inverse = scene.volume.grid.world_from_texture().inverse();
        let m = inverse.matrix3.transpose();
        let offset = inverse.transform_point3(centre);
        let (clip_min, clip_max) = scene.clip.bounds.unwrap_or((DVec3::ZERO, DVec3::ZERO));
        let clip_plane = scene.clip.plane.map_or(DVec4::ZERO, |p| {
            let n = p.normal.normalize_or(DVec3::Z);
            n.extend(n.dot(centre - p.point))
        });
        let image = &scene.image;
        Self {
            pivot: vec4(pivot, 0.0),
            pivot_right: vec4(right * pivot_scale, 0.0),
            pivot_up: vec4(up * pivot_scale, 0.0),
            forward: vec4(frame.forward, distance),
            ray_right: vec4(right * ray_scale, 0.0),
            ray_up: vec4(up * ray_scale, 0.0),
            texture_from_world: [
                vec4(m.x_axis, offset.x),
                vec4(m.y_axis, offset.y),
                vec4(m.z_axis, offset.z),
            ],
            clip_min: vec4(clip_min - centre, 0.0),
            clip_max: vec4(clip_max - centre, 0.0),
            clip_plane: clip_plane.as_vec4().to_array(),
            background: image.background.extend(0.0).to_array(),
            image: [image.width, image.height, image.samples_per_axis, 0],
        }
    }
}

/// Rows of the affine map from grid coordinates to world units about the volume's centre.
pub(super) fn grid_rows(grid: &Grid) -> [[f32; 4]; 3] {
    let rows = grid.world_from_index.matrix3.transpose();
    let offset = grid.world_from_index.translation - grid.centre();
    [
        vec4(rows.x_axis, offset.x),
        vec4(rows.y_axis, offset.y),
        vec4(rows.z_axis, offset.z),
    ]
}

/// World direction of a texel difference along x, y and z: the gradient of index coordinates, times
/// the smallest spacing and over the data range, so that its length is of the order of 1 whatever
/// the units.
pub(super) fn gradient_rows(scene: &Scene, medium: &Medium) -> [[f32; 4]; 3] {
    let grid = &scene.volume.grid;
    let index_from_world = grid.world_from_index.matrix3.inverse().transpose();
    let (encoding, table) = (&medium.plan.encoding, &medium.plan.table);
    // Of a height field differences are heights, and the medium rises to its full extinction over a ramp.
    let range = match &scene.volume.height_field {
        Some(field) => field.ramp,
        None => encoding.texture_value(table.max) - encoding.texture_value(table.min),
    };
    let scale = grid.spacing().min_element() / range.abs();
    [
        index_from_world.x_axis,
        index_from_world.y_axis,
        index_from_world.z_axis,
    ]
    .map(|row| vec4(row * scale, 0.0))
}

/// Four shader floats from a double-precision vector and its fourth component.
pub(super) fn vec4(v: DVec3, w: f64) -> [f32; 4] {
    v.extend(w).as_vec4().to_array()
}
