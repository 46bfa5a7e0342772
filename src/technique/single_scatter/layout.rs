//! What the stages of `single_scatter` read: uniform block and push constants.

use bytemuck::{Pod, Zeroable};
use glam::DVec3;

use super::SingleScatterPlan;
use crate::gpu::{BindingKind, StageLayout, shader};
use crate::scene::{Scene, SingleScatterParams};
use crate::technique::lights::{self, LightUniform, MAX_LIGHTS};
use crate::technique::medium::{MATERIAL, Medium, MediumPlan, with_material};
use crate::technique::view::{grid_rows, vec4};

use BindingKind::{SampledImage, StorageImage, UniformBuffer};

// By the device's filters, and by loads of 8-bit, 16-bit and float texels: they differ in how bindings
// 2 to 4, the medium, and 7, the cache, are read.
const fn cache_bindings(medium: BindingKind) -> [BindingKind; 7 + MATERIAL.len()] {
    with_material([
        UniformBuffer,
        UniformBuffer,
        medium,
        medium,
        medium,
        SampledImage,
        StorageImage,
    ])
}

const fn march_bindings(medium: BindingKind) -> [BindingKind; 9 + MATERIAL.len()] {
    with_material([
        UniformBuffer,
        UniformBuffer,
        medium,
        medium,
        medium,
        SampledImage,
        StorageImage,
        medium,
        SampledImage,
    ])
}

const CACHE_FILTERED: &[BindingKind] = &cache_bindings(SampledImage);
const CACHE_LOADED: &[BindingKind] = &cache_bindings(StorageImage);
const MARCH_FILTERED: &[BindingKind] = &march_bindings(SampledImage);
const MARCH_LOADED: &[BindingKind] = &march_bindings(StorageImage);

const fn light_cache(shader: shader::Shader, bindings: &'static [BindingKind]) -> StageLayout {
    StageLayout {
        shader,
        bindings,
        push_bytes: size_of::<CacheLightPush>() as u32,
    }
}

const fn march(shader: shader::Shader, bindings: &'static [BindingKind]) -> StageLayout {
    StageLayout {
        shader,
        bindings,
        push_bytes: size_of::<ScatterMarchPush>() as u32,
    }
}

/// The interfaces of the technique's stages, for the layout test: four of the light cache, four of the
/// march.
pub const LAYOUTS: &[StageLayout] = &[
    light_cache(shader::SINGLE_SCATTER_LIGHT_CACHE, CACHE_FILTERED),
    light_cache(shader::SINGLE_SCATTER_LIGHT_CACHE_R8, CACHE_LOADED),
    light_cache(shader::SINGLE_SCATTER_LIGHT_CACHE_R16, CACHE_LOADED),
    light_cache(shader::SINGLE_SCATTER_LIGHT_CACHE_R32F, CACHE_LOADED),
    march(shader::SINGLE_SCATTER_MARCH, MARCH_FILTERED),
    march(shader::SINGLE_SCATTER_MARCH_R8, MARCH_LOADED),
    march(shader::SINGLE_SCATTER_MARCH_R16, MARCH_LOADED),
    march(shader::SINGLE_SCATTER_MARCH_R32F, MARCH_LOADED),
];

/// The light cache that suits a medium.
pub(super) fn light_cache_for(medium: &MediumPlan) -> StageLayout {
    LAYOUTS[medium.form()]
}

/// The march that suits a medium.
pub(super) fn march_for(medium: &MediumPlan) -> StageLayout {
    LAYOUTS[4 + medium.form()]
}

/// Push constants of `single_scatter.light_cache`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[allow(
    missing_docs,
    reason = "documented in glsl/single_scatter/light_cache.glsl"
)]
pub struct CacheLightPush {
    pub light: u32,
    pub first_slice: u32,
    pub slice_count: u32,
}

/// Push constants of `single_scatter.march`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[allow(missing_docs, reason = "documented in glsl/single_scatter/march.glsl")]
pub struct ScatterMarchPush {
    pub first_tile: u32,
    pub tile_count: u32,
    pub sub_sample: u32,
    pub first_sample: u32,
    pub end_sample: u32,
}

/// The `Scatter` block, std140.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[allow(missing_docs, reason = "documented in glsl/single_scatter/shadow.glsl")]
pub struct ScatterUniform {
    pub table: [f32; 4],
    pub dims: [f32; 4],
    pub cell_scale: [f32; 4],
    pub node_first: [f32; 4],
    pub node_spacing: [f32; 4],
    pub node_last: [f32; 4],
    pub world_from_grid: [[f32; 4]; 3],
    pub lights: [LightUniform; MAX_LIGHTS],
}

impl ScatterUniform {
    /// Fills the block for a scene whose medium is on the device.
    #[must_use]
    pub fn new(
        scene: &Scene,
        params: &SingleScatterParams,
        plan: &SingleScatterPlan,
        medium: &Medium,
    ) -> Self {
        let (m, grid) = (&scene.medium, &scene.volume.grid);
        let (table_min, table_scale) = medium.table_mapping();
        let entries = medium.plan.table.entries as f32;
        let cell_size = medium.plan.cells.map_or(1, |c| c.size);
        let cells_per_texture = grid.dims.as_dvec3() / f64::from(cell_size);
        let tau_end = -(-params.early_termination).ln_1p();
        let (first, spacing, nodes) = match &plan.cache {
            Some(c) => (c.first, c.spacing, c.nodes.as_dvec3()),
            None => (DVec3::ZERO, DVec3::ONE, DVec3::ONE),
        };
        let shadow_step = params.shadow_step * grid.spacing().min_element();
        Self {
            table: [table_min, table_scale, entries, m.albedo as f32],
            dims: vec4(grid.dims.as_dvec3(), step_length(scene, params)),
            cell_scale: vec4(cells_per_texture, tau_end),
            node_first: vec4(first, shadow_step),
            node_spacing: vec4(spacing, m.phase_g),
            node_last: vec4(nodes - 1.0, m.emission),
            world_from_grid: grid_rows(grid),
            lights: lights::uniforms(&scene.lights, grid.centre()),
        }
    }
}

/// Largest distance between samples, world units.
pub(super) fn step_length(scene: &Scene, params: &SingleScatterParams) -> f64 {
    params.step * scene.volume.grid.spacing().min_element()
}
