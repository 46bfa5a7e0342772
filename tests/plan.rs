//! The plan is pure data: what a scene needs, decided without a GPU.
#![allow(clippy::unwrap_used)]

mod common;

use std::sync::Arc;

use common::{constant, cube, points, scene, volume, with};
use glam::{DVec3, UVec3, Vec3};
use tyndall::gpu::{Format, Limits};
use tyndall::scene::transfer_function::{Primitive, Quantity, Shape};
use tyndall::scene::{
    AmbientOcclusionParams, HalfAngleParams, Light, LightCache, Octave, PathTraceParams,
    Perturbation, Plane, Radius, Scene, Shading, SingleScatterParams, TechniqueParams,
    TransferFunction,
};
use tyndall::technique::half_angle::{self, HalfAnglePlan};
use tyndall::technique::medium::MediumPlan;
use tyndall::technique::path_trace::leaves;
use tyndall::technique::summed_area::{FieldKind, FieldPlan, ScanForm};
use tyndall::technique::{Input, Plan, PlanError, ResourceKind, medium, plan};
use tyndall::volume::{Grid, HeightMap, Layer, Rescale, ScalarType, Sheet, Voxels};

/// A modest desktop GPU.
const LIMITS: Limits = Limits {
    max_image_3d: 2048,
    max_image_2d: 16384,
    max_image_1d: 16384,
    max_allocation: 4 << 30,
    heap_bytes: 8 << 30,
    worker_threads: 1,
    prefers_loads: false,
    prefers_subgroups: true,
    linear_r16_unorm: true,
    linear_r32_sfloat: true,
    linear_rgba32_sfloat: true,
};

fn sparse() -> Scene {
    let v = volume(cube(64), ScalarType::U16, |i| f64::from(i.x));
    scene(
        v,
        points(&[
            (0.0, Vec3::ONE, 0.0),
            (30.0, Vec3::ONE, 0.0),
            (60.0, Vec3::ONE, 0.5),
        ]),
    )
}

fn constants(p: &Plan) -> Vec<(&'static str, u32)> {
    let march = p
        .stages
        .iter()
        .find(|s| s.name == "ray_march.march")
        .unwrap();
    march
        .specialization
        .iter()
        .map(|c| (c.name, c.value))
        .collect()
}

fn has(p: &Plan, resource: &str) -> bool {
    p.resources.iter().any(|r| r.name == resource)
}

fn left_out<'a>(p: &'a Plan, what: &str) -> Option<&'a str> {
    p.omitted
        .iter()
        .find(|o| o.what == what)
        .map(|o| o.why.as_str())
}

#[test]
fn a_scene_gets_only_what_it_can_show() {
    let p = plan(&sparse(), &LIMITS).unwrap();
    assert_eq!(
        constants(&p),
        [
            ("SKIP_EMPTY", 1),
            ("SHADE", 0),
            ("SPECULAR", 0),
            ("MASKED", 0),
            ("CLIP_BOX", 0),
            ("CLIP_PLANE", 0),
            ("LIGHT_COUNT", 0),
            ("POINT_LIGHTS", 0),
            ("SPREAD", 1),
            ("BLOCK", 4),
            ("GRADIENTS", 0),
            ("DISPLACED", 0),
            ("VARIED", 0),
            ("HEIGHT_FIELD", 0)
        ]
    );
    assert!(!has(&p, "noise") && left_out(&p, "noise").is_some());
    assert!(!has(&p, "gradient_table") && left_out(&p, "gradient_table").is_some());
    assert!(!has(&p, "finite_mask") && has(&p, "cell_min_max"));
    assert!(left_out(&p, "gradient").unwrap().contains("shading is off"));
    assert!(
        left_out(&p, "lights")
            .unwrap()
            .contains("no light is looked at")
    );
    assert!(left_out(&p, "phase function").is_some());
    let march = p
        .stages
        .iter()
        .find(|s| s.name == "ray_march.march")
        .unwrap();
    assert!(!march.depends_on.contains(Input::Light) && !march.depends_on.contains(Input::Phase));
}

#[test]
fn what_a_scene_adds_is_compiled_in() {
    let mut s = with(sparse(), |p| p.shading = Some(Shading::default()));
    s.lights.push(Light::Point {
        position: DVec3::ONE,
        intensity: Vec3::ONE,
        falloff: Default::default(),
    });
    s.lights.push(Light::Environment {
        radiance: Vec3::ONE,
    });
    s.clip.plane = Some(Plane {
        point: DVec3::ZERO,
        normal: DVec3::X,
    });
    let p = plan(&s, &LIMITS).unwrap();
    let value = |name| constants(&p).into_iter().find(|c| c.0 == name).unwrap().1;
    assert_eq!(
        (
            value("SHADE"),
            value("SPECULAR"),
            value("LIGHT_COUNT"),
            value("POINT_LIGHTS")
        ),
        (1, 1, 2, 1)
    );
    assert_eq!((value("CLIP_BOX"), value("CLIP_PLANE")), (0, 1));
    let march = p
        .stages
        .iter()
        .find(|s| s.name == "ray_march.march")
        .unwrap();
    assert!(march.depends_on.contains(Input::Light));
    let matt = with(s, |p| {
        p.shading = Some(Shading {
            specular: 0.0,
            ..Shading::default()
        })
    });
    assert_eq!(
        left_out(&plan(&matt, &LIMITS).unwrap(), "specular"),
        Some("shading.specular is 0")
    );
}

#[test]
fn cells_go_where_nothing_can_be_skipped() {
    let opaque = scene(
        volume(cube(8), ScalarType::U8, |i| f64::from(i.x)),
        constant(Vec3::ONE, 0.1),
    );
    let p = plan(&opaque, &LIMITS).unwrap();
    assert!(!has(&p, "cell_min_max") && !p.stages.iter().any(|s| s.name.contains("cell")));
    assert!(
        left_out(&p, "cells")
            .unwrap()
            .contains("no data value empty")
    );
    let off = with(sparse(), |p| p.empty_space_skipping = false);
    assert!(
        left_out(&plan(&off, &LIMITS).unwrap(), "cells")
            .unwrap()
            .contains("off")
    );
}

#[test]
fn formats_keep_the_precision_of_the_data() {
    let expected = [
        (ScalarType::U8, Format::R8_UNORM),
        (ScalarType::I8, Format::R8_UNORM),
        (ScalarType::U16, Format::R16_UNORM),
        (ScalarType::I16, Format::R16_UNORM),
        (ScalarType::U32, Format::R32_SFLOAT),
        (ScalarType::I32, Format::R32_SFLOAT),
        (ScalarType::F32, Format::R32_SFLOAT),
        (ScalarType::F64, Format::R32_SFLOAT),
    ];
    let format = |scalar_type, limits: &Limits| {
        let s = scene(
            volume(cube(4), scalar_type, |i| f64::from(i.x)),
            constant(Vec3::ONE, 0.1),
        );
        plan(&s, limits)
            .map(|p| p.resources[0].format)
            .map_err(|e| e.to_string())
    };
    for (scalar_type, wanted) in expected {
        assert_eq!(format(scalar_type, &LIMITS), Ok(wanted), "{scalar_type}");
    }
    let poor = Limits {
        linear_r16_unorm: false,
        ..LIMITS
    };
    assert_eq!(format(ScalarType::I16, &poor), Ok(Format::R32_SFLOAT));
    let poorer = Limits {
        linear_r32_sfloat: false,
        ..LIMITS
    };
    assert!(
        format(ScalarType::F32, &poorer)
            .unwrap_err()
            .contains("linear filtering")
    );
}

#[test]
fn memory_beyond_volume_and_image_stays_under_a_tenth() {
    for scalar_type in [ScalarType::U8, ScalarType::U16, ScalarType::F32] {
        let v = volume(cube(128), scalar_type, |i| f64::from(i.x));
        let s = scene(
            v,
            points(&[
                (0.0, Vec3::ONE, 0.0),
                (60.0, Vec3::ONE, 0.0),
                (99.0, Vec3::ONE, 0.5),
            ]),
        );
        let p = plan(&s, &LIMITS).unwrap();
        let sum = |kind| {
            p.resources
                .iter()
                .filter(|r| r.kind == kind)
                .map(|r| r.bytes)
                .sum::<u64>()
        };
        let (aux, vol) = (sum(ResourceKind::Auxiliary), sum(ResourceKind::Volume));
        assert!(10 * aux < vol, "{scalar_type}: {aux} beside {vol}");
        assert_eq!(p.bytes(), vol + aux + sum(ResourceKind::Image));
    }
}

#[test]
fn no_submission_runs_long_and_no_dispatch_is_too_wide() {
    let mut s = with(sparse(), |p| p.step = 0.05);
    (s.image.width, s.image.height, s.image.samples_per_axis) = (4096, 4096, 2);
    let p = plan(&s, &LIMITS).unwrap();
    let march = p
        .stages
        .iter()
        .find(|s| s.name == "ray_march.march")
        .unwrap();
    // 2^24 pixels of 64 sqrt(3) / 0.05 samples at most, 2^28 a submission, four sub-samples.
    let samples = (64.0 * 3f64.sqrt() / 0.05).ceil() * f64::from(1 << 24);
    let bands = (samples / f64::from(1 << 28)).ceil();
    assert!(
        f64::from(march.dispatches) >= 4.0 * bands && f64::from(march.dispatches) < 5.0 * bands
    );
}

#[test]
fn refusals_name_what_was_found_the_limit_and_the_fix() {
    let message = |s: &Scene, limits: &Limits| {
        let planned = plan(s, limits).and_then(|p| p.check(limits).map(|()| p));
        planned.unwrap_err().to_string()
    };
    let long = Grid::centred(UVec3::new(1, 1, 3000), DVec3::ONE);
    let long = scene(
        volume(long, ScalarType::U8, |_| 1.0),
        constant(Vec3::ONE, 0.1),
    );
    let m = message(&long, &LIMITS);
    assert!(
        m.contains("1 x 1 x 3000") && m.contains("2048") && m.contains("crop"),
        "{m}"
    );
    let mut wide = sparse();
    wide.image.width = 5000;
    let m = message(
        &wide,
        &Limits {
            max_image_2d: 4096,
            ..LIMITS
        },
    );
    assert!(
        m.contains("5000 x 32") && m.contains("4096") && m.contains("image.width"),
        "{m}"
    );
    let m = message(
        &sparse(),
        &Limits {
            heap_bytes: 100_000,
            ..LIMITS
        },
    );
    assert!(
        m.contains("100.000 kB") && m.contains("volume 524.288 kB"),
        "{m}"
    );
    let m = message(
        &sparse(),
        &Limits {
            max_allocation: 1000,
            ..LIMITS
        },
    );
    assert!(
        m.contains("volume: 524.288 kB") && m.contains("1.000 kB"),
        "{m}"
    );
}

#[test]
fn a_plan_reads_well_as_text_and_json() {
    let p = plan(&sparse(), &LIMITS).unwrap();
    let text = p.to_string();
    for word in [
        "ray_march.march",
        "medium.cell_distance",
        "R16_UNORM",
        "524.288 kB",
        "left out",
        "SKIP_EMPTY = 1",
    ] {
        assert!(text.contains(word), "{word} in\n{text}");
    }
    let json = serde_json::to_value(&p).unwrap();
    assert_eq!(json["technique"], "ray_march");
    assert_eq!(json["resources"][0]["format"], "R16_UNORM");
    assert_eq!(json["stages"][0]["depends_on"][0], "volume");
}

fn traced(mut scene: Scene) -> Plan {
    scene.technique = TechniqueParams::PathTrace(PathTraceParams::default());
    plan(&scene, &LIMITS).unwrap()
}

#[test]
fn path_trace_bounds_leaves_only_where_they_can_help() {
    let p = traced(sparse());
    assert!(has(&p, "leaves") && left_out(&p, "leaves").is_none());
    assert!(
        p.stages
            .iter()
            .any(|s| s.name == "path_trace.upload_leaves")
    );
    let even = traced(scene(
        volume(cube(8), ScalarType::U8, |_| 1.0),
        constant(Vec3::ONE, 0.5),
    ));
    assert!(left_out(&even, "leaves").is_some());
    let mut thin = sparse();
    thin.medium.density_scale = 1e-6;
    assert!(left_out(&traced(thin), "leaves").is_some());
}

#[test]
fn path_trace_leaves_out_shadow_rays_and_a_straight_table() {
    let mut dark = sparse();
    dark.lights.clear();
    assert!(left_out(&traced(dark), "shadow rays").is_some());
    let p = traced(sparse());
    assert!(left_out(&p, "shadow rays").is_none());
    assert!(left_out(&p, "transfer function's table").is_none());
    let mut straight = sparse();
    straight.medium.transfer_function = TransferFunction {
        quantity: Quantity::Extinction,
        ..points(&[(0.0, Vec3::ONE, 0.0), (100.0, Vec3::ONE, 30.0)])
    };
    assert!(left_out(&traced(straight), "transfer function's table").is_some());
}

#[test]
fn leaves_bound_every_sample() {
    // Noise, holes and a transfer function with a spike and a gap.
    let noise = |i: UVec3| f64::from((i.x * 7919 + i.y * 104_729 + i.z * 1_299_709) % 1000);
    let v = volume(
        Grid::centred(UVec3::new(19, 9, 13), DVec3::new(1.0, 2.0, 0.5)),
        ScalarType::F32,
        |i| {
            if i.x == 3 {
                f64::NAN
            } else {
                noise(i) * f64::from(i.y) / 9.0
            }
        },
    );
    let s = scene(
        v,
        points(&[
            (0.0, Vec3::ONE, 0.1),
            (200.0, Vec3::ONE, 0.0),
            (400.0, Vec3::ONE, 0.0),
            (405.0, Vec3::ONE, 0.9),
            (410.0, Vec3::ONE, 0.0),
            (1000.0, Vec3::ONE, 0.2),
        ]),
    );
    let table = medium::Table::choose(&s, &LIMITS);
    let baked = table.bake(&s);
    let leaves = leaves::leaves(&s, &table);
    let (dims, edge) = (s.volume.grid.dims, leaves::cell_edge(s.volume.grid.dims));
    let cells = leaves::cells_along(dims);
    let mut checked = 0;
    for n in 0..20_000u32 {
        // A low-discrepancy sequence over the box in grid coordinates.
        let at = |step: f64| (f64::from(n) * step).fract();
        let p = DVec3::new(at(0.8191725), at(0.6710436), at(0.5497005)) * dims.as_dvec3();
        let value = s.volume.sample_index(p - 0.5);
        let cell = (p.as_uvec3() / edge).min(cells - 1);
        let [max, min] = leaves[(cell.x + cells.x * (cell.y + cells.y * cell.z)) as usize];
        let sigma_t = if value.is_finite() {
            let entry =
                (value - table.min) / (table.max - table.min) * f64::from(table.entries - 1);
            let i = entry as usize;
            let next = baked[(i + 1).min(baked.len() - 1)][3];
            baked[i][3] + (next - baked[i][3]) * entry.fract() as f32
        } else {
            0.0
        };
        let room = 1e-5 * f32::from_bits(max);
        assert!(f32::from_bits(min) <= sigma_t + room, "{p}");
        assert!(sigma_t <= f32::from_bits(max) + room, "{p}");
        checked += u32::from(sigma_t > 0.0);
    }
    assert!(checked > 1000, "{checked}");
}

#[test]
fn shapes_and_noise_are_planned_where_a_scene_has_them() {
    let mut s = sparse();
    s.medium.transfer_function.primitives = vec![Primitive {
        shape: Shape::Gaussian,
        value: [10.0, 90.0],
        gradient: [0.0, 5.0],
        color: Vec3::ONE,
        opacity: 0.5,
    }];
    let still = Octave {
        frequency: 1.0,
        displacement: 0.0,
        opacity: 0.5,
        color: Vec3::ZERO,
        offset: DVec3::ZERO,
        velocity: DVec3::ZERO,
    };
    let moving = Octave {
        opacity: 0.0,
        displacement: 5.0,
        ..still
    };
    let noise = |octaves: &[Octave]| Perturbation {
        seed: 0,
        octaves: octaves.to_vec(),
        time: 0.0,
    };
    s.medium.perturbation = Some(noise(&[still, moving, moving]));
    let p = plan(&s, &LIMITS).unwrap();
    let found = constants(&p);
    for constant in [("GRADIENTS", 1), ("DISPLACED", 2), ("VARIED", 1)] {
        assert!(found.contains(&constant), "{constant:?} {found:?}");
    }
    assert!(has(&p, "noise") && has(&p, "gradient_table"));
    // Ten voxels are three cells further than without.
    let distance = p.stages.iter().find(|s| s.name == "medium.cell_distance");
    let values: Vec<_> = distance
        .unwrap()
        .specialization
        .iter()
        .map(|c| c.value)
        .collect();
    assert_eq!(values, [18, 3]);
    // Further than the volume is large.
    let far = Octave {
        displacement: 1e6,
        ..moving
    };
    s.medium.perturbation = Some(noise(&[far]));
    let p = plan(&s, &LIMITS).unwrap();
    assert!(left_out(&p, "cells").unwrap().contains("too far"));
}

fn scattered(mut scene: Scene, cache: LightCache) -> Result<Plan, PlanError> {
    scene.technique = TechniqueParams::SingleScatter(SingleScatterParams {
        cache,
        ..SingleScatterParams::default()
    });
    plan(&scene, &LIMITS)
}

fn directional(count: usize) -> Vec<Light> {
    let light = |i| Light::Directional {
        direction: DVec3::new(1.0, i as f64, 2.0),
        irradiance: Vec3::ONE,
    };
    (0..count).map(light).collect()
}

fn extent_of(p: &Plan, name: &str) -> Option<UVec3> {
    let resource = p.resources.iter().find(|r| r.name == name);
    resource.map(|r| r.extent)
}

#[test]
fn single_scatter_keeps_depths_for_every_light_and_none_without() {
    let mut s = sparse();
    s.volume = Arc::new(volume(cube(200), ScalarType::U8, |i| f64::from(i.x)));
    s.lights = directional(3);
    let extent = |cache| extent_of(&scattered(s.clone(), cache).unwrap(), "light_depth");
    let full = UVec3::new(201, 201, 3 * 201);
    assert_eq!(extent(LightCache::Full), Some(full));
    let half = UVec3::new(101, 101, 3 * 101);
    assert_eq!(extent(LightCache::Half), Some(half));
    assert_eq!(extent(LightCache::None), None);
    s.clip.bounds = Some((DVec3::new(-100.0, -100.0, 0.0), DVec3::splat(100.0)));
    let kept = extent_of(
        &scattered(s.clone(), LightCache::Half).unwrap(),
        "light_depth",
    );
    assert_eq!(kept, Some(UVec3::new(101, 101, 3 * 51)), "half is clipped");
    s.lights = vec![Light::Environment {
        radiance: Vec3::ONE,
    }];
    let dark = scattered(s, LightCache::Half).unwrap();
    assert!(!has(&dark, "light_depth") && left_out(&dark, "light_depth").is_some());
    assert!(left_out(&dark, "environment lights").is_some());
    let caches = |s: &tyndall::technique::StagePlan| s.name.contains("light_cache");
    assert!(!dark.stages.iter().any(caches));
}

#[test]
fn single_scatter_says_what_helps_where_depths_do_not_fit() {
    let mut s = sparse();
    s.volume = Arc::new(volume(cube(128), ScalarType::U8, |i| f64::from(i.x)));
    s.lights = directional(32);
    let message = scattered(s.clone(), LightCache::Full)
        .unwrap_err()
        .to_string();
    assert!(
        message.contains("light_depth: 129 x 129 x 4128 nodes for 32 lights")
            && message.contains("cache = \"half\" or \"none\""),
        "{message}"
    );
    // Fits the image, not the memory.
    s.lights = directional(15);
    let limits = Limits {
        max_allocation: 100 << 20,
        ..LIMITS
    };
    let message = scattered(s.clone(), LightCache::Full)
        .unwrap()
        .check(&limits)
        .unwrap_err()
        .to_string();
    assert!(
        message.contains("cache = \"half\" or \"none\""),
        "{message}"
    );
    assert!(
        scattered(s, LightCache::Half)
            .unwrap()
            .check(&limits)
            .is_ok()
    );
}

fn occluded(mut scene: Scene, radius: Radius) -> Result<Plan, PlanError> {
    scene.technique = TechniqueParams::AmbientOcclusion(AmbientOcclusionParams {
        radius,
        ..AmbientOcclusionParams::default()
    });
    plan(&scene, &LIMITS)
}

#[test]
fn ambient_occlusion_is_made_where_an_environment_shines() {
    let mut s = sparse();
    let dark = occluded(s.clone(), Radius::Auto).unwrap();
    assert!(!has(&dark, "occlusion") && !has(&dark, "sums"));
    assert!(left_out(&dark, "occlusion").unwrap().contains("emission"));
    assert!(left_out(&dark, "directional and point lights").is_some());
    s.lights = vec![Light::Environment {
        radiance: Vec3::ONE,
    }];
    let p = occluded(s.clone(), Radius::Auto).unwrap();
    assert!(left_out(&p, "occlusion").is_none());
    assert!(left_out(&p, "directional and point lights").is_none());
    // 14 voxels: cells of two, a cell more where they do not divide the volume.
    assert_eq!(extent_of(&p, "occlusion"), Some(UVec3::splat(32)));
    let narrow = occluded(s.clone(), Radius::Voxels(4.0)).unwrap();
    assert_eq!(extent_of(&narrow, "occlusion"), Some(UVec3::splat(64)));
    let wide = occluded(s.clone(), Radius::World(1e6)).unwrap();
    assert_eq!(extent_of(&wide, "occlusion"), Some(UVec3::splat(11)));
    let of = |name: &str| p.stages.iter().find(|s| s.name == name).unwrap().depends_on;
    for name in [
        "summed_area.extinction",
        "summed_area.scan_subgroup",
        "summed_area.scan_segments",
        "summed_area.occlusion",
    ] {
        let made = of(name);
        assert!(made.contains(Input::Volume) && made.contains(Input::Clip));
        assert!(!made.contains(Input::Camera) && !made.contains(Input::Light));
    }
    assert!(of("ambient_occlusion.march").contains(Input::Camera));
    let sums = p.resources.iter().find(|r| r.name == "sums").unwrap();
    assert_eq!(sums.kind, ResourceKind::Staging);
}

/// Name and dispatches of the stages that make running sums of the occlusion of `volume`.
fn scans(volume: UVec3, limits: &Limits) -> Vec<(&'static str, u32)> {
    let mut s = sparse();
    let grid = Grid::centred(volume, DVec3::ONE);
    s.volume = Arc::new(common::volume(grid, ScalarType::U8, |i| f64::from(i.x)));
    let medium = MediumPlan::new(&s, None, limits).unwrap();
    let field = FieldPlan::new(&s, &medium, FieldKind::Occlusion, 2.0, limits).unwrap();
    let stages = field.stages().into_iter();
    let scans = stages.filter(|s| s.name.contains(".scan"));
    scans.map(|s| (s.name, s.dispatches)).collect()
}

#[test]
fn running_sums_are_made_in_the_form_that_suits_the_device() {
    let dims = UVec3::new(40, 20, 30);
    let parallel = [
        ("summed_area.scan_subgroup", 2),
        ("summed_area.scan_segments", 4),
    ];
    assert_eq!(scans(dims, &LIMITS), parallel, "a discrete GPU");
    let lavapipe = Limits {
        worker_threads: 2,
        prefers_loads: true,
        prefers_subgroups: false,
        ..LIMITS
    };
    assert_eq!(scans(dims, &lavapipe), [("summed_area.scan", 6)]);
    let poor = Limits {
        prefers_subgroups: false,
        ..LIMITS
    };
    assert_eq!(
        scans(dims, &poor),
        [("summed_area.scan", 6)],
        "a GPU that does not add over subgroups"
    );
}

#[test]
fn a_scan_covers_every_line_along_its_axis() {
    let cells = UVec3::new(5, 70, 900);
    for form in [ScanForm::Serial, ScanForm::Parallel] {
        let axes: Vec<_> = form.stages().iter().flat_map(|(_, axes)| *axes).collect();
        assert_eq!(axes, [&0, &1, &2]);
        for axis in 0..3 {
            let lines = cells.element_product() / cells[axis];
            let invocations = form.domain(axis, cells).element_product();
            let a_line = if form == ScanForm::Parallel && axis == 0 {
                32
            } else {
                1
            };
            assert_eq!(invocations, a_line * lines, "{form:?}, {axis}");
        }
    }
}

#[test]
fn ambient_occlusion_says_what_helps_where_a_ray_has_too_many_samples() {
    let mut s = sparse();
    s.technique = TechniqueParams::AmbientOcclusion(AmbientOcclusionParams {
        step: 1.0 / 64.0,
        ..AmbientOcclusionParams::default()
    });
    assert!(plan(&s, &LIMITS).is_ok());
    s.volume = Arc::new(volume(cube(300), ScalarType::U8, |i| f64::from(i.x)));
    let message = plan(&s, &LIMITS).unwrap_err().to_string();
    assert!(message.contains("raise the step to at least"), "{message}");
}

fn swept(mut scene: Scene, params: HalfAngleParams) -> Result<Plan, PlanError> {
    scene.technique = TechniqueParams::HalfAngle(params);
    plan(&scene, &LIMITS)
}

#[test]
fn half_angle_has_two_light_buffers_and_an_eye_buffer_beside_the_volume() {
    let mut s = sparse();
    s.lights = directional(1);
    let p = swept(s.clone(), HalfAngleParams::default()).unwrap();
    let buffer = extent_of(&p, "light_buffer").unwrap();
    assert_eq!(extent_of(&p, "light_buffer_pong"), Some(buffer));
    // A cube of 64 voxels from aside: a texel a voxel.
    assert!((64..=112).contains(&buffer.x.max(buffer.y)), "{buffer}");
    let pixels = UVec3::new(s.image.width, s.image.height, 1);
    assert_eq!(extent_of(&p, "eye_buffer"), Some(pixels));
    let own = |r: &&tyndall::technique::ResourcePlan| {
        ["light_buffer", "light_buffer_pong", "eye_buffer"].contains(&r.name)
    };
    let bytes: u64 = p.resources.iter().filter(own).map(|r| r.bytes).sum();
    let texels = 2 * buffer.element_product() + pixels.element_product();
    assert_eq!(bytes, 16 * u64::from(texels));
    s.lights = vec![Light::Environment {
        radiance: Vec3::ONE,
    }];
    let dark = swept(s, HalfAngleParams::default()).unwrap();
    assert_eq!(extent_of(&dark, "light_buffer"), Some(UVec3::ONE));
    assert!(left_out(&dark, "propagate").is_some());
    assert!(left_out(&dark, "environment lights").is_some());
    let propagates = |s: &tyndall::technique::StagePlan| s.name.contains("propagate");
    assert!(!dark.stages.iter().any(propagates));
}

fn half_angle_plan(s: &Scene, params: &HalfAngleParams) -> HalfAnglePlan {
    half_angle::plan(s, params, &LIMITS).unwrap()
}

#[test]
fn slices_lie_half_way_between_light_and_view_or_inverted_view() {
    let mut s = sparse();
    let params = HalfAngleParams::default();
    // The view goes along +y.
    for degrees in [0.0, 30.0, 89.9, 90.1, 150.0, 180.0_f64] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let direction = DVec3::new(sin, cos, 0.0);
        s.lights = vec![Light::Directional {
            direction,
            irradiance: Vec3::ONE,
        }];
        let sweep = half_angle_plan(&s, &params).sweeps.remove(0);
        let view = if degrees < 90.0 { DVec3::Y } else { -DVec3::Y };
        let half = (direction + view).normalize();
        assert!(
            sweep.axis.distance(half) < 1e-9,
            "{degrees}: {}",
            sweep.axis
        );
        assert_eq!(sweep.front_to_back, degrees < 90.0);
        // The cube's extent along the axis, a voxel a slice.
        let extent = 64.0 * half.abs().element_sum();
        assert_eq!(f64::from(sweep.slices), (extent - 1e-4).ceil(), "{degrees}");
    }
}

#[test]
fn a_slice_covers_its_own_pixels_and_texels_and_those_of_the_slice_before() {
    let mut s = sparse();
    s.lights = vec![Light::Directional {
        direction: DVec3::X,
        irradiance: Vec3::ONE,
    }];
    (s.image.width, s.image.height) = (128, 128);
    let plan = half_angle_plan(&s, &HalfAngleParams::default());
    let slices: Vec<_> = plan.sweeps[0].schedule(&plan.lens).collect();
    // Seen at 45 degrees, slabs across an edge of the cube are narrow, the one through its middle is all of it:
    // 64 voxels of 128 / 110.9 pixels, and a margin.
    let middle = slices.len() / 2;
    for (i, expected) in [(0, 3..=6), (middle, 72..=78), (slices.len() - 1, 3..=6)] {
        let size = slices[i].pixels.size();
        assert!(expected.contains(&size.x), "{i}: {size}");
        assert!((74..=78).contains(&size.y), "{i}: {size}");
        assert!(!slices[i].texels.is_empty());
    }
    for (slice, before) in slices.iter().skip(1).zip(&slices) {
        // Light that left the slice before at its far face is carried over.
        let joint = slice.texels.low.min(before.texels.high) == slice.texels.low;
        assert!(joint && slice.texels.size().max_element() >= 64);
    }
    let faces = |i: usize| slices[i].faces;
    assert!((1..slices.len()).all(|i| faces(i)[0] == faces(i - 1)[1]));
    assert_eq!(faces(0)[0], f32::NEG_INFINITY);
    assert_eq!(faces(slices.len() - 1)[1], f32::INFINITY);
}

#[test]
fn a_point_light_has_one_frustum_or_the_faces_of_a_cube() {
    let mut s = sparse();
    let frusta = |s: &Scene| half_angle_plan(s, &HalfAngleParams::default()).sweeps.len();
    for (position, expected) in [
        (DVec3::new(0.0, -200.0, 0.0), 1),
        (DVec3::new(100.0, -100.0, 30.0), 1),
        (DVec3::ZERO, 6),
        (DVec3::new(3.0, 1.0, 2.0), 6),
        // On a face the volume is on one side only.
        (DVec3::new(32.0, 0.0, 0.0), 5),
    ] {
        s.lights = vec![Light::Point {
            position,
            intensity: Vec3::ONE,
            falloff: tyndall::scene::Falloff::InverseSquare,
        }];
        assert_eq!(frusta(&s), expected, "{position}");
        for sweep in half_angle_plan(&s, &HalfAngleParams::default()).sweeps {
            let rays = sweep.light.unwrap().corner_rays();
            let obliquest = rays
                .map(|w| w.dot(sweep.axis))
                .into_iter()
                .fold(1.0, f64::min);
            assert!(obliquest >= 0.25, "{position}: {obliquest}");
        }
    }
}

#[test]
fn half_angle_refuses_more_slices_than_a_shader_has_rounds() {
    let mut s = sparse();
    s.volume = Arc::new(volume(cube(700), ScalarType::U8, |_| 0.0));
    let params = HalfAngleParams {
        slice_spacing: 1.0 / 64.0,
        ..HalfAngleParams::default()
    };
    let message = swept(s, params).unwrap_err().to_string();
    assert!(
        message.contains("half_angle.slice_spacing") && message.contains("raise the spacing"),
        "{message}"
    );
}

#[test]
fn a_height_field_needs_no_volume() {
    let map = HeightMap {
        name: "steep".to_owned(),
        dims: glam::UVec2::new(600, 500),
        voxels: Voxels::U16((0..300_000).map(|i| (i % 600) as u16).collect()),
        rescale: Rescale::IDENTITY,
        spacing: None,
        spatial_unit: None,
    };
    let sheet = Sheet {
        size: glam::DVec2::new(6.0, 5.0),
        height: 0.05,
        layer: Layer {
            bottom: -0.1,
            top: 0.0,
            ramp: 0.05,
        },
        margin: 0.0,
    };
    let mut s = scene(map.volume(None, &sheet).unwrap(), constant(Vec3::ONE, 0.5));
    let dims = s.volume.grid.dims;
    // Higher than 3D images may be, which none is.
    assert!(dims.z > LIMITS.max_image_3d, "{dims}");
    let plan = MediumPlan::new(&s, None, &LIMITS).unwrap();
    assert_eq!(plan.stored, UVec3::new(600, 500, 1));
    let cells = plan.cells.unwrap();
    assert!(
        cells.size > 4 && cells.dims.element_product() <= 1 << 20,
        "{cells:?}"
    );
    let of = |name: &str| plan.resources().into_iter().find(|r| r.name == name);
    assert_eq!(of("volume").unwrap().bytes, 2 * 300_000);
    assert_eq!(of("surface_heights").unwrap().bytes, 4 * 300_000);
    assert!(plan.omitted().iter().all(|o| o.what != "surface_heights"));
    let limits = Limits {
        max_image_3d: 512,
        ..LIMITS
    };
    let message = MediumPlan::new(&s, None, &limits).unwrap_err().to_string();
    assert!(
        message.contains("raise volume.height_field.level"),
        "{message}"
    );
    // A volume has none.
    s.volume = Arc::new(volume(cube(4), ScalarType::U8, |_| 1.0));
    let plan = MediumPlan::new(&s, None, &LIMITS).unwrap();
    assert!(plan.omitted().iter().any(|o| o.what == "surface_heights"));
}
