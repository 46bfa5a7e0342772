//! What `path_trace.trace` reads: uniform block and push constants.

use bytemuck::{Pod, Zeroable};

use glam::{DMat3, Vec3};

use super::environment::{Environment, extents};
use super::leaves;
use crate::gpu::{BindingKind, StageLayout, shader};
use crate::scene::Scene;
use crate::technique::lights::{self, LightUniform, MAX_LIGHTS};
use crate::technique::medium::{MATERIAL, Medium, MediumPlan, with_material};
use crate::technique::view::vec4;

/// The walk by the device's filters, and by loads of 8-bit, 16-bit and float texels. They differ in
/// how bindings 2 and 3, the medium, are read.
const fn trace(shader: shader::Shader, bindings: &'static [BindingKind]) -> StageLayout {
    StageLayout {
        shader,
        bindings,
        push_bytes: size_of::<TracePush>() as u32,
    }
}

const fn bindings(medium: BindingKind) -> [BindingKind; 13 + MATERIAL.len()] {
    with_material([
        BindingKind::UniformBuffer,
        BindingKind::UniformBuffer,
        medium,
        medium,
        BindingKind::StorageImage,
        BindingKind::SampledImage,
        BindingKind::StorageImage,
        BindingKind::StorageImage,
        BindingKind::StorageImage,
        BindingKind::StorageImage,
        BindingKind::SampledImage,
        BindingKind::SampledImage,
        BindingKind::SampledImage,
    ])
}

const FILTERED: &[BindingKind] = &bindings(BindingKind::SampledImage);
const LOADED: &[BindingKind] = &bindings(BindingKind::StorageImage);

/// The interfaces of the technique's stages, for the layout test.
pub const LAYOUTS: &[StageLayout] = &[
    trace(shader::PATH_TRACE_TRACE, FILTERED),
    trace(shader::PATH_TRACE_TRACE_R8, LOADED),
    trace(shader::PATH_TRACE_TRACE_R16, LOADED),
    trace(shader::PATH_TRACE_TRACE_R32F, LOADED),
];

/// The walk that suits a medium.
pub(super) fn trace_for(medium: &MediumPlan) -> StageLayout {
    LAYOUTS[medium.form()]
}

/// Push constants of `path_trace.trace`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[allow(missing_docs, reason = "documented in glsl/path_trace/trace.glsl")]
pub struct TracePush {
    pub rounds: u32,
    pub samples: u32,
    pub seed: u32,
    pub first: u32,
}

/// The `Trace` block, std140.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[allow(missing_docs, reason = "documented in glsl/path_trace/trace.glsl")]
pub struct TraceUniform {
    pub table: [f32; 4],
    pub dims: [f32; 4],
    pub bounds: [f32; 4],
    pub straight: [f32; 4],
    pub line: [f32; 4],
    pub environment: [f32; 4],
    pub grid_from_world: [[f32; 4]; 3],
    pub map_from_world: [[f32; 4]; 3],
    pub map_scale: [f32; 4],
    pub lights: [LightUniform; MAX_LIGHTS],
}

impl TraceUniform {
    /// Fills the block for a scene whose medium is on the device.
    #[must_use]
    pub fn new(scene: &Scene, medium: &Medium) -> Self {
        let (table_min, table_scale) = medium.table_mapping();
        let table = &medium.plan.table;
        let baked = table.bake(scene);
        let bounds = leaves::bounds(scene, table);
        let (m, grid) = (&scene.medium, &scene.volume.grid);
        let centre = grid.centre();
        let inverse = grid.world_from_index.inverse();
        let rows = inverse.matrix3.transpose();
        let offset = inverse.transform_point3(centre);
        let (first, last) = (baked[0], baked[baked.len() - 1]);
        let map = Environment::of(scene);
        let size = extents(map.as_ref().map(|e| &**e.map)).0.as_dvec2();
        let scale = map.as_ref().map_or(Vec3::ZERO, |e| e.scale);
        let turn = map
            .map_or(DMat3::IDENTITY, |e| e.map_from_world)
            .transpose();
        let slope = (last[3] - first[3]) * table_scale / (table.entries - 1) as f32;
        Self {
            table: [table_min, table_scale, table.entries as f32, 0.0],
            dims: vec4(grid.dims.as_dvec3(), m.albedo),
            bounds: [bounds.max, bounds.min, m.phase_g as f32, m.emission as f32],
            straight: first,
            line: [first[3], slope, 0.0, 0.0],
            environment: lights::environment(&scene.lights).extend(0.0).to_array(),
            grid_from_world: [
                vec4(rows.x_axis, offset.x),
                vec4(rows.y_axis, offset.y),
                vec4(rows.z_axis, offset.z),
            ],
            map_from_world: [
                vec4(turn.x_axis, size.x),
                vec4(turn.y_axis, size.y),
                vec4(turn.z_axis, 0.0),
            ],
            map_scale: scale.extend(0.0).to_array(),
            lights: lights::uniforms(&scene.lights, centre),
        }
    }
}
