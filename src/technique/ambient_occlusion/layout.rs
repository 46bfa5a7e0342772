//! What `ambient_occlusion.march` reads: uniform block and push constants.

use bytemuck::{Pod, Zeroable};
use glam::DVec3;

use super::AmbientOcclusionPlan;
use crate::gpu::{BindingKind, StageLayout, shader};
use crate::scene::{AmbientOcclusionParams, Scene};
use crate::technique::TilePush;
use crate::technique::lights;
use crate::technique::medium::{MATERIAL, Medium, MediumPlan, with_material};
use crate::technique::view::vec4;

use BindingKind::{SampledImage, StorageImage, UniformBuffer};

// By the device's filters, and by loads of 8-bit, 16-bit and float texels: they differ in how bindings
// 2 to 4, the medium, are read.
const fn bindings(medium: BindingKind) -> [BindingKind; 9 + MATERIAL.len()] {
    with_material([
        UniformBuffer,
        UniformBuffer,
        medium,
        medium,
        medium,
        SampledImage,
        StorageImage,
        SampledImage,
        SampledImage,
    ])
}

const FILTERED: &[BindingKind] = &bindings(SampledImage);
const LOADED: &[BindingKind] = &bindings(StorageImage);

const fn march(shader: shader::Shader, bindings: &'static [BindingKind]) -> StageLayout {
    StageLayout {
        shader,
        bindings,
        push_bytes: size_of::<TilePush>() as u32,
    }
}

/// The interfaces of the technique's stages, for the layout test.
pub const LAYOUTS: &[StageLayout] = &[
    march(shader::AMBIENT_OCCLUSION_MARCH, FILTERED),
    march(shader::AMBIENT_OCCLUSION_MARCH_R8, LOADED),
    march(shader::AMBIENT_OCCLUSION_MARCH_R16, LOADED),
    march(shader::AMBIENT_OCCLUSION_MARCH_R32F, LOADED),
];

/// The march that suits a medium.
pub(super) fn march_for(medium: &MediumPlan) -> StageLayout {
    LAYOUTS[medium.form()]
}

/// The `Occluded` block, std140.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[allow(
    missing_docs,
    reason = "documented in glsl/ambient_occlusion/march.glsl"
)]
pub struct OccludedUniform {
    pub table: [f32; 4],
    pub dims: [f32; 4],
    pub cell_scale: [f32; 4],
    pub occlusion_scale: [f32; 4],
    pub environment: [f32; 4],
}

impl OccludedUniform {
    /// Fills the block for a scene whose medium is on the device.
    #[must_use]
    pub fn new(
        scene: &Scene,
        params: &AmbientOcclusionParams,
        plan: &AmbientOcclusionPlan,
        medium: &Medium,
    ) -> Self {
        let (m, grid) = (&scene.medium, &scene.volume.grid);
        let (table_min, table_scale) = medium.table_mapping();
        let entries = medium.plan.table.entries as f32;
        let cell_size = medium.plan.cells.map_or(1, |c| c.size);
        let cells_per_texture = grid.dims.as_dvec3() / f64::from(cell_size);
        let tau_end = -(-params.early_termination).ln_1p();
        let scale = plan.occlusion.as_ref().map_or(DVec3::ONE, |f| f.scale);
        let environment = lights::mean_environment(&scene.lights).as_dvec3();
        Self {
            table: [table_min, table_scale, entries, 0.0],
            dims: vec4(grid.dims.as_dvec3(), step_length(scene, params)),
            cell_scale: vec4(cells_per_texture, tau_end),
            occlusion_scale: vec4(scale, 0.0),
            environment: vec4(m.albedo * environment, m.emission),
        }
    }
}

/// Largest distance between samples, world units.
pub(super) fn step_length(scene: &Scene, params: &AmbientOcclusionParams) -> f64 {
    params.step * scene.volume.grid.spacing().min_element()
}
