//! What the stages of `summed_area` read: uniform block and push constants.

use bytemuck::{Pod, Zeroable};

use super::SummedAreaPlan;
use crate::gpu::{BindingKind, StageLayout, shader};
use crate::scene::Scene;
use crate::technique::medium::{MATERIAL, Medium, with_material};
use crate::technique::view::grid_rows;

use BindingKind::{SampledImage, StorageImage, UniformBuffer};

const fn bindings(medium: BindingKind) -> [BindingKind; 8 + MATERIAL.len()] {
    with_material([
        UniformBuffer,
        UniformBuffer,
        medium,
        medium,
        medium,
        SampledImage,
        StorageImage,
        StorageImage,
    ])
}

const FILTERED: &[BindingKind] = &bindings(SampledImage);
const LOADED: &[BindingKind] = &bindings(StorageImage);

const fn extinction(shader: shader::Shader, bindings: &'static [BindingKind]) -> StageLayout {
    StageLayout {
        shader,
        bindings,
        push_bytes: size_of::<ExtinctionPush>() as u32,
    }
}

/// The running sums, one invocation a line.
pub(super) const SCAN: StageLayout = StageLayout {
    shader: shader::SUMMED_AREA_SCAN,
    bindings: &[StorageImage],
    push_bytes: 4,
};

/// The running sums along x, a subgroup a line.
pub(super) const SCAN_SUBGROUP: StageLayout = StageLayout {
    shader: shader::SUMMED_AREA_SCAN_SUBGROUP,
    bindings: &[StorageImage],
    push_bytes: 0,
};

/// The running sums along y or z, lines in segments.
pub(super) const SCAN_SEGMENTS: StageLayout = StageLayout {
    shader: shader::SUMMED_AREA_SCAN_SEGMENTS,
    bindings: &[StorageImage],
    push_bytes: 4,
};

/// The mean extinction about every cell.
pub(super) const AMBIENT_EXTINCTION: StageLayout = StageLayout {
    shader: shader::SUMMED_AREA_AMBIENT_EXTINCTION,
    bindings: &[StorageImage, StorageImage],
    push_bytes: size_of::<BoxPush>() as u32,
};

/// The occlusion of every cell.
pub(super) const OCCLUSION: StageLayout = StageLayout {
    shader: shader::SUMMED_AREA_OCCLUSION,
    bindings: &[StorageImage, StorageImage, StorageImage],
    push_bytes: size_of::<OcclusionPush>() as u32,
};

/// The interfaces of the stages, for the layout test: four of the extinction, three of scans, two of fields.
pub const LAYOUTS: &[StageLayout] = &[
    extinction(shader::SUMMED_AREA_EXTINCTION, FILTERED),
    extinction(shader::SUMMED_AREA_EXTINCTION_R8, LOADED),
    extinction(shader::SUMMED_AREA_EXTINCTION_R16, LOADED),
    extinction(shader::SUMMED_AREA_EXTINCTION_R32F, LOADED),
    SCAN,
    SCAN_SUBGROUP,
    SCAN_SEGMENTS,
    AMBIENT_EXTINCTION,
    OCCLUSION,
];

/// Push constants of `summed_area.extinction`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[allow(
    missing_docs,
    reason = "documented in glsl/summed_area/extinction.glsl"
)]
pub struct ExtinctionPush {
    pub first_slice: u32,
    pub slice_count: u32,
}

/// Push constants of `summed_area.ambient_extinction`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[allow(
    missing_docs,
    reason = "documented in glsl/summed_area/ambient_extinction.comp"
)]
pub struct BoxPush {
    pub half_box: [f32; 3],
    pub depth_a_level: f32,
    pub first_slice: u32,
    pub slice_count: u32,
}

/// Push constants of `summed_area.occlusion`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[allow(missing_docs, reason = "documented in glsl/summed_area/occlusion.comp")]
pub struct OcclusionPush {
    pub shells: BoxPush,
    pub square_a_level: f32,
}

/// The `Area` block, std140.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[allow(
    missing_docs,
    reason = "documented in glsl/summed_area/extinction.glsl"
)]
pub struct AreaUniform {
    pub table: [f32; 4],
    pub dims: [u32; 4],
    pub cell: [u32; 4],
    pub split: [u32; 4],
    pub world_from_grid: [[f32; 4]; 3],
}

impl AreaUniform {
    /// Fills the block for a scene whose medium is on the device.
    #[must_use]
    pub fn new(scene: &Scene, plan: &SummedAreaPlan, medium: &Medium) -> Self {
        let (table_min, table_scale) = medium.table_mapping();
        let entries = medium.plan.table.entries as f32;
        let levels = plan.levels / f64::from(plan.cell.element_product());
        Self {
            table: [table_min, table_scale, entries, levels as f32],
            dims: medium.plan.dims.extend(plan.largest).to_array(),
            cell: plan.cell.extend(0).to_array(),
            split: plan.split.extend(0).to_array(),
            world_from_grid: grid_rows(&scene.volume.grid),
        }
    }
}
