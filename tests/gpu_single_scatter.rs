//! Single scattering against closed forms and against its equations on the CPU; the order in which it
//! converges; when the light cache is filled.
#![allow(clippy::unwrap_used, clippy::expect_used)]

mod common;

use std::f64::consts::PI;
use std::sync::Arc;

use common::{constant, cube, device, points, render, scene, volume};
use glam::{DVec2, DVec3, DVec4, UVec3, Vec3};
use rayon::prelude::*;
use tyndall::output::Image;
use tyndall::scene::{
    Falloff, Light, LightCache, PathTraceParams, Plane, Projection, Scene, SingleScatterParams,
    TechniqueParams,
};
use tyndall::technique::Renderer;
use tyndall::technique::phase_hg;
use tyndall::technique::single_scatter::reference;
use tyndall::volume::{ColorVolume, Grid, ScalarType};

const CACHES: [LightCache; 3] = [LightCache::None, LightCache::Half, LightCache::Full];

/// No early end, so that only steps and cache differ from the equations.
fn params(step: f64, cache: LightCache) -> SingleScatterParams {
    SingleScatterParams {
        step,
        shadow_step: step,
        cache,
        early_termination: 1.0,
        empty_space_skipping: true,
    }
}

fn with_params(scene: &Scene, params: SingleScatterParams) -> Scene {
    Scene {
        technique: TechniqueParams::SingleScatter(params),
        ..scene.clone()
    }
}

/// A homogeneous cube of edge 8, optical depth `tau` along it, filling an orthographic image.
fn homogeneous(tau: f64, g: f64) -> Scene {
    let opacity = -(-tau / 8.0).exp_m1();
    let mut s = scene(
        volume(cube(8), ScalarType::U8, |_| 1.0),
        constant(Vec3::ONE, opacity),
    );
    s.camera.projection = Projection::Orthographic { height: 8.0 };
    (s.image.width, s.image.height) = (16, 16);
    s.medium.albedo = 0.9;
    s.medium.phase_g = g;
    s
}

fn light_along(direction: DVec3) -> Vec<Light> {
    vec![Light::Directional {
        direction,
        irradiance: Vec3::splat(3.0),
    }]
}

/// Every pixel is `expected`.
fn assert_everywhere(what: &str, image: &Image, expected: f64, relative: f64) {
    for pixel in &image.pixels {
        common::assert_close(what, f64::from(pixel[1]), expected, relative);
    }
}

#[test]
fn a_slab_lit_along_the_view_is_the_closed_form_at_any_step() {
    let device = device();
    for (tau, g, cache) in CACHES.into_iter().flat_map(|c| {
        [
            (2.0, -0.8, c),
            (2.0, 0.8, c),
            (12.0, 0.0, c),
            (1e-3, 0.3, c),
        ]
    }) {
        let name = format!("tau {tau}, g {g}, {cache:?}");
        // Depths are exact where they are linear.
        let tolerance = 5e-5;
        let mut s = with_params(&homogeneous(tau, g), params(2.0, cache));
        s.lights = light_along(DVec3::Y);
        let expected = 3.0 * 0.9 * phase_hg(-1.0, g) * -(-2.0 * tau).exp_m1() / 2.0;
        assert_everywhere(
            &format!("front, {name}"),
            &render(&device, &s),
            expected,
            tolerance,
        );
        s.lights = light_along(-DVec3::Y);
        let expected = 3.0 * 0.9 * phase_hg(1.0, g) * tau * (-tau).exp();
        assert_everywhere(
            &format!("back, {name}"),
            &render(&device, &s),
            expected,
            tolerance,
        );
    }
}

#[test]
fn a_point_light_inside_is_the_closed_form_at_any_step() {
    // A thin medium: L = sigma_s p int I / d^2 ds along a ray that passes at distance 0.1.
    let device = device();
    let mut s = homogeneous(8e-4, 0.0);
    s.camera.projection = Projection::Orthographic { height: 1e-4 };
    s.camera.eye += 0.1 * DVec3::X;
    s.camera.target += 0.1 * DVec3::X;
    s.lights = vec![Light::Point {
        position: DVec3::ZERO,
        intensity: Vec3::splat(5.0),
        falloff: Falloff::InverseSquare,
    }];
    let expected = 0.9 * 1e-4 / (4.0 * PI) * 5.0 * 2.0 * (4.0_f64 / 0.1).atan() / 0.1;
    for cache in CACHES {
        let image = render(&device, &with_params(&s, params(1.0, cache)));
        // Attenuation that the closed form leaves out is at most 8e-4; the pixels' width shows in 1e-3.
        assert_everywhere(&format!("{cache:?}"), &image, expected, 2e-3);
    }
}

#[test]
fn a_ray_that_exceeds_a_shaders_rounds_is_split() {
    let device = device();
    let mut s = homogeneous(2.0, 0.0);
    s.lights = light_along(DVec3::Y);
    s.image.background = Vec3::splat(0.5);
    let fine = SingleScatterParams {
        step: 1.0 / 32.0,
        shadow_step: 1.0 / 64.0,
        ..params(1.0, LightCache::None)
    };
    let s = with_params(&s, fine);
    let renderer = Renderer::new(&device, s.clone()).unwrap();
    let stages = &renderer.plan().stages;
    let march = stages.iter().find(|s| s.name.contains(".march")).unwrap();
    assert!(march.dispatches > 4, "{}", march.dispatches);
    drop(renderer);
    let expected = 3.0 * 0.9 / (4.0 * PI) * -(-4.0_f64).exp_m1() / 2.0 + 0.5 * (-2.0_f64).exp();
    assert_everywhere("split", &render(&device, &s), expected, 1e-3);
}

/// A smooth blob, anisotropic voxels, colours by value, lit by two lights.
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
    (s.image.width, s.image.height) = (16, 16);
    s.medium.albedo = 0.95;
    s.medium.phase_g = 0.5;
    s.lights = vec![
        Light::Directional {
            direction: DVec3::new(1.0, 0.5, -1.0),
            irradiance: Vec3::new(3.0, 2.0, 1.0),
        },
        Light::Environment {
            radiance: Vec3::ONE,
        },
        Light::Point {
            position: DVec3::new(-9.0, -14.0, 11.0),
            intensity: Vec3::new(100.0, 200.0, 300.0),
            falloff: Falloff::InverseSquare,
        },
    ];
    s
}

/// A step of 1/32 voxel: the truth.
fn truth(scene: &Scene) -> Vec<DVec4> {
    let fine = params(1.0 / 32.0, LightCache::None);
    let (width, height) = (scene.image.width, scene.image.height);
    let pixel = |i: u32| {
        let centre = DVec2::new((i % width).into(), (i / width).into()) + 0.5;
        reference::march(
            scene,
            &fine,
            centre / DVec2::new(width.into(), height.into()),
        )
    };
    (0..width * height).into_par_iter().map(pixel).collect()
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

#[test]
fn a_blob_between_two_lights_is_the_equations() {
    let device = device();
    let mut s = blob();
    s.medium.emission = 0.1;
    s.image.background = Vec3::splat(1e-3);
    let expected = truth(&s);
    for cache in CACHES {
        let image = render(&device, &with_params(&s, params(0.5, cache)));
        let found = error(&image, &expected);
        println!("{cache:?}: {found:.2e}");
        assert!(found < 3e-3, "{cache:?}: {found}");
        let alpha = image.pixels.iter().zip(&expected);
        let farthest = alpha.map(|(a, b)| (f64::from(a[3]) - b.w).abs());
        assert!(farthest.fold(0.0, f64::max) < 4e-3, "{cache:?}");
    }
}

#[test]
fn an_albedo_volume_colours_what_is_scattered_and_not_what_is_emitted() {
    let device = device();
    let mut s = blob();
    let dims = s.volume.grid.dims;
    let color = |i: u32| {
        let (x, z) = (i % dims.x, i / (dims.x * dims.y));
        [x as f32 / dims.x as f32, 0.25, z as f32 / dims.z as f32]
    };
    let colors: Vec<_> = (0..dims.element_product()).map(color).collect();
    s.medium.emission = 0.1;
    let plain = truth(&s);
    s.medium.albedo_volume = Some(Arc::new(ColorVolume::new("colors", dims, &colors)));
    let expected = truth(&s);
    let mut renderer =
        Renderer::new(&device, with_params(&s, params(0.5, LightCache::Half))).unwrap();
    let (image, _) = renderer.render(&mut |_, _, _| {}).unwrap();
    let found = error(&image, &expected);
    // 8 bits a channel are 0.2 %.
    assert!(found < 4e-3, "{found}");
    assert!(error(&image, &plain) > 0.1, "it matters here");
    s.medium.albedo_volume = None;
    assert_eq!(
        ran(
            &mut renderer,
            &with_params(&s, params(0.5, LightCache::Half))
        )
        .len(),
        3,
        "cache, march and read-back"
    );
}

#[test]
fn what_is_clipped_casts_no_shadow_and_a_light_inside_ends_shadow_rays() {
    let device = device();
    let mut s = blob();
    s.clip.plane = Some(Plane {
        point: DVec3::new(0.0, -1.0, 0.0),
        normal: DVec3::new(0.3, 1.0, 0.2),
    });
    s.clip.bounds = Some((DVec3::splat(-8.0), DVec3::new(5.0, 9.0, 9.0)));
    s.lights[2] = Light::Point {
        position: DVec3::new(1.0, 3.0, 1.0),
        intensity: Vec3::splat(4.0),
        falloff: Falloff::None,
    };
    let expected = truth(&s);
    let mut whole = s.clone();
    whole.clip = Default::default();
    let uncut = truth(&whole);
    for cache in CACHES {
        let image = render(&device, &with_params(&s, params(0.5, cache)));
        let found = error(&image, &expected);
        println!("{cache:?}: {found:.2e}");
        // The plane's silhouette is a step that no sampling of pixels resolves alike.
        assert!(found < 0.02, "{cache:?}: {found}");
        assert!(error(&image, &uncut) > 10.0 * found, "clips matter here");
    }
}

#[test]
fn it_converges_with_the_step_and_the_cache() {
    let device = device();
    let s = blob();
    let expected = truth(&s);
    let at = |step: f64, cache| {
        let image = render(&device, &with_params(&s, params(step, cache)));
        error(&image, &expected)
    };
    let errors = [1.0, 0.5, 0.25].map(|step| at(step, LightCache::None));
    let orders = [errors[0] / errors[1], errors[1] / errors[2]].map(f64::log2);
    println!("uncached, steps 1, 1/2, 1/4: {errors:.5?}, orders {orders:.2?}");
    // Midpoints and analytic weights are of second order where the data are smooth; the filter bends at
    // every voxel.
    assert!(orders.iter().all(|o| *o > 1.5), "{orders:?}");
    let caches = [LightCache::Half, LightCache::Full].map(|cache| at(0.25, cache));
    println!("step 1/4, half and full cache: {caches:.5?}");
    assert!(caches[1] < 1.05 * caches[0], "{caches:?}");
    let none = at(0.25, LightCache::None);
    assert!(caches[0] < 0.01 && none <= caches[0], "{caches:?} {none}");
}

/// A blob of 128 voxels a side, so that nodes are voxels: half has twice the spacing of full.
fn large_blob() -> Scene {
    let grid = Grid::centred(UVec3::splat(128), DVec3::ONE);
    let v = volume(grid, ScalarType::F32, |i| {
        let p = (i.as_dvec3() + 0.5) / 128.0 - 0.5;
        1000.0 * (-p.length_squared() * 20.0).exp()
    });
    let mut s = scene(
        v,
        points(&[(0.0, Vec3::ONE, 0.0), (1000.0, Vec3::ONE, 0.1)]),
    );
    s.lights = light_along(DVec3::new(1.0, 0.5, -1.0));
    s
}

/// An image as something to compare others with.
fn as_truth(image: &Image) -> Vec<DVec4> {
    let pixel = |p: &[f32; 4]| Vec3::from_slice(p).extend(p[3]).as_dvec4();
    image.pixels.iter().map(pixel).collect()
}

#[test]
fn the_cache_follows_its_nodes() {
    let device = device();
    let s = large_blob();
    let at = |cache| render(&device, &with_params(&s, params(0.5, cache)));
    let exact = as_truth(&at(LightCache::None));
    let errors = [LightCache::Half, LightCache::Full].map(|cache| error(&at(cache), &exact));
    let order = (errors[0] / errors[1]).log2();
    println!("half and full cache: {errors:.5?}, order {order:.2}");
    assert!(order > 1.5, "{errors:?}");
}

#[test]
#[ignore = "prints the figures of the plot in the technique's README"]
fn convergence_figures() {
    let device = device();
    let s = large_blob();
    let at = |step, cache| render(&device, &with_params(&s, params(step, cache)));
    let exact = as_truth(&at(1.0 / 32.0, LightCache::None));
    println!("step, none, half, full");
    for step in [8.0, 4.0, 2.0, 1.0, 0.5, 0.25, 0.125] {
        let [none, half, full] = CACHES.map(|cache| error(&at(step, cache), &exact));
        println!("{step}, {none:.3e}, {half:.3e}, {full:.3e}");
    }
    // The reference averages over pixels.
    let mut averaged = s.clone();
    averaged.image.samples_per_axis = 8;
    let fine = params(1.0 / 8.0, LightCache::None);
    let averaged = as_truth(&render(&device, &with_params(&averaged, fine)));
    let mut traced = s;
    traced.technique = TechniqueParams::PathTrace(PathTraceParams {
        samples: 1 << 14,
        max_scatter: Some(1),
        ..PathTraceParams::default()
    });
    let sum = |p: &[DVec4]| p.iter().map(|p| p.truncate().element_sum()).sum::<f64>();
    let ratio = sum(&averaged) / sum(&as_truth(&render(&device, &traced)));
    println!("mean at step 1/8, uncached, over path_trace's: {ratio:.5}");
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
    for cache in CACHES {
        let s = with_params(&blob(), params(0.5, cache));
        let (a, b) = (render(&loading, &s), render(&filtering, &s));
        let channels = a.pixels.iter().flatten().zip(b.pixels.iter().flatten());
        let largest = channels.map(|(x, y)| (x - y).abs()).fold(0.0, f32::max);
        // Positions and weights are rounded differently, 2e-5 in volume, table and cache each.
        assert!(largest < 4e-4, "{cache:?}: {largest}");
    }
}

/// Stages that run for `next` after `renderer` has rendered something else, without those of the medium.
fn ran(renderer: &mut Renderer, next: &Scene) -> Vec<String> {
    renderer.set_scene(next.clone()).unwrap();
    let (_, report) = renderer.render(&mut |_, _, _| {}).unwrap();
    let names = report.stages.into_iter().map(|s| s.name);
    names.filter(|n| !n.starts_with("medium.")).collect()
}

#[test]
fn the_cache_is_filled_when_what_it_holds_changes_and_not_before() {
    let device = device();
    let base = with_params(&blob(), SingleScatterParams::default());
    let mut renderer = Renderer::new(&device, base.clone()).unwrap();
    let stages = renderer.plan().stages.iter().map(|s| s.name);
    let own: Vec<_> = stages.filter(|n| !n.starts_with("medium.")).collect();
    let everything = own.clone();
    let march = &own[1..];
    assert!(own[0].starts_with("single_scatter.light_cache"));
    assert_eq!(ran(&mut renderer, &base), everything, "first frame");
    assert!(ran(&mut renderer, &base).is_empty(), "nothing");
    let mut s = base;
    s.camera = s.camera.orbit(10.0);
    assert_eq!(ran(&mut renderer, &s), march, "camera");
    s.medium.phase_g = -0.4;
    assert_eq!(ran(&mut renderer, &s), march, "phase");
    s.image.width = 40;
    assert_eq!(ran(&mut renderer, &s), march, "image");
    let mut p = SingleScatterParams {
        step: 0.7,
        ..SingleScatterParams::default()
    };
    s = with_params(&s, p);
    assert_eq!(ran(&mut renderer, &s), march, "the march's step");
    p.shadow_step = 0.5;
    s = with_params(&s, p);
    assert_eq!(ran(&mut renderer, &s), everything, "the cache's step");
    s.lights[0] = light_along(DVec3::Z).remove(0);
    assert_eq!(ran(&mut renderer, &s), everything, "light");
    s.medium.density_scale = 2.0;
    assert_eq!(ran(&mut renderer, &s), everything, "transfer function");
    s.clip.bounds = Some((DVec3::splat(-5.0), DVec3::splat(5.0)));
    assert_eq!(ran(&mut renderer, &s), everything, "clip");
    let (image, _) = renderer.render(&mut |_, _, _| {}).unwrap();
    assert_eq!(image, common::render_beside(&device, &s), "a fresh one");
}

#[test]
fn default_settings_are_within_two_percent_of_the_unbiased_reference() {
    let device = device();
    let mut side = homogeneous(4.0, 0.0);
    side.lights = light_along(DVec3::X);
    let mut oblique = homogeneous(4.0, -0.8);
    oblique.lights = light_along(DVec3::new(0.2, 1.0, -0.3));
    let mut clipped = blob();
    clipped.lights.remove(1);
    clipped.clip.bounds = Some((DVec3::splat(-8.0), DVec3::new(5.0, 9.0, 9.0)));
    for (name, s) in [("side", side), ("oblique", oblique), ("clipped", clipped)] {
        let mut traced = s.clone();
        traced.technique = TechniqueParams::PathTrace(PathTraceParams {
            samples: 4096,
            max_scatter: Some(1),
            ..PathTraceParams::default()
        });
        let mut scattered = with_params(&s, SingleScatterParams::default());
        // The reference averages over pixels.
        scattered.image.samples_per_axis = 4;
        let mean = |s| {
            let pixels = render(&device, s).pixels;
            let sum = |p: &[f32; 4]| p[..3].iter().map(|c| f64::from(*c)).sum::<f64>();
            pixels.iter().map(sum).sum::<f64>()
        };
        let bias = mean(&scattered) / mean(&traced) - 1.0;
        println!("{name}: bias {:.3} %", 100.0 * bias);
        // The reference's own standard error is about 0.1 %.
        assert!(bias.abs() < 0.02, "{name}: {bias}");
    }
}
