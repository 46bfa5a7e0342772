//! Ambient occlusion against its equations on the CPU, its limits, and what it stands for: the mean over
//! directions.
#![allow(clippy::unwrap_used, clippy::expect_used)]

mod common;

use std::path::Path;
use std::sync::Arc;

use common::{assert_close, constant, cube, device, points, render, scene, volume};
use glam::{DVec2, DVec3, DVec4, UVec3, Vec3};
use rayon::prelude::*;
use tyndall::gpu::Device;
use tyndall::output::Image;
use tyndall::scene::file::{Override, SceneFile};
use tyndall::scene::{
    AmbientOcclusionParams, Light, PathTraceParams, Plane, Projection, Radius, Scene,
    TechniqueParams,
};
use tyndall::technique::Renderer;
use tyndall::technique::ambient_occlusion::reference;
use tyndall::technique::medium::MediumPlan;
use tyndall::technique::summed_area::{FieldKind, FieldPlan, occlusion_radius, probe};
use tyndall::volume::{ColorVolume, Grid, ScalarType};

/// No early end, so that only steps, levels and looks differ from the equations.
fn params(step: f64, radius: f64) -> AmbientOcclusionParams {
    AmbientOcclusionParams {
        step,
        radius: Radius::Voxels(radius),
        early_termination: 1.0,
        empty_space_skipping: true,
    }
}

fn with_params(scene: &Scene, params: AmbientOcclusionParams) -> Scene {
    Scene {
        technique: TechniqueParams::AmbientOcclusion(params),
        ..scene.clone()
    }
}

const SKY: Vec3 = Vec3::new(0.5, 1.0, 2.0);

fn sky() -> Vec<Light> {
    vec![Light::Environment { radiance: SKY }]
}

/// A homogeneous cube of edge 8, optical depth `tau` along it, filling an orthographic image.
fn homogeneous(tau: f64) -> Scene {
    let mut s = scene(
        volume(cube(8), ScalarType::U8, |_| 1.0),
        constant(Vec3::ONE, -(-tau / 8.0).exp_m1()),
    );
    s.camera.projection = Projection::Orthographic { height: 8.0 };
    (s.image.width, s.image.height) = (16, 16);
    s.medium.albedo = 0.9;
    s.lights = sky();
    s
}

/// A smooth blob, anisotropic voxels, colours by value.
fn blob() -> Scene {
    let grid = Grid::centred(UVec3::new(20, 24, 16), DVec3::new(1.2, 1.0, 1.5));
    let v = volume(grid, ScalarType::F32, |i| {
        let p = (i.as_dvec3() + 0.5) / DVec3::new(20.0, 24.0, 16.0) - 0.5;
        1000.0 * (-p.length_squared() * 20.0).exp()
    });
    let mut s = scene(
        v,
        points(&[
            (0.0, Vec3::new(0.2, 0.9, 0.4), 0.0),
            (500.0, Vec3::new(0.9, 0.6, 0.3), 0.2),
            (1000.0, Vec3::ONE, 0.4),
        ]),
    );
    (s.image.width, s.image.height) = (24, 24);
    s.medium.albedo = 0.95;
    s.medium.emission = 0.1;
    s.image.background = Vec3::splat(1e-2);
    s.lights.extend(sky());
    s
}

fn field_plan(device: &Device, s: &Scene, radius: f64) -> FieldPlan {
    let limits = device.info().limits;
    let medium = MediumPlan::new(s, None, &limits).unwrap();
    FieldPlan::new(s, &medium, FieldKind::Occlusion, radius, &limits).unwrap()
}

/// The equations with a step of 1/16 voxel.
fn truth(device: &Device, s: &Scene, radius: f64) -> Vec<DVec4> {
    let world = occlusion_radius(s, Radius::Voxels(radius));
    let occlusion = reference::Occlusion::new(s, &field_plan(device, s, world));
    let fine = params(1.0 / 16.0, radius);
    let size = UVec3::new(s.image.width, s.image.height, 1);
    let pixel = |i: u32| {
        let centre = DVec2::new((i % size.x).into(), (i / size.x).into()) + 0.5;
        let at = centre / DVec2::new(size.x.into(), size.y.into());
        reference::march(s, &fine, &occlusion, at)
    };
    (0..size.element_product())
        .into_par_iter()
        .map(pixel)
        .collect()
}

/// Root mean square difference of the radiance over the mean.
fn error(image: &Image, truth: &[DVec4]) -> f64 {
    let squares = image.pixels.iter().zip(truth).map(|(a, b)| {
        let found = DVec3::new(a[0].into(), a[1].into(), a[2].into());
        (found - b.truncate()).length_squared()
    });
    let mean: f64 = truth.iter().map(|p| p.truncate().element_sum()).sum();
    (squares.sum::<f64>() * 3.0 * truth.len() as f64).sqrt() / mean
}

fn mean(image: &Image) -> f64 {
    let sum = |p: &[f32; 4]| p[..3].iter().map(|c| f64::from(*c)).sum::<f64>() / 3.0;
    image.pixels.iter().map(sum).sum::<f64>() / image.pixels.len() as f64
}

#[test]
fn a_blob_under_a_sky_is_the_equations() {
    let device = device();
    let plain = blob();
    let mut clipped = plain.clone();
    clipped.clip.bounds = Some((DVec3::splat(-8.0), DVec3::new(5.0, 9.0, 9.0)));
    let mut cut = plain.clone();
    cut.clip.plane = Some(Plane {
        point: DVec3::new(0.0, -1.0, 0.0),
        normal: DVec3::new(0.3, 1.0, 0.2).normalize(),
    });
    let mut colored = plain.clone();
    let dims = plain.volume.grid.dims;
    let color = |i: u32| [(i % dims.x) as f32 / dims.x as f32, 0.25, 1.0];
    let colors: Vec<_> = (0..dims.element_product()).map(color).collect();
    colored.medium.albedo_volume = Some(Arc::new(ColorVolume::new("colors", dims, &colors)));
    for (what, s) in [
        ("plain", plain),
        ("clipped", clipped),
        ("cut", cut),
        ("colored", colored),
    ] {
        for radius in [2.0, 5.0, 12.0] {
            let expected = truth(&device, &s, radius);
            let at = |step| {
                error(
                    &render(&device, &with_params(&s, params(step, radius))),
                    &expected,
                )
            };
            let found = [0.5, 0.25, 0.125].map(at);
            println!("{what}, radius {radius}: {found:.4?}");
            // Looks are four samples apart: two voxels at first, too far for a body of ten with a surface cut
            // through it, and half a voxel at last. So few voxels are split into cells, and the cut's edge is as
            // sharp as those: 0.0063 is left there, of which halving the step takes about three quarters.
            assert!(found[0] < 0.1, "{what}, radius {radius}: {found:?}");
            assert!(found[2] < 7e-3, "{what}, radius {radius}: {found:?}");
            let order = found[2] < 0.5 * found[1] || found[2] < 2e-3;
            assert!(order, "{what}, radius {radius}: {found:?}");
        }
    }
}

#[test]
fn without_occluder_all_of_the_sky_arrives() {
    let device = device();
    for tau in [1e-3, 0.5, 20.0] {
        // Within a sixty-fourth of a voxel nothing dims.
        let s = with_params(&homogeneous(tau), params(1.0, 1.0 / 64.0));
        let image = render(&device, &s);
        let seen = 0.9 * -(-tau).exp_m1();
        let near = tau / 8.0 / 64.0;
        for (channel, sky) in SKY.to_array().into_iter().enumerate() {
            let found = f64::from(common::centre(&image)[channel]);
            // Half floats just below 1, and what the radius itself holds.
            assert_close("sky", found, seen * f64::from(sky), 5e-4 + near);
        }
    }
}

/// A faint core in a dense, black shell, seen from inside the shell.
fn enclosed(shell: f64) -> Scene {
    let v = volume(cube(33), ScalarType::U8, |i| {
        let r = (i.as_dvec3() - 16.0).length();
        if r < 3.0 {
            100.0
        } else if (8.0..14.0).contains(&r) {
            200.0
        } else {
            0.0
        }
    });
    let rows = [
        (0.0, Vec3::ONE, 0.0),
        (60.0, Vec3::ONE, 0.0),
        (100.0, Vec3::ONE, 0.05),
        (140.0, Vec3::ONE, 0.0),
        (141.0, Vec3::ZERO, 0.0),
        (199.0, Vec3::ZERO, 0.0),
        (200.0, Vec3::ZERO, shell),
    ];
    let mut s = scene(v, points(&rows));
    s.camera.eye = DVec3::new(0.0, -7.0, 0.0);
    s.camera.projection = Projection::Orthographic { height: 1.0 };
    s.lights = sky();
    s
}

#[test]
fn what_is_enclosed_is_dark_and_the_darker_the_wider_one_looks() {
    let device = device();
    let at = |shell, radius| {
        let s = with_params(&enclosed(shell), params(0.5, radius));
        f64::from(common::centre(&render(&device, &s))[1])
    };
    let (open, closed) = (at(0.0, 16.0), at(0.99, 16.0));
    println!("{closed} of {open}");
    // Boxes reach past a shell's outside, and leave the corners there free.
    assert!(closed < 0.2 * open, "{closed} of {open}");
    assert_close("out of reach", at(0.99, 4.0), at(0.0, 4.0), 1e-3);
    let means = [1.0, 2.0, 4.0, 8.0, 12.0].map(|r| {
        let image = render(&device, &with_params(&blob(), params(0.5, r)));
        mean(&image)
    });
    println!("{means:.4?}");
    assert!(means.windows(2).all(|m| m[1] < m[0]), "{means:?}");
}

#[test]
fn lamps_do_not_light_and_without_a_sky_only_emission_shows() {
    let device = device();
    let mut s = with_params(&blob(), params(0.5, 4.0));
    let both = render(&device, &s);
    s.lights = sky();
    assert_eq!(render(&device, &s), both, "the lamp");
    s.lights.clear();
    s.image.background = Vec3::ZERO;
    s.medium.albedo = 0.0;
    let emitted = render(&device, &s);
    s.medium.albedo = 1.0;
    assert_eq!(render(&device, &s), emitted, "albedo");
    s.medium.emission = 0.0;
    assert_eq!(mean(&render(&device, &s)), 0.0);
    assert!(mean(&emitted) > 1e-3);
}

#[test]
fn loads_and_the_devices_filter_give_one_image() {
    let loading = device();
    if !loading.info().limits.prefers_loads {
        println!("skipped: {} filters", loading.info().name);
        return;
    }
    let mut filtering = device();
    filtering.prefer_filter();
    let s = with_params(&blob(), params(0.5, 4.0));
    let (a, b) = (render(&loading, &s), render(&filtering, &s));
    let channels = a.pixels.iter().flatten().zip(b.pixels.iter().flatten());
    let largest = channels.map(|(x, y)| (x - y).abs()).fold(0.0, f32::max);
    // Positions and weights are rounded differently, 2e-5 in volume and table each, and a look may begin at
    // another sample.
    assert!(largest < 2e-3, "{largest}");
}

/// Stages that run for `next` after `renderer` has rendered something else, without those of the medium.
fn ran(renderer: &mut Renderer, next: &Scene) -> Vec<String> {
    renderer.set_scene(next.clone()).unwrap();
    let (_, report) = renderer.render(&mut |_, _, _| {}).unwrap();
    let names = report.stages.into_iter().map(|s| s.name);
    names.filter(|n| !n.starts_with("medium.")).collect()
}

#[test]
fn occlusion_is_made_when_what_it_holds_changes_and_not_before() {
    let device = device();
    let base = with_params(&blob(), params(0.5, 4.0));
    let mut renderer = Renderer::new(&device, base.clone()).unwrap();
    let stages = renderer.plan().stages.iter().map(|s| s.name);
    let own: Vec<_> = stages.filter(|n| !n.starts_with("medium.")).collect();
    let everything = own.clone();
    assert!(own[2] == "summed_area.occlusion" && own[3].starts_with("ambient_occlusion.march"));
    let march = &own[3..];
    assert_eq!(ran(&mut renderer, &base), everything, "first frame");
    assert!(ran(&mut renderer, &base).is_empty(), "nothing");
    let mut s = base;
    s.camera = s.camera.orbit(10.0);
    assert_eq!(ran(&mut renderer, &s), march, "camera");
    s.medium.albedo = 0.5;
    assert_eq!(ran(&mut renderer, &s), march, "albedo");
    s.lights = sky();
    assert_eq!(ran(&mut renderer, &s), march, "light");
    s.image.width = 40;
    assert_eq!(ran(&mut renderer, &s), march, "image");
    s = with_params(&s, params(0.7, 4.0));
    assert_eq!(ran(&mut renderer, &s), march, "step");
    s = with_params(&s, params(0.7, 6.0));
    assert_eq!(ran(&mut renderer, &s), everything, "radius");
    s.medium.density_scale = 2.0;
    assert_eq!(ran(&mut renderer, &s), everything, "transfer function");
    s.clip.bounds = Some((DVec3::splat(-5.0), DVec3::splat(5.0)));
    assert_eq!(ran(&mut renderer, &s), everything, "clip");
    s.volume = Arc::new((*s.volume).clone());
    assert_eq!(ran(&mut renderer, &s), everything, "volume");
    let sky = std::mem::take(&mut s.lights);
    assert_eq!(ran(&mut renderer, &s), march, "no sky");
    s.lights = sky;
    assert_eq!(ran(&mut renderer, &s), everything, "the sky again");
    let (image, _) = renderer.render(&mut |_, _, _| {}).unwrap();
    assert_eq!(image, common::render_beside(&device, &s), "a fresh one");
}

fn asset(name: &str, overrides: &[&str]) -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("assets/scenes/{name}.toml"));
    let parsed: Vec<_> = overrides
        .iter()
        .map(|o| Override::parse(o).unwrap())
        .collect();
    let file = SceneFile::load(&path, &parsed).unwrap();
    file.resolve(&mut |_, _, _| {}).unwrap()
}

#[test]
#[ignore = "prints the figures of the technique's README"]
fn figures_against_the_mean_over_directions() {
    let device = device();
    for (name, overrides) in [
        ("cloud", ["volume.procedural.resolution=96"]),
        ("mechanical_part", ["volume.procedural.resolution=96"]),
    ] {
        let s = asset(name, &overrides);
        let voxel = s.volume.grid.spacing().min_element();
        for voxels in [4.0, 8.0, 14.0] {
            let radius = voxels * voxel;
            let (plan, texels, _) = probe(&device, &s, FieldKind::Occlusion, radius).unwrap();
            let n = plan.area.cells;
            let extinctions = tyndall::technique::summed_area::reference::cell_extinctions(
                &s,
                plan.area.cell,
                plan.area.split,
            );
            // Cells where there is medium to light; by how much of it is seen.
            let there: Vec<_> = (0..texels.len())
                .filter(|i| extinctions[*i] > 0.0)
                .collect();
            let stride = (there.len() / 600).max(1);
            let chosen: Vec<_> = there.into_iter().step_by(stride).collect();
            let pairs: Vec<_> = chosen
                .par_iter()
                .map(|&i| {
                    let j = u32::try_from(i).unwrap();
                    let cell = UVec3::new(j % n.x, j / n.x % n.y, j / (n.x * n.y)).as_dvec3();
                    let p = (cell + 0.5) / n.as_dvec3() / plan.scale;
                    let x = s.volume.grid.world_from_texture().transform_point3(p);
                    let exact = reference::visibility(&s, x, radius, 256, 0.5 * voxel);
                    (f64::from(texels[i]), exact)
                })
                .collect();
            let count = pairs.len() as f64;
            let average = |f: &dyn Fn(&(f64, f64)) -> f64| pairs.iter().map(f).sum::<f64>() / count;
            let (found, exact) = (average(&|p| p.0), average(&|p| p.1));
            let rms = average(&|p| (p.0 - p.1).powi(2)).sqrt();
            let difference = found - exact;
            println!(
                "{name}, {voxels} voxels, {count} cells: boxes {found:.3}, directions {exact:.3}"
            );
            println!("  difference {difference:.3}, rms {rms:.3}");
        }
        let mut lit = s.clone();
        (lit.image.width, lit.image.height) = (160, 120);
        lit.image.background = Vec3::ZERO;
        lit.lights = sky();
        let occluded = |radius| {
            let p = AmbientOcclusionParams {
                radius: Radius::Voxels(radius),
                ..AmbientOcclusionParams::default()
            };
            mean(&render(&device, &with_params(&lit, p)))
        };
        let radii = [4.0, 8.0, 14.0];
        let means = radii.map(occluded);
        let trace = |max_scatter| {
            let technique = TechniqueParams::PathTrace(PathTraceParams {
                samples: 64,
                max_scatter,
                ..PathTraceParams::default()
            });
            mean(&render(
                &device,
                &Scene {
                    technique,
                    ..lit.clone()
                },
            ))
        };
        let (once, any) = (trace(Some(1)), trace(None));
        println!("{name}: mean radiance at {radii:?} voxels {means:.4?}");
        println!("  scattered once {once:.4}, any number of times {any:.4}");
    }
}
