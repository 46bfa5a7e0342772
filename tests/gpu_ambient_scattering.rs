//! Ambient scattering against its limits and against its equations on the CPU; what is made anew when.
#![allow(clippy::unwrap_used, clippy::expect_used)]

mod common;

use common::{cube, device, points, render, render_beside, scene, volume};
use glam::{DVec2, DVec3, Vec3};
use rayon::prelude::*;
use tyndall::gpu::Device;
use tyndall::output::Image;
use tyndall::scene::{
    AmbientScatteringParams, Falloff, Gather, Light, Plane, Projection, RadianceCache, Radius,
    Scene, SingleScatterParams, TechniqueParams, Tube,
};
use tyndall::technique::Renderer;
use tyndall::technique::ambient_scattering::reference::Reference;
use tyndall::technique::ambient_scattering::table::shipped;
use tyndall::volume::ScalarType;

/// No early end, so that only step, looks and cache differ from the equations.
fn params() -> AmbientScatteringParams {
    AmbientScatteringParams {
        radius: Radius::Voxels(2.0),
        early_termination: 1.0,
        ..AmbientScatteringParams::default()
    }
}

fn with_params(scene: &Scene, params: AmbientScatteringParams) -> Scene {
    Scene {
        technique: TechniqueParams::AmbientScattering(params),
        ..scene.clone()
    }
}

/// A soft blob between a directional and a point light, grey, depth about `tau` through its middle.
fn blob(tau: f64, g: f64) -> Scene {
    let n = 24;
    let value = |i: glam::UVec3| {
        let p = (i.as_dvec3() - 11.5) / 11.5;
        255.0 * (1.0 - p.length()).clamp(0.0, 1.0)
    };
    let opacity = -(-tau / 12.0_f64).exp_m1();
    let mut s = scene(
        volume(cube(n), ScalarType::U8, value),
        points(&[(0.0, Vec3::ONE, 0.0), (255.0, Vec3::ONE, opacity)]),
    );
    s.camera.projection = Projection::Orthographic { height: 24.0 };
    (s.image.width, s.image.height) = (24, 24);
    s.medium.albedo = 0.9;
    s.medium.phase_g = g;
    s.lights = vec![
        Light::Directional {
            direction: DVec3::new(1.0, 0.4, -0.7),
            irradiance: Vec3::new(3.0, 2.0, 1.0),
        },
        Light::Point {
            position: DVec3::new(3.0, -20.0, 9.0),
            intensity: Vec3::splat(300.0),
            falloff: Falloff::InverseSquare,
        },
    ];
    s
}

fn mean(image: &Image) -> f64 {
    let sum = |p: &[f32; 4]| p[..3].iter().map(|c| f64::from(*c)).sum::<f64>();
    image.pixels.iter().map(sum).sum::<f64>() / image.pixels.len() as f64
}

/// Root mean square of the difference over the mean of `b`.
fn apart(a: &Image, b: &Image) -> f64 {
    let pairs = a.pixels.iter().zip(&b.pixels);
    let square = |(p, q): (&[f32; 4], &[f32; 4])| {
        (0..3).map(|c| f64::from(p[c] - q[c]).powi(2)).sum::<f64>()
    };
    let squares: f64 = pairs.map(square).sum();
    (squares / (3 * a.pixels.len()) as f64).sqrt() / (mean(b) / 3.0)
}

fn reference(s: &Scene) -> Image {
    let TechniqueParams::AmbientScattering(params) = s.technique else {
        unreachable!("not ambient_scattering");
    };
    let reference = Reference::new(s, &params, shipped().unwrap());
    let (width, height) = (s.image.width, s.image.height);
    let pixel = |i: u32| {
        let at = DVec2::new(
            (f64::from(i % width) + 0.5) / f64::from(width),
            (f64::from(i / width) + 0.5) / f64::from(height),
        );
        reference.march(at).as_vec4().to_array()
    };
    Image {
        width,
        height,
        pixels: (0..width * height).into_par_iter().map(pixel).collect(),
    }
}

#[test]
fn images_are_those_of_the_equations() {
    let device = device();
    let all = [
        (Tube::Slab, Gather::Split),
        (Tube::Slab, Gather::Literal),
        (Tube::Normalized, Gather::Split),
        (Tube::Literal, Gather::Literal),
    ];
    // Backwards, the normalised tube passes more than all, which half floats do not hold.
    for (name, s, forms) in [
        ("even", blob(8.0, 0.0), &all[..]),
        ("forward", blob(8.0, 0.5), &all[..]),
        ("back", blob(8.0, -0.6), &all[..2]),
    ] {
        for &(tube, gather) in forms {
            let own = AmbientScatteringParams {
                tube,
                gather,
                cache: RadianceCache::None,
                step: 0.25,
                ..params()
            };
            let s = with_params(&s, own);
            let distance = apart(&render(&device, &s), &reference(&s));
            println!("{name}, {tube:?}, {gather:?}: {distance:.4}");
            // Looks a radius apart, half floats and the tables' entries.
            assert!(distance < 0.03, "{name}, {tube:?}, {gather:?}: {distance}");
        }
    }
}

#[test]
fn what_is_kept_of_light_hardly_matters() {
    let device = device();
    let s = blob(8.0, 0.3);
    let of = |cache| {
        render(
            &device,
            &with_params(&s, AmbientScatteringParams { cache, ..params() }),
        )
    };
    let direct = of(RadianceCache::None);
    for (cache, limit) in [(RadianceCache::Full, 0.01), (RadianceCache::Half, 0.03)] {
        // The nodes of this small volume are less than a voxel apart in either.
        let distance = apart(&of(cache), &direct);
        assert!(distance < limit, "{cache:?}: {distance}");
    }
}

/// The blob, seen by enough rays for the cache's nodes to look for them.
fn wide(projection: Projection) -> Scene {
    let mut s = blob(6.0, 0.3);
    (s.image.width, s.image.height) = (256, 256);
    s.camera.projection = projection;
    let radius = Radius::Voxels(7.0);
    with_params(&s, AmbientScatteringParams { radius, ..params() })
}

fn stages(device: &Device, s: &Scene) -> Vec<&'static str> {
    let renderer = Renderer::new(device, s.clone()).unwrap();
    renderer.plan().stages.iter().map(|s| s.name).collect()
}

#[test]
fn nodes_see_for_rays_what_rays_would_see() {
    const GATHER: &str = "ambient_scattering.gather";
    let device = device();
    for projection in [
        Projection::Orthographic { height: 24.0 },
        Projection::Perspective { vfov_deg: 40.0 },
    ] {
        let s = wide(projection);
        let cache = RadianceCache::None;
        let TechniqueParams::AmbientScattering(own) = s.technique else {
            unreachable!("not ambient_scattering");
        };
        let rays = with_params(&s, AmbientScatteringParams { cache, ..own });
        assert!(stages(&device, &s).contains(&GATHER));
        assert!(!stages(&device, &rays).contains(&GATHER));
        let distance = apart(&render(&device, &s), &render(&device, &rays));
        println!("{projection:?}: {distance:.4}");
        // Between nodes light goes straight instead of as it fades.
        assert!(distance < 5e-3, "{projection:?}: {distance}");
    }
    // Few rays, or nodes too far apart for the radius, look themselves.
    let mut few = wide(Projection::Orthographic { height: 24.0 });
    (few.image.width, few.image.height) = (48, 48);
    assert!(!stages(&device, &few).contains(&GATHER));
    let narrow = with_params(&wide(few.camera.projection), params());
    assert!(!stages(&device, &narrow).contains(&GATHER));
}

#[test]
fn thin_media_are_those_of_single_scatter() {
    let device = device();
    for g in [-0.9, 0.0, 0.9] {
        for radius in [1.0, 3.0, 8.0] {
            let tau = 1e-3;
            let s = blob(tau, g);
            let ours = with_params(
                &s,
                AmbientScatteringParams {
                    radius: Radius::Voxels(radius),
                    ..params()
                },
            );
            let mut once = s;
            once.technique = TechniqueParams::SingleScatter(SingleScatterParams {
                early_termination: 1.0,
                ..SingleScatterParams::default()
            });
            let distance = apart(&render(&device, &ours), &render(&device, &once));
            // Light scattered twice is smaller by the depth times the peak of the phase function over its mean;
            // the point light's change of direction is straight between two looks.
            assert!(distance < 2e-2, "g {g}, radius {radius}: {distance}");
        }
    }
}

#[test]
fn light_crosses_vacuum_unchanged_whatever_the_steps() {
    let device = device();
    // A thin sheet far from where light enters; nothing before it.
    let sheet = |radius| {
        let mut s = scene(
            volume(
                cube(64),
                ScalarType::U8,
                |i| {
                    if i.z < 6 { 255.0 } else { 0.0 }
                },
            ),
            points(&[(0.0, Vec3::ONE, 0.0), (255.0, Vec3::ONE, 1e-3)]),
        );
        s.lights = vec![Light::Directional {
            direction: -DVec3::Z,
            irradiance: Vec3::splat(3.0),
        }];
        s.camera.projection = Projection::Orthographic { height: 64.0 };
        s.medium.phase_g = -0.9;
        let own = AmbientScatteringParams {
            radius: Radius::Voxels(radius),
            ..params()
        };
        mean(&render(&device, &with_params(&s, own)))
    };
    let wide = sheet(8.0);
    for radius in [1.0, 2.0, 4.0] {
        let found = sheet(radius);
        assert!(found > 0.0);
        // The sheet's own depth of 6e-3, of which a wider sphere sees another share.
        assert!(
            (found / wide - 1.0).abs() < 1e-2,
            "radius {radius}: {found}, {wide}"
        );
    }
}

#[test]
fn albedo_0_scatters_nothing_and_emission_shows_alone() {
    let device = device();
    let mut s = with_params(&blob(4.0, 0.2), params());
    s.medium.albedo = 0.0;
    assert_eq!(mean(&render(&device, &s)), 0.0);
    s.medium.emission = 1.0;
    let emitted = render(&device, &s);
    let mut march = s.clone();
    march.technique = TechniqueParams::RayMarch(tyndall::scene::RayMarchParams {
        step: 0.5,
        ..common::params()
    });
    // The same integral by the same steps.
    assert!(apart(&emitted, &render(&device, &march)) < 1e-4);
}

#[test]
fn an_environment_lights_by_occlusion_and_highlights_only_add() {
    let device = device();
    let mut s = with_params(&blob(4.0, 0.0), params());
    s.lights = vec![Light::Environment {
        radiance: Vec3::splat(1.0),
    }];
    let ambient = render(&device, &s);
    let alpha: f64 = ambient.pixels.iter().map(|p| f64::from(p[3])).sum();
    let sum = mean(&ambient) * ambient.pixels.len() as f64 / 3.0;
    // Between nothing and an albedo of 0.9 in full light.
    assert!(sum > 0.2 * alpha && sum < 0.9 * alpha, "{sum}, {alpha}");
    let mut lit = with_params(&blob(4.0, 0.0), params());
    let plain = render(&device, &lit);
    lit.technique = TechniqueParams::AmbientScattering(AmbientScatteringParams {
        specular: 0.5,
        ..params()
    });
    let shiny = render(&device, &lit);
    let pairs = shiny.pixels.iter().zip(&plain.pixels);
    assert!(pairs.clone().all(|(s, p)| s[1] >= p[1]));
    assert!(mean(&shiny) > 1.001 * mean(&plain));
}

#[test]
fn depths_beyond_the_table_stay_finite_and_lit() {
    let device = device();
    let mut s = blob(1.0, 0.5);
    s.medium.density_scale = 2e4;
    for gather in [Gather::Split, Gather::Literal] {
        let own = AmbientScatteringParams {
            gather,
            radius: Radius::Voxels(12.0),
            ..params()
        };
        let image = render(&device, &with_params(&s, own));
        assert_eq!(image.non_finite(), 0, "{gather:?}");
        assert!(mean(&image) > 0.0, "{gather:?}");
    }
}

#[test]
fn a_clip_plane_lets_light_in() {
    let device = device();
    let mut s = blob(30.0, 0.0);
    s.lights = vec![Light::Directional {
        direction: DVec3::X,
        irradiance: Vec3::splat(3.0),
    }];
    let mut cut = s.clone();
    // Half of the blob, on the light's side, is taken away.
    cut.clip.plane = Some(Plane {
        point: DVec3::ZERO,
        normal: DVec3::new(1.0, 0.0, 0.0),
    });
    let (whole, half) = (
        render(&device, &with_params(&s, params())),
        render(&device, &with_params(&cut, params())),
    );
    let right = |image: &Image| {
        let at = |x, y| f64::from(image.pixel(x, y).unwrap()[0]);
        (8..16).map(|y| at(14, y)).sum::<f64>()
    };
    assert!(right(&half) > 1.5 * right(&whole));
}

/// The technique's own stages that a frame ran.
fn ran(renderer: &mut Renderer, scene: &Scene) -> Vec<String> {
    renderer.set_scene(scene.clone()).unwrap();
    let (_, report) = renderer.render(&mut |_, _, _| {}).unwrap();
    let names = report.stages.into_iter().map(|s| s.name);
    names.filter(|n| !n.starts_with("medium.")).collect()
}

/// The last `n` of a list.
fn last(all: &[String], n: usize) -> &[String] {
    &all[all.len() - n..]
}

fn set(scene: &Scene, edit: impl FnOnce(&mut Scene)) -> Scene {
    let mut scene = scene.clone();
    edit(&mut scene);
    scene
}

#[test]
fn a_change_runs_what_depends_on_it_and_no_more() {
    let device: Device = device();
    let base = with_params(&blob(8.0, 0.3), params());
    let mut renderer = Renderer::new(&device, base.clone()).unwrap();
    let all = ran(&mut renderer, &base);
    let planned: Vec<_> = renderer
        .plan()
        .stages
        .iter()
        .map(|s| s.name.to_owned())
        .collect();
    let own: Vec<_> = planned
        .into_iter()
        .filter(|n| !n.starts_with("medium."))
        .collect();
    assert_eq!(all, own, "first frame");
    assert_eq!(all[0], "ambient_scattering.upload_tables");
    assert!(ran(&mut renderer, &base).is_empty(), "nothing");
    let s = set(&base, |s| s.camera = s.camera.orbit(10.0));
    assert_eq!(
        ran(&mut renderer, &s),
        last(&all, 2),
        "camera: march, read_back"
    );
    let s = set(&s, |s| s.lights[0] = s.lights[1].clone());
    assert_eq!(
        ran(&mut renderer, &s),
        last(&all, 3),
        "light: the cache too"
    );
    let s = set(&s, |s| s.medium.phase_g = -0.4);
    let phase = [&all[..1], last(&all, 3)].concat();
    assert_eq!(ran(&mut renderer, &s), phase, "phase: the tables too");
    let s = set(&s, |s| s.medium.density_scale = 1.5);
    assert_eq!(
        ran(&mut renderer, &s),
        all[1..],
        "transfer function: all but the tables"
    );
    let wider = AmbientScatteringParams {
        radius: Radius::Voxels(3.0),
        ..params()
    };
    let s = with_params(&s, wider);
    assert_eq!(ran(&mut renderer, &s), all[1..], "radius");
    let (image, _) = renderer.render(&mut |_, _, _| {}).unwrap();
    assert_eq!(image, render_beside(&device, &s), "a fresh one");
}

#[test]
fn without_lights_only_emission_is_planned() {
    let device = device();
    let mut s = with_params(&blob(4.0, 0.0), params());
    s.lights.clear();
    let renderer = Renderer::new(&device, s).unwrap();
    let names: Vec<_> = renderer.plan().stages.iter().map(|s| s.name).collect();
    assert!(
        !names.iter().any(|n| n.starts_with("summed_area.")),
        "{names:?}"
    );
    assert!(
        !names.contains(&"ambient_scattering.radiance_cache"),
        "{names:?}"
    );
}
