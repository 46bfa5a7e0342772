//! What `ray_march.march` reads: uniform block and push constants.

use bytemuck::{Pod, Zeroable};
use glam::{DVec3, Vec3};

use crate::gpu::{BindingKind, StageLayout, shader};
use crate::scene::{Falloff, Light, RayMarchParams, Scene};
use crate::technique::medium::Medium;
use crate::technique::view::vec4;

/// Most lights the shader takes.
pub const MAX_LIGHTS: usize = 32;

pub(super) const MARCH: StageLayout = StageLayout {
    shader: shader::RAY_MARCH_MARCH,
    bindings: &[
        BindingKind::UniformBuffer,
        BindingKind::UniformBuffer,
        BindingKind::SampledImage,
        BindingKind::SampledImage,
        BindingKind::SampledImage,
        BindingKind::SampledImage,
        BindingKind::StorageImage,
    ],
    push_bytes: size_of::<MarchPush>() as u32,
};

/// The interfaces of the technique's stages, for the layout test.
pub const LAYOUTS: &[StageLayout] = &[MARCH];

/// Push constants of `ray_march.march`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[allow(missing_docs, reason = "documented in glsl/ray_march/march.comp")]
pub struct MarchPush {
    pub first_tile: u32,
    pub tile_count: u32,
    pub sub_sample: u32,
}

/// One light in [`MarchUniform`].
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[allow(missing_docs, reason = "documented in glsl/ray_march/march.comp")]
pub struct MarchLight {
    pub place: [f32; 4],
    pub irradiance: [f32; 4],
}

/// The `March` block, std140.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[allow(missing_docs, reason = "documented in glsl/ray_march/march.comp")]
pub struct MarchUniform {
    pub table: [f32; 4],
    pub dims: [f32; 4],
    pub cell_scale: [f32; 4],
    pub ambient: [f32; 4],
    pub specular: [f32; 4],
    pub gradient: [[f32; 4]; 3],
    pub lights: [MarchLight; MAX_LIGHTS],
}

impl MarchUniform {
    /// Fills the block for a scene whose medium is on the device.
    #[must_use]
    pub fn new(scene: &Scene, params: &RayMarchParams, medium: &Medium) -> Self {
        let grid = &scene.volume.grid;
        let (table_min, table_scale) = medium.table_mapping();
        let cell_size = medium.plan.cells.map_or(1, |c| c.size);
        let cells_per_texture = grid.dims.as_dvec3() / f64::from(cell_size);
        let shading = params.shading.unwrap_or_default();
        let ambient = environment(&scene.lights) * shading.ambient;
        let mut lights = [MarchLight::default(); MAX_LIGHTS];
        for (to, light) in lights
            .iter_mut()
            .zip(local_lights(&scene.lights, grid.centre()))
        {
            *to = light;
        }
        Self {
            table: [
                table_min,
                table_scale,
                medium.plan.table.entries as f32,
                0.0,
            ],
            dims: vec4(grid.dims.as_dvec3(), step_length(scene, params)),
            cell_scale: vec4(cells_per_texture, -(-params.early_termination).ln_1p()),
            ambient: ambient.extend(shading.diffuse).to_array(),
            specular: [shading.specular, shading.shininess, 0.0, 0.0],
            gradient: gradient_rows(scene, medium),
            lights,
        }
    }
}

/// World direction of a texel difference along x, y and z: the gradient of index coordinates, times
/// the smallest spacing and over the data range, so that its length is of the order of 1 whatever
/// the units.
fn gradient_rows(scene: &Scene, medium: &Medium) -> [[f32; 4]; 3] {
    let grid = &scene.volume.grid;
    let index_from_world = grid.world_from_index.matrix3.inverse().transpose();
    let (encoding, table) = (&medium.plan.encoding, &medium.plan.table);
    let range = encoding.texture_value(table.max) - encoding.texture_value(table.min);
    let scale = grid.spacing().min_element() / range.abs();
    [
        index_from_world.x_axis,
        index_from_world.y_axis,
        index_from_world.z_axis,
    ]
    .map(|row| vec4(row * scale, 0.0))
}

/// Largest distance between samples, world units.
pub(super) fn step_length(scene: &Scene, params: &RayMarchParams) -> f64 {
    params.step * scene.volume.grid.spacing().min_element()
}

/// Sum of the constant environments' radiance.
pub(super) fn environment(lights: &[Light]) -> Vec3 {
    lights
        .iter()
        .map(|l| {
            if let Light::Environment { radiance } = l {
                *radiance
            } else {
                Vec3::ZERO
            }
        })
        .sum()
}

/// Directional and point lights, relative to the volume's centre.
pub(super) fn local_lights(lights: &[Light], centre: DVec3) -> Vec<MarchLight> {
    let local = |light: &Light| match *light {
        Light::Directional {
            direction,
            irradiance,
        } => Some(MarchLight {
            place: vec4(-direction.normalize_or(-DVec3::Z), 0.0),
            irradiance: irradiance.extend(0.0).to_array(),
        }),
        Light::Point {
            position,
            intensity,
            falloff,
        } => Some(MarchLight {
            place: vec4(position - centre, 1.0),
            irradiance: intensity
                .extend(if falloff == Falloff::InverseSquare {
                    1.0
                } else {
                    0.0
                })
                .to_array(),
        }),
        Light::Environment { .. } => None,
    };
    lights.iter().filter_map(local).collect()
}
