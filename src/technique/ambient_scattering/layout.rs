//! What the stages of `ambient_scattering` read: uniform block and push constants.

use bytemuck::{Pod, Zeroable};
use glam::DVec3;

use super::lookup::{Scalars, per_octave};
use super::{AmbientScatteringPlan, choice};
use crate::gpu::{BindingKind, StageLayout, shader};
use crate::scene::{AmbientScatteringParams, Scene};
use crate::technique::TilePush;
use crate::technique::lights::{self, LightUniform, MAX_LIGHTS};
use crate::technique::medium::{MATERIAL, Medium, MediumPlan, with_material};
use crate::technique::view::{gradient_rows, grid_rows, vec4};

use BindingKind::{SampledImage, StorageImage, UniformBuffer};

/// g of light that comes from about the light's direction, as a share of the phase function's: it is spread
/// over the half sphere, whose mean cosine is a half.
pub(super) const SPREAD_COSINE: f64 = 0.5;

const fn march_bindings(medium: BindingKind) -> [BindingKind; 14 + MATERIAL.len()] {
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
        SampledImage,
        SampledImage,
        SampledImage,
        SampledImage,
        SampledImage,
    ])
}

const FILTERED: &[BindingKind] = &march_bindings(SampledImage);
const LOADED: &[BindingKind] = &march_bindings(StorageImage);

const fn march(shader: shader::Shader, bindings: &'static [BindingKind]) -> StageLayout {
    StageLayout {
        shader,
        bindings,
        push_bytes: size_of::<TilePush>() as u32,
    }
}

/// The stage that fills the cache.
pub(super) const RADIANCE_CACHE: StageLayout = StageLayout {
    shader: shader::AMBIENT_SCATTERING_RADIANCE_CACHE,
    bindings: &[
        UniformBuffer,
        UniformBuffer,
        SampledImage,
        SampledImage,
        StorageImage,
    ],
    push_bytes: size_of::<TubePush>() as u32,
};

/// The stage in which the cache's nodes look.
pub(super) const GATHER: StageLayout = StageLayout {
    shader: shader::AMBIENT_SCATTERING_GATHER,
    bindings: &[
        UniformBuffer,
        UniformBuffer,
        SampledImage,
        SampledImage,
        SampledImage,
        SampledImage,
        StorageImage,
    ],
    push_bytes: size_of::<GatherPush>() as u32,
};

/// The interfaces of the technique's stages, for the layout test: four of the march, then the cache and its nodes' looks.
pub const LAYOUTS: &[StageLayout] = &[
    march(shader::AMBIENT_SCATTERING_MARCH, FILTERED),
    march(shader::AMBIENT_SCATTERING_MARCH_R8, LOADED),
    march(shader::AMBIENT_SCATTERING_MARCH_R16, LOADED),
    march(shader::AMBIENT_SCATTERING_MARCH_R32F, LOADED),
    RADIANCE_CACHE,
    GATHER,
];

/// The march that suits a medium.
pub(super) fn march_for(medium: &MediumPlan) -> StageLayout {
    LAYOUTS[medium.form()]
}

/// Push constants of `ambient_scattering.radiance_cache`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[allow(
    missing_docs,
    reason = "documented in glsl/ambient_scattering/radiance_cache.comp"
)]
pub struct TubePush {
    pub light: u32,
    pub first_slice: u32,
    pub slice_count: u32,
}

/// Push constants of `ambient_scattering.gather`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[allow(
    missing_docs,
    reason = "documented in glsl/ambient_scattering/gather.comp"
)]
pub struct GatherPush {
    pub first_slice: u32,
    pub slice_count: u32,
}

/// The `Ambient` block, std140.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[allow(
    missing_docs,
    reason = "documented in glsl/ambient_scattering/tube.glsl"
)]
pub struct AmbientUniform {
    pub table: [f32; 4],
    pub dims: [f32; 4],
    pub cell_scale: [f32; 4],
    pub node_first: [f32; 4],
    pub node_spacing: [f32; 4],
    pub node_last: [f32; 4],
    pub extinction_scale: [f32; 4],
    pub occlusion_scale: [f32; 4],
    pub environment: [f32; 4],
    pub specular: [f32; 4],
    pub dimming_ratio: [f32; 4],
    pub gradient: [[f32; 4]; 3],
    pub world_from_grid: [[f32; 4]; 3],
    pub lights: [LightUniform; MAX_LIGHTS],
}

impl AmbientUniform {
    /// Fills the block for a scene whose medium is on the device.
    #[must_use]
    pub fn new(
        scene: &Scene,
        params: &AmbientScatteringParams,
        plan: &AmbientScatteringPlan,
        medium: &Medium,
        tables: &Scalars,
    ) -> Self {
        let (m, grid) = (&scene.medium, &scene.volume.grid);
        let (table_min, table_scale) = medium.table_mapping();
        let entries = medium.plan.table.entries as f32;
        let cell_size = medium.plan.cells.map_or(1, |c| c.size);
        let cells_per_texture = grid.dims.as_dvec3() / f64::from(cell_size);
        let tau_end = -(-params.early_termination).ln_1p();
        let (first, spacing, nodes) = match &plan.cache {
            Some(c) => (c.nodes.first, c.nodes.spacing, c.nodes.count.as_dvec3()),
            None => (DVec3::ZERO, DVec3::ONE, DVec3::ONE),
        };
        let extinction_scale = plan.extinction.as_ref().map_or(DVec3::ONE, |f| f.scale);
        let occlusion_scale = plan.occlusion.as_ref().map_or(DVec3::ONE, |f| f.scale);
        let environment = lights::mean_environment(&scene.lights);
        Self {
            table: [table_min, table_scale, entries, m.albedo as f32],
            dims: vec4(grid.dims.as_dvec3(), step_length(scene, params)),
            cell_scale: vec4(cells_per_texture, tau_end),
            node_first: vec4(first, plan.radius),
            node_spacing: vec4(spacing, m.phase_g),
            node_last: vec4(nodes - 1.0, m.emission),
            extinction_scale: vec4(extinction_scale, SPREAD_COSINE * m.phase_g),
            occlusion_scale: vec4(occlusion_scale, tables.vacuum),
            environment: environment.extend(per_octave() as f32).to_array(),
            specular: [params.specular, params.shininess, 0.0, 0.0],
            dimming_ratio: vec4(tables.dimming_ratio, 0.0),
            gradient: gradient_rows(scene, medium),
            world_from_grid: grid_rows(grid),
            lights: lights::uniforms(&scene.lights, grid.centre()),
        }
    }
}

/// Largest distance between samples, world units: where voxels are coarse beside the radius, half of that.
pub(super) fn step_length(scene: &Scene, params: &AmbientScatteringParams) -> f64 {
    let step = params.step * scene.volume.grid.spacing().min_element();
    step.min(0.5 * params.step.max(1.0) * choice::radius(scene, params.radius))
}
