//! Which stages run after which change, that every barrier is needed, and that the device holds
//! what the plan says.
#![allow(clippy::unwrap_used, clippy::panic)]

mod common;

use std::sync::Arc;

use common::{cube, device, points, scene, volume, with};
use glam::{DVec3, Vec3};
use tyndall::gpu::{Device, GpuError};
use tyndall::scene::{HalfAngleParams, Light, Scene, Shading, TechniqueParams};
use tyndall::technique::{RenderError, Renderer, ResourceKind, ResourcePlan};
use tyndall::volume::ScalarType;

fn lit_scene() -> Scene {
    let v = volume(cube(20), ScalarType::U16, |i| f64::from(i.x * i.y * i.z));
    let tf = points(&[
        (0.0, Vec3::ONE, 0.0),
        (900.0, Vec3::ONE, 0.0),
        (7000.0, Vec3::ONE, 0.5),
    ]);
    with(scene(v, tf), |p| p.shading = Some(Shading::default()))
}

/// Stages that run for `next` after `renderer` has rendered something else.
fn ran(renderer: &mut Renderer, next: Scene) -> Vec<String> {
    renderer.set_scene(next).unwrap();
    let (_, report) = renderer.render(&mut |_, _, _| {}).unwrap();
    report.stages.into_iter().map(|s| s.name).collect()
}

const TABLE: [&str; 3] = [
    "medium.upload_table",
    "medium.cell_occupancy",
    "medium.cell_distance",
];
/// Names of the last two stages: how the volume is read depends on the device.
fn march(renderer: &Renderer) -> [&'static str; 2] {
    let stages = &renderer.plan().stages;
    let name = stages[stages.len() - 2].name;
    assert!(name.starts_with("ray_march.march"), "{name}");
    [name, "ray_march.read_back"]
}

#[test]
fn a_change_runs_only_what_depends_on_it() {
    let device = device();
    let base = lit_scene();
    let mut renderer = Renderer::new(&device, base.clone()).unwrap();
    let march_stages = march(&renderer);
    let everything = [
        "medium.upload_volume",
        "medium.cell_min_max",
        "medium.upload_table",
        "medium.cell_occupancy",
        "medium.cell_distance",
        march_stages[0],
        march_stages[1],
    ];
    assert_eq!(ran(&mut renderer, base.clone()), everything, "first frame");
    assert!(
        ran(&mut renderer, base.clone()).is_empty(),
        "nothing changed"
    );

    let mut s = base.clone();
    s.camera = s.camera.orbit(10.0);
    assert_eq!(ran(&mut renderer, s.clone()), march_stages, "camera");
    s.lights = vec![Light::Environment {
        radiance: Vec3::ONE,
    }];
    assert_eq!(ran(&mut renderer, s.clone()), march_stages, "light");
    s.medium.phase_g = 0.5;
    assert!(
        ran(&mut renderer, s.clone()).is_empty(),
        "phase: emission-absorption does not scatter"
    );
    s.medium.density_scale = 2.0;
    assert_eq!(
        ran(&mut renderer, s.clone()),
        [&TABLE[..], &march_stages].concat(),
        "transfer function"
    );
    s.image.width = 40;
    assert_eq!(ran(&mut renderer, s.clone()), march_stages, "image");
    s.clip.bounds = Some((DVec3::splat(-5.0), DVec3::splat(5.0)));
    assert_eq!(ran(&mut renderer, s.clone()), march_stages, "clip");
    s = with(s, |p| p.step = 0.7);
    assert_eq!(ran(&mut renderer, s.clone()), march_stages, "parameters");
    s = with(s, |p| p.shading = None);
    ran(&mut renderer, s.clone());
    s.lights = vec![Light::Environment {
        radiance: Vec3::splat(0.5),
    }];
    assert!(
        ran(&mut renderer, s.clone()).is_empty(),
        "light, which nothing shows without shading"
    );
    s.volume = Arc::new((*s.volume).clone());
    let mut but_the_table = everything.to_vec();
    but_the_table.retain(|name| *name != "medium.upload_table");
    assert_eq!(ran(&mut renderer, s), but_the_table, "volume");
}

#[test]
fn a_changed_scene_shows_what_a_fresh_one_shows() {
    let device = device();
    let base = lit_scene();
    let mut renderer = Renderer::new(&device, base.clone()).unwrap();
    renderer.render(&mut |_, _, _| {}).unwrap();
    let mut opaque = base.clone();
    opaque.medium.transfer_function = points(&[(0.0, Vec3::ONE, 0.2)]);
    let mut float = base.clone();
    float.volume = Arc::new(volume(cube(9), ScalarType::F32, |i| f64::from(i.x * 800)));
    float.statistics = Arc::new(tyndall::volume::Statistics::of(&float.volume));
    let mut wide = base.clone();
    (wide.image.width, wide.image.height) = (50, 20);
    for (what, next) in [
        ("no empty value", opaque),
        ("another volume", float),
        ("another size", wide),
        ("back", base),
    ] {
        renderer.set_scene(next.clone()).unwrap();
        let (image, _) = renderer.render(&mut |_, _, _| {}).unwrap();
        assert_eq!(image, common::render_beside(&device, &next), "{what}");
    }
}

#[test]
fn every_barrier_that_orders_two_stages_is_missed_when_left_out() {
    // Software drivers run in order, so that only validation can tell. Barriers are numbered within
    // a submission; the ones of the cells are the longest chain.
    let mut caught = 0;
    for index in 0..8 {
        let mut device = device();
        // The last barrier orders the cells before the march of the next submission, where validation
        // does not look; it sees the layout that sampling needs.
        device.prefer_filter();
        device.omit_barrier(Some(index));
        let mut renderer = Renderer::new(&device, lit_scene()).unwrap();
        match renderer.render(&mut |_, _, _| {}) {
            Err(RenderError::Gpu(GpuError::Validation(messages))) => {
                assert!(!messages.is_empty());
                caught += 1;
            }
            Err(other) => panic!("barrier {index}: {other}"),
            Ok(_) => {}
        }
    }
    assert_eq!(
        caught, 8,
        "each of the eight barriers of the longest submission is needed"
    );
}

#[test]
fn a_hazard_between_two_dispatches_is_a_failure() {
    // Leaving out barrier 3 (RAW and WAR between the passes along x and y) is a hazard by its name.
    let device = device();
    device.omit_barrier(Some(3));
    let mut renderer = Renderer::new(&device, lit_scene()).unwrap();
    let Err(RenderError::Gpu(GpuError::Validation(messages))) = renderer.render(&mut |_, _, _| {})
    else {
        panic!("validation did not see the missing barrier");
    };
    assert!(
        messages
            .iter()
            .any(|m| m.contains("SYNC-HAZARD") || m.contains("layout")),
        "{messages:?}"
    );
}

/// Four slices of a small volume, light and view at an angle.
fn sliced_scene() -> Scene {
    let v = volume(cube(4), ScalarType::U8, |i| f64::from(i.x + i.y));
    let mut s = scene(v, points(&[(0.0, Vec3::ONE, 0.1), (6.0, Vec3::ONE, 0.5)]));
    (s.image.width, s.image.height) = (8, 8);
    s.technique = TechniqueParams::HalfAngle(HalfAngleParams {
        slice_spacing: 32.0,
        light_buffer: Some(8),
        ..HalfAngleParams::default()
    });
    s
}

#[test]
fn the_barriers_between_slices_are_missed_when_left_out() {
    const RAW: &str = "READ-AFTER-WRITE";
    const WAR: &str = "WRITE-AFTER-READ";
    const WAW: &str = "WRITE-AFTER-WRITE";
    // Six barriers around the three clears, then each slice's three: the eye buffer's, the light buffer's that
    // was read and that of the one written. Not here: those before a clear and before `compose` reads the
    // image, which face earlier submissions, where validation does not look; those of the eye buffer between
    // slices (6, 9, 12), as validation takes storage images that are read and written for written alone and
    // reports no write after another of two dispatches; the last one read (13), which no slice writes again.
    let needed = [
        (1, RAW, "light_buffer"),
        (3, WAW, "light_buffer_pong"),
        (5, WAW, "eye_buffer"),
        (7, WAR, "light_buffer"),
        (8, RAW, "light_buffer_pong"),
        (10, WAR, "light_buffer_pong"),
        (11, RAW, "light_buffer"),
        (14, RAW, "light_buffer_pong"),
        (15, RAW, "eye_buffer"),
    ];
    let base = sliced_scene();
    let mut brighter = base.clone();
    for light in &mut brighter.lights {
        let Light::Directional { irradiance, .. } = light else {
            panic!("not directional");
        };
        *irradiance *= 2.0;
    }
    for (index, hazard, image) in needed {
        let device = device();
        let mut renderer = Renderer::new(&device, base.clone()).unwrap();
        renderer.render(&mut |_, _, _| {}).unwrap();
        // Of what a light's colour changes, the sweep is the only submission with so many barriers.
        renderer.set_scene(brighter.clone()).unwrap();
        device.omit_barrier(Some(index));
        let Err(RenderError::Gpu(GpuError::Validation(messages))) =
            renderer.render(&mut |_, _, _| {})
        else {
            panic!("barrier {index} of {image} is not missed");
        };
        let (hazard, image) = (format!("SYNC-HAZARD-{hazard}"), format!("[{image}]"));
        let found = |m: &String| m.contains(&hazard) && m.contains(&image);
        assert!(messages.iter().any(found), "{index}: {messages:?}");
    }
}

#[test]
fn the_device_holds_what_the_plan_says_and_nothing_after() {
    let device = device();
    let mut renderer = Renderer::new(&device, lit_scene()).unwrap();
    assert!(named(&device).is_empty(), "a plan allocates nothing");
    renderer.render(&mut |_, _, _| {}).unwrap();
    let live = named(&device);
    let lasting = |r: &&ResourcePlan| r.kind != ResourceKind::Staging;
    for resource in renderer.plan().resources.iter().filter(lasting) {
        let bytes = live
            .iter()
            .find(|(name, _)| name == resource.name)
            .map(|(_, bytes)| *bytes);
        assert!(
            bytes.is_some_and(|b| b >= resource.bytes),
            "{}: {bytes:?}",
            resource.name
        );
    }
    drop(renderer);
    assert!(named(&device).is_empty(), "{:?}", named(&device));
}

fn named(device: &Device) -> Vec<(String, u64)> {
    device
        .live_allocations()
        .into_iter()
        .map(|a| (a.name, a.bytes))
        .collect()
}

#[test]
fn a_scene_beyond_the_heap_is_refused_before_anything_is_allocated() {
    let device = device();
    let plan = Renderer::new(&device, lit_scene()).unwrap();
    let mut limits = device.info().limits;
    limits.heap_bytes = 1000;
    let message = plan.plan().check(&limits).unwrap_err().to_string();
    assert!(
        message.contains("transfer_function 16.384 kB (widen the transfer"),
        "{message}"
    );
    assert!(named(&device).is_empty());
}
