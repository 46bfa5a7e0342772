//! What Rust writes is what the shaders read: offsets, sizes, binding kinds, constants.
#![allow(clippy::unwrap_used, clippy::panic)]

use std::mem::offset_of;

use spirq::prelude::*;
use spirq::ty::DescriptorType;
use tyndall::gpu::shader::{self, Shader};
use tyndall::gpu::{BindingKind, Specialization, StageLayout};
use tyndall::technique::TilePush;
use tyndall::technique::ambient_occlusion::{self, OccludedUniform};
use tyndall::technique::ambient_scattering::table::layout as preintegrate;
use tyndall::technique::ambient_scattering::{self, AmbientUniform, GatherPush, TubePush};
use tyndall::technique::half_angle::{self, ComposePush, SlicePush, SweepUniform};
use tyndall::technique::medium::{self, MaterialUniform, OccupancyPush};
use tyndall::technique::path_trace::{self, TracePush, TraceUniform};
use tyndall::technique::ray_march::{self, MarchUniform};
use tyndall::technique::single_scatter::{self, CacheLightPush, ScatterMarchPush, ScatterUniform};
use tyndall::technique::summed_area::{self, AreaUniform, BoxPush, ExtinctionPush, OcclusionPush};
use tyndall::technique::{LightUniform, ViewUniform};

fn reflect(shader: &Shader) -> EntryPoint {
    let mut config = ReflectConfig::new();
    config
        .spv(shader.words().unwrap())
        .ref_all_rscs(true)
        .combine_img_samplers(true);
    config.reflect().unwrap().remove(0)
}

fn layouts() -> Vec<StageLayout> {
    [
        preintegrate::LAYOUTS,
        ambient_scattering::LAYOUTS,
        half_angle::LAYOUTS,
        medium::LAYOUTS,
        path_trace::LAYOUTS,
        ray_march::LAYOUTS,
        single_scatter::LAYOUTS,
        summed_area::LAYOUTS,
        ambient_occlusion::LAYOUTS,
    ]
    .concat()
}

/// Offsets of a block's members in declaration order, and its size.
fn block(shader: &Shader, wanted: Option<u32>) -> (Vec<usize>, usize) {
    for variable in reflect(shader).vars {
        let found = match &variable {
            Variable::PushConstant { ty, .. } if wanted.is_none() => Some(ty.clone()),
            Variable::Descriptor {
                desc_bind,
                ty,
                desc_ty: DescriptorType::UniformBuffer(),
                ..
            } if wanted == Some(desc_bind.bind()) => Some(ty.clone()),
            _ => None,
        };
        if let Some(Type::Struct(s)) = found {
            let offsets = s.members.iter().map(|m| m.offset.unwrap()).collect();
            return (offsets, Type::Struct(s).nbyte().unwrap());
        }
    }
    panic!("{}: no such block", shader.name);
}

#[test]
fn blocks_have_the_offsets_of_their_rust_structs() {
    for march in ray_march::LAYOUTS.iter().map(|l| &l.shader) {
        march_blocks(march);
    }
    for trace in path_trace::LAYOUTS.iter().map(|l| &l.shader) {
        trace_blocks(trace);
    }
    for layout in ambient_scattering::LAYOUTS {
        ambient_blocks(&layout.shader);
    }
    let (caches, marches) = single_scatter::LAYOUTS.split_at(4);
    for (cache, march) in caches.iter().zip(marches) {
        scatter_blocks(&cache.shader, &march.shader);
    }
    for layout in half_angle::LAYOUTS {
        sweep_blocks(&layout.shader);
    }
    area_blocks();
    for march in ambient_occlusion::LAYOUTS.iter().map(|l| &l.shader) {
        occluded_blocks(march);
    }
    let push = vec![
        offset_of!(OccupancyPush, table_min),
        offset_of!(OccupancyPush, table_scale),
    ];
    assert_eq!(
        block(&shader::MEDIUM_CELL_OCCUPANCY, None),
        (push, size_of::<OccupancyPush>())
    );
    assert_eq!(block(&shader::MEDIUM_CELL_MIN_MAX, None), (vec![0], 8));
    assert_eq!(block(&shader::MEDIUM_CELL_DISTANCE, None), (vec![0], 4));
    material_blocks();
}

/// Every stage that reads the volume's material has its bindings last.
fn material_blocks() {
    let mut found = 0;
    for layout in layouts() {
        let Some(first) = layout.bindings.len().checked_sub(medium::MATERIAL.len()) else {
            continue;
        };
        let source = flattened(&layout.shader);
        if !source.contains("uniform Material {") {
            continue;
        }
        found += 1;
        assert_eq!(layout.bindings[first..], medium::MATERIAL);
        let offsets = vec![
            offset_of!(MaterialUniform, gradient),
            offset_of!(MaterialUniform, world_from_grid),
            offset_of!(MaterialUniform, grid_from_world),
            offset_of!(MaterialUniform, displacing),
            offset_of!(MaterialUniform, displacement),
            offset_of!(MaterialUniform, varying_at),
            offset_of!(MaterialUniform, variation),
            offset_of!(MaterialUniform, layer),
        ];
        assert_eq!(
            block(&layout.shader, Some(first as u32)),
            (offsets, size_of::<MaterialUniform>()),
            "{}",
            layout.shader.name
        );
    }
    assert!(found >= 28, "{found}");
}

fn flattened(shader: &Shader) -> String {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
    tyndall::shaders::flatten(root, &shader.name.replace('.', "/")).unwrap()
}

#[test]
fn preintegration_jobs_have_the_offsets_of_their_rust_struct() {
    use preintegrate::{Job, PreintegratePush};
    let push = vec![
        offset_of!(PreintegratePush, seed),
        offset_of!(PreintegratePush, job_count),
        offset_of!(PreintegratePush, rounds),
        offset_of!(PreintegratePush, resumed),
        offset_of!(PreintegratePush, log2_albedo),
    ];
    let job = vec![
        offset_of!(Job, sigma_t),
        offset_of!(Job, g),
        offset_of!(Job, key),
        offset_of!(Job, batch),
        offset_of!(Job, stretch),
        offset_of!(Job, decay),
        offset_of!(Job, theta_first),
        offset_of!(Job, theta_step),
        offset_of!(Job, even),
        offset_of!(Job, paths),
    ];
    for layout in preintegrate::LAYOUTS {
        let shader = &layout.shader;
        assert_eq!(
            block(shader, None),
            (push.clone(), size_of::<PreintegratePush>())
        );
        assert_eq!(elements(shader, 0), (job.clone(), size_of::<Job>()));
    }
    let (_, stride) = elements(&preintegrate::LAYOUTS[0].shader, 3);
    assert_eq!(stride, preintegrate::LANE_BYTES);
}

/// Offsets of the members of a storage buffer's elements, and their stride.
fn elements(shader: &Shader, binding: u32) -> (Vec<usize>, usize) {
    for variable in reflect(shader).vars {
        if let Variable::Descriptor { desc_bind, ty, .. } = &variable
            && desc_bind.bind() == binding
            && let Type::Struct(s) = ty
            && let Type::Array(a) = &s.members[0].ty
            && let Type::Struct(element) = &*a.element_ty
        {
            let offsets = element.members.iter().map(|m| m.offset.unwrap());
            return (offsets.collect(), a.stride.unwrap());
        }
    }
    panic!("{}: no such buffer", shader.name);
}

fn ambient_blocks(shader: &Shader) {
    let uniform = vec![
        offset_of!(AmbientUniform, table),
        offset_of!(AmbientUniform, dims),
        offset_of!(AmbientUniform, cell_scale),
        offset_of!(AmbientUniform, node_first),
        offset_of!(AmbientUniform, node_spacing),
        offset_of!(AmbientUniform, node_last),
        offset_of!(AmbientUniform, extinction_scale),
        offset_of!(AmbientUniform, occlusion_scale),
        offset_of!(AmbientUniform, environment),
        offset_of!(AmbientUniform, specular),
        offset_of!(AmbientUniform, dimming_ratio),
        offset_of!(AmbientUniform, gradient),
        offset_of!(AmbientUniform, world_from_grid),
        offset_of!(AmbientUniform, lights),
    ];
    assert_eq!(
        block(shader, Some(1)),
        (uniform, size_of::<AmbientUniform>())
    );
    let (push, bytes) = if shader.name.contains("radiance_cache") {
        let push = vec![
            offset_of!(TubePush, light),
            offset_of!(TubePush, first_slice),
            offset_of!(TubePush, slice_count),
        ];
        (push, size_of::<TubePush>())
    } else if shader.name == ambient_scattering::stage::GATHER {
        let push = vec![
            offset_of!(GatherPush, first_slice),
            offset_of!(GatherPush, slice_count),
        ];
        (push, size_of::<GatherPush>())
    } else {
        let push = vec![
            offset_of!(TilePush, first_tile),
            offset_of!(TilePush, tile_count),
            offset_of!(TilePush, sub_sample),
        ];
        (push, size_of::<TilePush>())
    };
    assert_eq!(block(shader, None), (push, bytes));
}

fn sweep_blocks(shader: &Shader) {
    if shader.name == shader::HALF_ANGLE_COMPOSE.name {
        let push = vec![
            offset_of!(ComposePush, sub_sample),
            offset_of!(ComposePush, sweep),
        ];
        assert_eq!(block(shader, None), (push, size_of::<ComposePush>()));
        return;
    }
    let uniform = vec![
        offset_of!(SweepUniform, table),
        offset_of!(SweepUniform, dims),
        offset_of!(SweepUniform, cell_scale),
        offset_of!(SweepUniform, axis),
        offset_of!(SweepUniform, light),
        offset_of!(SweepUniform, light_axis),
        offset_of!(SweepUniform, light_anchor),
        offset_of!(SweepUniform, light_u),
        offset_of!(SweepUniform, light_v),
        offset_of!(SweepUniform, light_low),
        offset_of!(SweepUniform, phase),
        offset_of!(SweepUniform, ambient),
        offset_of!(SweepUniform, surface),
        offset_of!(SweepUniform, gradient),
    ];
    let found = block(shader, Some(1));
    assert_eq!(found, (uniform, size_of::<SweepUniform>()));
    let push = vec![
        offset_of!(SlicePush, first),
        offset_of!(SlicePush, end),
        offset_of!(SlicePush, faces),
        offset_of!(SlicePush, slice),
        offset_of!(SlicePush, sub_sample),
    ];
    assert_eq!(block(shader, None), (push, size_of::<SlicePush>()));
}

fn march_blocks(march: &Shader) {
    let view = vec![
        offset_of!(ViewUniform, pivot),
        offset_of!(ViewUniform, pivot_right),
        offset_of!(ViewUniform, pivot_up),
        offset_of!(ViewUniform, forward),
        offset_of!(ViewUniform, ray_right),
        offset_of!(ViewUniform, ray_up),
        offset_of!(ViewUniform, texture_from_world),
        offset_of!(ViewUniform, clip_min),
        offset_of!(ViewUniform, clip_max),
        offset_of!(ViewUniform, clip_plane),
        offset_of!(ViewUniform, background),
        offset_of!(ViewUniform, image),
    ];
    assert_eq!(block(march, Some(0)), (view, size_of::<ViewUniform>()));
    let uniform = vec![
        offset_of!(MarchUniform, table),
        offset_of!(MarchUniform, dims),
        offset_of!(MarchUniform, cell_scale),
        offset_of!(MarchUniform, ambient),
        offset_of!(MarchUniform, specular),
        offset_of!(MarchUniform, gradient),
        offset_of!(MarchUniform, lights),
    ];
    assert_eq!(block(march, Some(1)), (uniform, size_of::<MarchUniform>()));
    assert_eq!(
        (
            offset_of!(LightUniform, irradiance),
            size_of::<LightUniform>()
        ),
        (16, 32)
    );
    let push = vec![
        offset_of!(TilePush, first_tile),
        offset_of!(TilePush, tile_count),
        offset_of!(TilePush, sub_sample),
    ];
    assert_eq!(block(march, None), (push, size_of::<TilePush>()));
}

fn trace_blocks(trace: &Shader) {
    let uniform = vec![
        offset_of!(TraceUniform, table),
        offset_of!(TraceUniform, dims),
        offset_of!(TraceUniform, bounds),
        offset_of!(TraceUniform, straight),
        offset_of!(TraceUniform, line),
        offset_of!(TraceUniform, environment),
        offset_of!(TraceUniform, grid_from_world),
        offset_of!(TraceUniform, map_from_world),
        offset_of!(TraceUniform, map_scale),
        offset_of!(TraceUniform, lights),
    ];
    assert_eq!(block(trace, Some(1)), (uniform, size_of::<TraceUniform>()));
    let push = vec![
        offset_of!(TracePush, rounds),
        offset_of!(TracePush, samples),
        offset_of!(TracePush, seed),
        offset_of!(TracePush, first),
    ];
    assert_eq!(block(trace, None), (push, size_of::<TracePush>()));
}

fn scatter_blocks(cache: &Shader, march: &Shader) {
    let uniform = vec![
        offset_of!(ScatterUniform, table),
        offset_of!(ScatterUniform, dims),
        offset_of!(ScatterUniform, cell_scale),
        offset_of!(ScatterUniform, node_first),
        offset_of!(ScatterUniform, node_spacing),
        offset_of!(ScatterUniform, node_last),
        offset_of!(ScatterUniform, world_from_grid),
        offset_of!(ScatterUniform, lights),
    ];
    let uniform = (uniform, size_of::<ScatterUniform>());
    assert_eq!(block(cache, Some(1)), uniform);
    assert_eq!(block(march, Some(1)), uniform);
    let push = vec![
        offset_of!(CacheLightPush, light),
        offset_of!(CacheLightPush, first_slice),
        offset_of!(CacheLightPush, slice_count),
    ];
    assert_eq!(block(cache, None), (push, size_of::<CacheLightPush>()));
    let push = vec![
        offset_of!(ScatterMarchPush, first_tile),
        offset_of!(ScatterMarchPush, tile_count),
        offset_of!(ScatterMarchPush, sub_sample),
        offset_of!(ScatterMarchPush, first_sample),
        offset_of!(ScatterMarchPush, end_sample),
    ];
    assert_eq!(block(march, None), (push, size_of::<ScatterMarchPush>()));
}

fn area_blocks() {
    let uniform = vec![
        offset_of!(AreaUniform, table),
        offset_of!(AreaUniform, dims),
        offset_of!(AreaUniform, cell),
        offset_of!(AreaUniform, split),
        offset_of!(AreaUniform, world_from_grid),
    ];
    let push = vec![
        offset_of!(ExtinctionPush, first_slice),
        offset_of!(ExtinctionPush, slice_count),
    ];
    let (extinctions, others) = summed_area::LAYOUTS.split_at(4);
    for shader in extinctions.iter().map(|l| &l.shader) {
        let expected = (uniform.clone(), size_of::<AreaUniform>());
        assert_eq!(block(shader, Some(1)), expected);
        let expected = (push.clone(), size_of::<ExtinctionPush>());
        assert_eq!(block(shader, None), expected);
    }
    let ([scan, _, scan_segments], others) = others.split_first_chunk().unwrap();
    for scan in [scan, scan_segments] {
        assert_eq!(block(&scan.shader, None), (vec![0], 4));
    }
    // The shader names the box's three numbers one by one.
    let half_box = offset_of!(BoxPush, half_box);
    let push = vec![
        half_box,
        half_box + 4,
        half_box + 8,
        offset_of!(BoxPush, depth_a_level),
        offset_of!(BoxPush, first_slice),
        offset_of!(BoxPush, slice_count),
    ];
    let extinction = &others[0].shader;
    assert_eq!(
        block(extinction, None),
        (push.clone(), size_of::<BoxPush>())
    );
    assert_eq!(offset_of!(OcclusionPush, shells), 0);
    let push = [push, vec![offset_of!(OcclusionPush, square_a_level)]].concat();
    let occlusion = &others[1].shader;
    assert_eq!(block(occlusion, None), (push, size_of::<OcclusionPush>()));
}

fn occluded_blocks(march: &Shader) {
    let uniform = vec![
        offset_of!(OccludedUniform, table),
        offset_of!(OccludedUniform, dims),
        offset_of!(OccludedUniform, cell_scale),
        offset_of!(OccludedUniform, occlusion_scale),
        offset_of!(OccludedUniform, environment),
    ];
    let uniform = (uniform, size_of::<OccludedUniform>());
    assert_eq!(block(march, Some(1)), uniform);
    let push = vec![
        offset_of!(TilePush, first_tile),
        offset_of!(TilePush, tile_count),
        offset_of!(TilePush, sub_sample),
    ];
    assert_eq!(block(march, None), (push, size_of::<TilePush>()));
}

#[test]
fn every_binding_is_of_the_declared_kind() {
    for layout in layouts() {
        let mut found = vec![None; layout.bindings.len()];
        let mut push_bytes = 0;
        for variable in reflect(&layout.shader).vars {
            match variable {
                Variable::Descriptor {
                    desc_bind, desc_ty, ..
                } => {
                    assert_eq!(desc_bind.set(), 0, "{}", layout.shader.name);
                    let kind = match desc_ty {
                        DescriptorType::CombinedImageSampler() => BindingKind::SampledImage,
                        DescriptorType::StorageImage(_) => BindingKind::StorageImage,
                        DescriptorType::UniformBuffer() => BindingKind::UniformBuffer,
                        DescriptorType::StorageBuffer(_) => BindingKind::StorageBuffer,
                        other => panic!("{}: {other:?}", layout.shader.name),
                    };
                    found[desc_bind.bind() as usize] = Some(kind);
                }
                Variable::PushConstant { ty, .. } => push_bytes = ty.nbyte().unwrap(),
                _ => {}
            }
        }
        for (i, (found, declared)) in found.iter().zip(layout.bindings).enumerate() {
            assert_eq!(
                found.as_ref(),
                Some(declared),
                "{} binding {i}",
                layout.shader.name
            );
        }
        assert_eq!(
            push_bytes, layout.push_bytes as usize,
            "{}",
            layout.shader.name
        );
        assert!(layout.push_bytes <= 128);
    }
}

#[test]
fn every_shader_has_a_layout_and_fits_the_smallest_limits() {
    let names: Vec<_> = layouts().iter().map(|l| l.shader.name).collect();
    for shader in shader::ALL {
        assert!(
            names.contains(&shader.name),
            "{} has no layout",
            shader.name
        );
        let [x, y, z] = shader.local_size().unwrap();
        // Vulkan's required minimum; x a multiple of 8 fills the lanes of software drivers.
        assert!(
            x * y * z <= 128 && x % 8 == 0,
            "{}: {x} x {y} x {z}",
            shader.name
        );
    }
}

/// A stage's own constants, and the material's.
fn with_material(own: &[Specialization]) -> Vec<Specialization> {
    [own, &medium::CONSTANTS].concat()
}

fn ambient_constants() -> impl Iterator<Item = (Shader, Vec<Specialization>)> {
    let constants = |i| match i {
        0..4 => with_material(&ambient_scattering::MARCH_CONSTANTS),
        4 => ambient_scattering::CACHE_CONSTANTS.to_vec(),
        _ => ambient_scattering::GATHER_CONSTANTS.to_vec(),
    };
    let layouts = ambient_scattering::LAYOUTS.iter().enumerate();
    layouts.map(move |(i, layout)| (layout.shader, constants(i)))
}

fn sweep_constants() -> impl Iterator<Item = (Shader, Vec<Specialization>)> {
    let constants = |i| match i {
        0..4 => with_material(&half_angle::SHADE_CONSTANTS),
        4..8 => with_material(&half_angle::PROPAGATE_CONSTANTS),
        _ => Vec::new(),
    };
    let layouts = half_angle::LAYOUTS.iter().enumerate();
    layouts.map(move |(i, layout)| (layout.shader, constants(i)))
}

fn scatter_constants() -> impl Iterator<Item = (Shader, Vec<Specialization>)> {
    let constants = |i| match i {
        0..4 => with_material(&single_scatter::CACHE_CONSTANTS),
        _ => with_material(&single_scatter::MARCH_CONSTANTS),
    };
    let layouts = single_scatter::LAYOUTS.iter().enumerate();
    layouts.map(move |(i, layout)| (layout.shader, constants(i)))
}

fn area_constants() -> impl Iterator<Item = (Shader, Vec<Specialization>)> {
    let area = summed_area::LAYOUTS.iter().take(4);
    let area = area.map(|l| (l.shader, with_material(&summed_area::CONSTANTS)));
    let occluded = ambient_occlusion::LAYOUTS.iter();
    area.chain(occluded.map(|l| (l.shader, with_material(&ambient_occlusion::CONSTANTS))))
}

#[test]
fn specialisation_constants_have_the_ids_the_plan_gives_them() {
    let constants = |shader: &Shader| -> Vec<(u32, String)> {
        let source = flattened(shader);
        let lines = source
            .lines()
            .filter_map(|l| l.strip_prefix("layout(constant_id = "));
        lines
            .map(|l| {
                let (id, rest) = l.split_once(')').unwrap();
                (
                    id.parse().unwrap(),
                    rest.split_whitespace().nth(2).unwrap().to_owned(),
                )
            })
            .collect()
    };
    let cells = medium::CellsPlan {
        size: 4,
        height_field: false,
        dims: glam::UVec3::ONE,
        reach: 15,
        widen: 0,
    };
    for (shader, given) in [
        (
            shader::AMBIENT_SCATTERING_PREINTEGRATE,
            preintegrate::constants(1).to_vec(),
        ),
        (shader::MEDIUM_CELL_MIN_MAX, cells.min_max_constants()),
        (shader::MEDIUM_CELL_OCCUPANCY, cells.reach_constants()),
        (shader::MEDIUM_CELL_DISTANCE, cells.distance_constants()),
        (
            shader::PATH_TRACE_TRACE,
            with_material(&path_trace::CONSTANTS),
        ),
        (
            shader::PATH_TRACE_TRACE_R8,
            with_material(&path_trace::CONSTANTS),
        ),
        (
            shader::PATH_TRACE_TRACE_R16,
            with_material(&path_trace::CONSTANTS),
        ),
        (
            shader::PATH_TRACE_TRACE_R32F,
            with_material(&path_trace::CONSTANTS),
        ),
        (
            shader::RAY_MARCH_MARCH,
            with_material(&ray_march::CONSTANTS),
        ),
        (
            shader::RAY_MARCH_MARCH_R8,
            with_material(&ray_march::CONSTANTS),
        ),
        (
            shader::RAY_MARCH_MARCH_R16,
            with_material(&ray_march::CONSTANTS),
        ),
        (
            shader::RAY_MARCH_MARCH_R32F,
            with_material(&ray_march::CONSTANTS),
        ),
    ]
    .into_iter()
    .chain(scatter_constants())
    .chain(ambient_constants())
    .chain(sweep_constants())
    .chain(area_constants())
    {
        let given: Vec<_> = given.iter().map(|c| (c.id, c.name.to_owned())).collect();
        assert_eq!(constants(&shader), given, "{}", shader.name);
    }
}
