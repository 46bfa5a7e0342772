//! What `ray_march.march` reads: uniform block and push constants.

use bytemuck::{Pod, Zeroable};

use crate::gpu::{BindingKind, StageLayout, shader};
use crate::scene::{RayMarchParams, Scene};
use crate::technique::TilePush;
use crate::technique::lights::{self, LightUniform, MAX_LIGHTS};
use crate::technique::medium::{MATERIAL, Medium, MediumPlan, with_material};
use crate::technique::view::{gradient_rows, vec4};

/// The march by the device's filter, and by loads of 8-bit, 16-bit and float texels. They differ in
/// how bindings 2 to 4, the medium, are read.
const fn march(shader: shader::Shader, bindings: &'static [BindingKind]) -> StageLayout {
    StageLayout {
        shader,
        bindings,
        push_bytes: size_of::<TilePush>() as u32,
    }
}

const fn bindings(medium: BindingKind) -> [BindingKind; 7 + MATERIAL.len()] {
    with_material([
        BindingKind::UniformBuffer,
        BindingKind::UniformBuffer,
        medium,
        medium,
        medium,
        BindingKind::SampledImage,
        BindingKind::StorageImage,
    ])
}

const FILTERED: &[BindingKind] = &bindings(BindingKind::SampledImage);
const LOADED: &[BindingKind] = &bindings(BindingKind::StorageImage);

/// The interfaces of the technique's stages, for the layout test.
pub const LAYOUTS: &[StageLayout] = &[
    march(shader::RAY_MARCH_MARCH, FILTERED),
    march(shader::RAY_MARCH_MARCH_R8, LOADED),
    march(shader::RAY_MARCH_MARCH_R16, LOADED),
    march(shader::RAY_MARCH_MARCH_R32F, LOADED),
];

/// The march that suits a medium.
pub(super) fn march_for(medium: &MediumPlan) -> StageLayout {
    LAYOUTS[medium.form()]
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
    pub lights: [LightUniform; MAX_LIGHTS],
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
        let ambient = lights::mean_environment(&scene.lights) * shading.ambient;
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
            specular: [
                shading.specular,
                shading.shininess,
                shading.merge_opacity,
                0.0,
            ],
            gradient: gradient_rows(scene, medium),
            lights: lights::uniforms(&scene.lights, grid.centre()),
        }
    }
}

/// Largest distance between samples, world units.
pub(super) fn step_length(scene: &Scene, params: &RayMarchParams) -> f64 {
    params.step * scene.volume.grid.spacing().min_element()
}
