//! Half-angle slicing against closed forms, against its equations on the CPU, and against `single_scatter`.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use std::f64::consts::PI;
use std::sync::Arc;

use common::{constant, cube, device, points, render, render_beside, scene, volume};
use glam::{DVec2, DVec3, DVec4, UVec3, Vec3};
use rayon::prelude::*;
use tyndall::gpu::Device;
use tyndall::output::Image;
use tyndall::scene::{
    Falloff, HalfAngleParams, Light, LightCache, Lighting, Plane, Projection, Scene,
    SingleScatterParams, SurfaceShading, TechniqueParams, TransportColor,
};
use tyndall::technique::half_angle::{plan, reference};
use tyndall::technique::{phase_hg, single_scatter};
use tyndall::volume::{ColorVolume, Grid, ScalarType};

/// Slices of tests that compare images of the same slices: validation takes its time for each.
const COARSE: f64 = 3.0;

/// No early end, so that only slices and light buffer differ from the equations.
fn params(slice_spacing: f64, lighting: Lighting) -> HalfAngleParams {
    HalfAngleParams {
        slice_spacing,
        lighting,
        early_termination: 1.0,
        ..HalfAngleParams::default()
    }
}

fn with_params(scene: &Scene, params: HalfAngleParams) -> Scene {
    Scene {
        technique: TechniqueParams::HalfAngle(params),
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
fn a_slab_lit_along_the_view_is_the_closed_form_at_any_thickness() {
    let device = device();
    for (tau, g, spacing) in [
        (2.0, -0.8, 64.0),
        (2.0, 0.8, 1.0),
        (12.0, 0.0, 16.0),
        (1e-3, 0.3, 1.0),
    ] {
        let name = format!("tau {tau}, g {g}, spacing {spacing}");
        let mut s = with_params(&homogeneous(tau, g), params(spacing, Lighting::Direct));
        s.lights = light_along(DVec3::Y);
        let expected = 3.0 * 0.9 * phase_hg(-1.0, g) * -(-2.0 * tau).exp_m1() / 2.0;
        // Single precision; depths are exact where they are linear.
        assert_everywhere(
            &format!("front, {name}"),
            &render(&device, &s),
            expected,
            5e-5,
        );
        s.lights = light_along(-DVec3::Y);
        let expected = 3.0 * 0.9 * phase_hg(1.0, g) * tau * (-tau).exp();
        assert_everywhere(
            &format!("back, {name}"),
            &render(&device, &s),
            expected,
            5e-5,
        );
    }
}

#[test]
fn scattered_light_of_a_slab_is_the_closed_form_at_any_thickness() {
    // A slab without sides: no spread. A = exp(-k tau) - exp(-tau) meets the viewer's exp(-tau).
    let device = device();
    for (tau, color, spacing) in [
        (2.0, 0.5, 64.0),
        (2.0, 0.9, 1.0),
        (12.0, 0.95, 16.0),
        (1e-3, 1.0, 1.0),
    ] {
        let name = format!("tau {tau}, transport {color}, spacing {spacing}");
        let p = HalfAngleParams {
            transport_color: TransportColor::Points(Arc::new([[0.0, 0.1, color, 1.0]])),
            blur_angle_deg: 0.0,
            ..params(spacing, Lighting::Indirect)
        };
        let mut s = with_params(&homogeneous(tau, 0.0), p);
        s.lights = light_along(DVec3::Y);
        let k = -color.ln();
        let expected = 3.0 * 0.9 / (4.0 * PI) * -(-(1.0 + k) * tau).exp_m1() / (1.0 + k);
        assert_everywhere(&name, &render(&device, &s), expected, 1e-4);
    }
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
        point(DVec3::new(-9.0, -14.0, 11.0), 100.0),
    ];
    s
}

fn point(position: DVec3, intensity: f32) -> Light {
    Light::Point {
        position,
        intensity: intensity * Vec3::new(1.0, 2.0, 3.0),
        falloff: Falloff::InverseSquare,
    }
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

fn as_truth(image: &Image) -> Vec<DVec4> {
    let pixel = |p: &[f32; 4]| DVec4::from(p.map(f64::from));
    image.pixels.iter().map(pixel).collect()
}

/// The equations on the CPU.
fn expected(device: &Device, scene: &Scene) -> Vec<DVec4> {
    let TechniqueParams::HalfAngle(p) = &scene.technique else {
        panic!("not half_angle");
    };
    let plan = plan(scene, p, &device.info().limits).unwrap();
    reference::image(scene, p, &plan)
}

#[test]
fn a_blob_is_the_equations_whatever_the_lights_and_the_camera() {
    let device = device();
    let mut cases = vec![("two lights", blob())];
    let mut s = blob();
    s.lights = light_along(DVec3::new(0.3, -1.0, 0.2));
    s.medium.emission = 0.1;
    s.image.background = Vec3::splat(1e-3);
    s.camera.projection = Projection::Perspective { vfov_deg: 40.0 };
    cases.push(("from behind, in perspective", s));
    let mut s = blob();
    s.lights = vec![point(DVec3::new(2.0, 1.0, -3.0), 10.0)];
    cases.push(("a point within", s));
    let mut s = blob();
    s.lights = vec![point(DVec3::new(13.5, 0.0, 0.0), 10.0)];
    s.camera.eye = DVec3::new(1.0, 2.0, -1.0);
    s.camera.target = DVec3::new(8.0, 9.0, 3.0);
    s.camera.projection = Projection::Perspective { vfov_deg: 110.0 };
    cases.push(("a point close by, the camera within", s));
    let mut s = blob();
    s.clip.bounds = Some((DVec3::new(-7.0, -20.0, -9.0), DVec3::new(20.0, 20.0, 7.0)));
    s.clip.plane = Some(Plane {
        point: DVec3::new(0.0, 1.0, 0.0),
        normal: DVec3::new(0.2, -1.0, 0.3),
    });
    cases.push(("clipped", s));
    for (name, s) in cases {
        for lighting in [Lighting::None, Lighting::Direct, Lighting::Indirect] {
            let s = with_params(&s, params(3.0, lighting));
            let truth = expected(&device, &s);
            let image = render(&device, &s);
            let found = error(&image, &truth);
            println!("{name}, {lighting:?}: {found:.1e}");
            // Single precision, colours by a table, and the few texels whose offsets rounding moves.
            assert!(found < 1e-3, "{name}, {lighting:?}: {found}");
            let alpha = image.pixels.iter().zip(&truth);
            let farthest = alpha.map(|(a, b)| (f64::from(a[3]) - b.w).abs());
            assert!(farthest.fold(0.0, f64::max) < 2e-3, "{name}, {lighting:?}");
        }
    }
}

/// Single scattering by rays in steps of 1/32 voxel.
fn once(scene: &Scene) -> Vec<DVec4> {
    let fine = SingleScatterParams {
        step: 1.0 / 32.0,
        shadow_step: 1.0 / 32.0,
        cache: LightCache::None,
        early_termination: 1.0,
        empty_space_skipping: true,
    };
    let (width, height) = (scene.image.width, scene.image.height);
    let size = DVec2::new(width.into(), height.into());
    let pixel = |i: u32| {
        let place = DVec2::new((i % width).into(), (i / width).into()) + 0.5;
        single_scatter::reference::march(scene, &fine, place / size)
    };
    (0..width * height).into_par_iter().map(pixel).collect()
}

#[test]
fn direct_light_converges_to_single_scattering() {
    let device = device();
    // Close to a point within, light turns by much from slice to slice.
    for (lights, most) in [
        (blob().lights, 4e-3),
        (vec![point(DVec3::new(2.0, 1.0, -3.0), 10.0)], 3e-2),
        (light_along(DVec3::new(0.0, -1.0, 0.1)), 4e-3),
    ] {
        let s = Scene { lights, ..blob() };
        let truth = once(&s);
        let errors = [4.0, 2.0, 1.0].map(|spacing| {
            let p = HalfAngleParams {
                light_buffer: Some((256.0 / spacing) as u32),
                ..params(spacing, Lighting::Direct)
            };
            error(&render(&device, &with_params(&s, p)), &truth)
        });
        println!("{errors:?}");
        // Second order in the thickness of slices and the texels' size.
        assert!(errors[2] < 0.25 * errors[0], "{errors:?}");
        assert!(errors[2] < most, "{errors:?}");
    }
}

#[test]
fn scattered_light_vanishes_where_it_is_dimmed_like_direct_light() {
    let device = device();
    let direct = as_truth(&render(
        &device,
        &with_params(&blob(), params(COARSE, Lighting::Direct)),
    ));
    let with_color = |color: f64, angle: f64| {
        let p = HalfAngleParams {
            transport_color: TransportColor::Points(Arc::new([[0.0, color, color, color]])),
            blur_angle_deg: angle,
            ..params(COARSE, Lighting::Indirect)
        };
        render(&device, &with_params(&blob(), p))
    };
    for angle in [0.0, 60.0, 150.0] {
        let found = error(&with_color(0.3, angle), &direct);
        // exp(-tau_i) and exp(-tau) differ by rounding.
        assert!(found < 1e-5, "{angle}: {found}");
    }
    let mean = |image: &Image| image.pixels.iter().map(|p| f64::from(p[1])).sum::<f64>();
    let dark: f64 = direct.iter().map(|p| p.y).sum();
    let brightness: Vec<_> = [0.5, 0.7, 0.9, 1.0]
        .map(|color| mean(&with_color(color, 60.0)))
        .to_vec();
    println!("{dark} {brightness:?}");
    assert!(dark < brightness[0] && brightness.is_sorted());
}

#[test]
fn a_thin_medium_has_little_scattered_light() {
    let device = device();
    let mut s = blob();
    s.medium.density_scale = 1e-3;
    let truth = once(&s);
    let found = error(
        &render(&device, &with_params(&s, params(0.5, Lighting::Indirect))),
        &truth,
    );
    // Scattered light is as faint as the medium, a few thousandths deep; the rest is discretisation.
    assert!(found < 6e-3, "{found}");
}

#[test]
fn the_image_is_continuous_where_the_slice_axis_switches() {
    let device = device();
    let mut s = blob();
    for spacing in [2.0, 1.0] {
        for lighting in [Lighting::Direct, Lighting::Indirect] {
            // Light across the view: at a right angle, and a ten-thousandth of a degree to either side.
            let images = [-1.0, 0.0, 1.0].map(|side: f64| {
                let tilt = side * 1e-4_f64.to_radians();
                s.lights = light_along(DVec3::new(tilt.cos(), tilt.sin(), 0.0));
                render(&device, &with_params(&s, params(spacing, lighting)))
            });
            let right = as_truth(&images[1]);
            let jumps = [error(&images[0], &right), error(&images[2], &right)];
            println!("{lighting:?} at {spacing}: {jumps:?}");
            // Slices turn by 90 degrees: what is left is their discretisation, which halves with them.
            let most = if spacing < 2.0 { 4e-3 } else { 1.2e-2 };
            assert!(jumps.iter().all(|j| *j < most), "{jumps:?}");
        }
    }
}

#[test]
fn thinner_slices_change_little_but_the_cost() {
    let device = device();
    let image = |spacing| {
        render(
            &device,
            &with_params(&blob(), params(spacing, Lighting::Indirect)),
        )
    };
    let fine = as_truth(&image(0.5));
    let errors = [2.0, 1.0].map(|spacing| error(&image(spacing), &fine));
    println!("{errors:?}");
    // The spread of scattered light does not depend on the number of slices.
    assert!(errors[0] < 2e-2 && errors[1] < 1e-2, "{errors:?}");
}

#[test]
fn a_phase_table_is_normalised_and_read_by_the_cosine() {
    let device = device();
    let mut s = blob();
    let hg = render(&device, &with_params(&s, params(COARSE, Lighting::Direct)));
    let row = |i: usize| {
        let p = 7.0 * phase_hg(f64::from(i as u32) / 511.5 - 1.0, 0.5);
        [p, 2.0 * p, 0.01 * p]
    };
    s.medium.phase_g = -0.9;
    let p = HalfAngleParams {
        phase_table: Some((0..1024).map(row).collect()),
        ..params(COARSE, Lighting::Direct)
    };
    let found = error(&render(&device, &with_params(&s, p)), &as_truth(&hg));
    // Straight lines between 1024 rows.
    assert!(found < 1e-4, "{found}");
}

#[test]
fn rays_a_pixel_are_averaged_and_frames_repeat_to_the_bit() {
    let device = device();
    let mut s = with_params(&blob(), params(COARSE, Lighting::Indirect));
    s.image.samples_per_axis = 2;
    let averaged = render(&device, &s);
    assert_eq!(averaged.pixels, render_beside(&device, &s).pixels);
    s.image.samples_per_axis = 1;
    (s.image.width, s.image.height) = (32, 32);
    let fine = render(&device, &s);
    let mean: Vec<_> = (0..256_u32)
        .map(|i| {
            let (x, y) = (2 * (i % 16), 2 * (i / 16));
            let four = [(0, 0), (1, 0), (0, 1), (1, 1)];
            let pixel = |(a, b)| DVec4::from(fine.pixel(x + a, y + b).unwrap().map(f64::from));
            four.map(pixel).into_iter().sum::<DVec4>() / 4.0
        })
        .collect();
    let found = error(&averaged, &mean);
    assert!(found < 1e-5, "{found}");
}

#[test]
fn an_albedo_volume_colours_what_is_scattered() {
    let device = device();
    let mut s = blob();
    let dims = s.volume.grid.dims;
    let color = |i: u32| {
        let (x, z) = (i % dims.x, i / (dims.x * dims.y));
        [x as f32 / dims.x as f32, 0.25, z as f32 / dims.z as f32]
    };
    let colors: Vec<_> = (0..dims.element_product()).map(color).collect();
    s.medium.albedo_volume = Some(Arc::new(ColorVolume::new("colors", dims, &colors)));
    let s = with_params(&s, params(COARSE, Lighting::Indirect));
    let found = error(&render(&device, &s), &expected(&device, &s));
    // 8 bits a channel are 0.2 %.
    assert!(found < 4e-3, "{found}");
}

#[test]
fn surfaces_are_shaded_by_the_gradient_where_it_is_steep() {
    let device = device();
    let steep = |surface_gradient, surface| {
        let p = HalfAngleParams {
            surface,
            surface_gradient,
            ..params(COARSE, Lighting::Direct)
        };
        render(&device, &with_params(&blob(), p))
    };
    let volume = as_truth(&steep(0.1, SurfaceShading::None));
    let hardly = error(&steep(1e6, SurfaceShading::Gradient), &volume);
    assert!(hardly < 1e-4, "{hardly}");
    let all = error(&steep(1e-3, SurfaceShading::Gradient), &volume);
    assert!(all > 0.1, "{all}");
}
