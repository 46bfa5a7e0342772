//! What the stages of `half_angle` read: uniform block and push constants.

use bytemuck::{Pod, Zeroable};
use glam::DVec3;

use super::frustum::LightFrustum;
use super::plan::HalfAnglePlan;
use super::sweep::{Slice, Sweep, is_point};
use crate::gpu::{BindingKind, StageLayout, shader};
use crate::scene::{HalfAngleParams, Lighting, Scene, Shading};
use crate::technique::lights::{self, LightUniform};
use crate::technique::medium::{MATERIAL, Medium, MediumPlan, with_material};
use crate::technique::view::{gradient_rows, vec4};

use BindingKind::{SampledImage, StorageImage, UniformBuffer};

// By the device's filters, and by loads: they differ in how bindings 2 to 4, the medium, are read.
const fn propagate_bindings(medium: BindingKind) -> [BindingKind; 10 + MATERIAL.len()] {
    with_material([
        UniformBuffer,
        UniformBuffer,
        medium,
        medium,
        medium,
        SampledImage,
        SampledImage,
        StorageImage,
        StorageImage,
        StorageImage,
    ])
}

const fn shade_bindings(medium: BindingKind) -> [BindingKind; 11 + MATERIAL.len()] {
    with_material([
        UniformBuffer,
        UniformBuffer,
        medium,
        medium,
        medium,
        SampledImage,
        SampledImage,
        StorageImage,
        StorageImage,
        StorageImage,
        StorageImage,
    ])
}

const SHADE_FILTERED: &[BindingKind] = &shade_bindings(SampledImage);
const SHADE_LOADED: &[BindingKind] = &shade_bindings(StorageImage);
const PROPAGATE_FILTERED: &[BindingKind] = &propagate_bindings(SampledImage);
const PROPAGATE_LOADED: &[BindingKind] = &propagate_bindings(StorageImage);

const fn slice(shader: shader::Shader, bindings: &'static [BindingKind]) -> StageLayout {
    StageLayout {
        shader,
        bindings,
        push_bytes: size_of::<SlicePush>() as u32,
    }
}

pub(super) const COMPOSE: StageLayout = StageLayout {
    shader: shader::HALF_ANGLE_COMPOSE,
    bindings: &[UniformBuffer, StorageImage, StorageImage],
    push_bytes: size_of::<ComposePush>() as u32,
};

/// The interfaces of the technique's stages, for the layout test: four that shade, four that propagate, one that
/// composes.
pub const LAYOUTS: &[StageLayout] = &[
    slice(shader::HALF_ANGLE_SHADE_SLICE, SHADE_FILTERED),
    slice(shader::HALF_ANGLE_SHADE_SLICE_R8, SHADE_LOADED),
    slice(shader::HALF_ANGLE_SHADE_SLICE_R16, SHADE_LOADED),
    slice(shader::HALF_ANGLE_SHADE_SLICE_R32F, SHADE_LOADED),
    slice(shader::HALF_ANGLE_PROPAGATE, PROPAGATE_FILTERED),
    slice(shader::HALF_ANGLE_PROPAGATE_R8, PROPAGATE_LOADED),
    slice(shader::HALF_ANGLE_PROPAGATE_R16, PROPAGATE_LOADED),
    slice(shader::HALF_ANGLE_PROPAGATE_R32F, PROPAGATE_LOADED),
    COMPOSE,
];

/// The shading that suits a medium.
pub(super) fn shade_for(medium: &MediumPlan) -> StageLayout {
    LAYOUTS[medium.form()]
}

/// The propagation that suits a medium.
pub(super) fn propagate_for(medium: &MediumPlan) -> StageLayout {
    LAYOUTS[4 + medium.form()]
}

/// Push constants of `half_angle.shade_slice` and `half_angle.propagate`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[allow(missing_docs, reason = "documented in glsl/half_angle/sweep.glsl")]
pub struct SlicePush {
    pub first: [i32; 2],
    pub end: [i32; 2],
    pub faces: [f32; 2],
    pub slice: u32,
    pub sub_sample: u32,
}

impl SlicePush {
    /// Of the pixels of a slice.
    pub(super) fn shade(slice: &Slice, index: u32, sub_sample: u32) -> Self {
        Self {
            first: slice.pixels.low.to_array(),
            end: slice.pixels.high.to_array(),
            faces: slice.faces,
            slice: index,
            sub_sample,
        }
    }

    /// Of its texels.
    pub(super) fn propagate(slice: &Slice, index: u32) -> Self {
        Self {
            first: slice.texels.low.to_array(),
            end: slice.texels.high.to_array(),
            faces: slice.faces,
            slice: index,
            sub_sample: 0,
        }
    }
}

/// Push constants of `half_angle.compose`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[allow(missing_docs, reason = "documented in glsl/half_angle/compose.comp")]
pub struct ComposePush {
    pub sub_sample: u32,
    pub sweep: u32,
}

/// The `Sweep` block, std140.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[allow(missing_docs, reason = "documented in glsl/half_angle/sweep.glsl")]
pub struct SweepUniform {
    pub table: [f32; 4],
    pub dims: [f32; 4],
    pub cell_scale: [f32; 4],
    pub axis: [f32; 4],
    pub light: LightUniform,
    pub light_axis: [f32; 4],
    pub light_anchor: [f32; 4],
    pub light_u: [f32; 4],
    pub light_v: [f32; 4],
    pub light_low: [f32; 4],
    pub phase: [f32; 4],
    pub ambient: [f32; 4],
    pub surface: [f32; 4],
    pub gradient: [[f32; 4]; 3],
}

/// Ways through a slice of up to so many thicknesses have one sample: rays at 45 degrees to the axis and what
/// perspective adds.
pub(super) const LONGEST_WAY: f64 = 1.6;

impl SweepUniform {
    /// Fills the block for one sweep of a scene whose medium is on the device.
    #[must_use]
    pub fn new(
        scene: &Scene,
        params: &HalfAngleParams,
        plan: &HalfAnglePlan,
        medium: &Medium,
        index: usize,
    ) -> Self {
        let (m, grid, sweep) = (&scene.medium, &scene.volume.grid, &plan.sweeps[index]);
        let (table_min, table_scale) = medium.table_mapping();
        let entries = medium.plan.table.entries as f32;
        let cell_size = medium.plan.cells.map_or(1, |c| c.size);
        let cells_per_texture = grid.dims.as_dvec3() / f64::from(cell_size);
        let tau_end = -(-params.early_termination).ln_1p();
        let first = index == 0;
        let emission = match params.lighting {
            Lighting::None => 1.0,
            Lighting::Surface => 0.0,
            _ if first => m.emission,
            _ => 0.0,
        };
        let shading = Shading::default();
        let ambient =
            f64::from(shading.ambient) * lights::mean_environment(&scene.lights).as_dvec3();
        let ambient = if first { ambient } else { DVec3::ZERO };
        let [light_axis, light_anchor, light_u, light_v, light_low] = buffer_rows(sweep, plan);
        let steps = params.phase_table.as_ref().map_or(0, |t| t.len() - 1);
        Self {
            table: [table_min, table_scale, entries, m.albedo as f32],
            dims: vec4(grid.dims.as_dvec3(), emission),
            cell_scale: vec4(cells_per_texture, tau_end),
            axis: vec4(sweep.axis, LONGEST_WAY * sweep.thickness),
            light: light_of(scene, plan, index),
            light_axis,
            light_anchor,
            light_u,
            light_v,
            light_low,
            phase: vec4(
                DVec3::new(m.phase_g, 0.5 * m.phase_g, steps as f64),
                plan.free_path,
            ),
            ambient: vec4(ambient, shading.diffuse.into()),
            surface: [
                params.specular,
                params.shininess,
                (1.0 / params.surface_gradient) as f32,
                0.0,
            ],
            gradient: gradient_rows(scene, medium),
        }
    }
}

/// The light that a sweep is for; without one nothing shines.
fn light_of(scene: &Scene, plan: &HalfAnglePlan, index: usize) -> LightUniform {
    let all = lights::uniforms(&scene.lights, scene.volume.grid.centre());
    let light = plan.sweeps[index].light.as_ref().map(|l| l.light);
    let number = light.or(plan.unshadowed.then_some(index as u32));
    number
        .and_then(|i| all.get(i as usize))
        .copied()
        .unwrap_or_default()
}

/// The light buffer's frame: its axis, a point on it, its two sides, and lower corner.
fn buffer_rows(sweep: &Sweep, plan: &HalfAnglePlan) -> [[f32; 4]; 5] {
    let Some(light) = &sweep.light else {
        return [[0.0; 4]; 5];
    };
    let LightFrustum {
        axis,
        across: [u, v],
        low,
        texel_size,
        texels,
        is_part,
        ..
    } = light;
    let corner = low.extend(*texel_size);
    let (anchor, distance) = light.anchor();
    [
        vec4(*axis, f64::from(u8::from(*is_part && is_point(light)))),
        vec4(anchor, distance),
        vec4(*u, texels.x.into()),
        vec4(*v, texels.y.into()),
        vec4(corner, plan.spread),
    ]
}
