//! The unbiased reference against closed forms and against the textbook estimator on the CPU. Each
//! comparison is a z-test: its tolerance is the estimate's own standard error.
#![allow(clippy::unwrap_used, clippy::expect_used)]

mod common;
mod estimates;

use std::f64::consts::PI;

use common::{constant, cube, device, points, render, scene, volume};
use estimates::{Z, assert_estimators_agree, assert_mean, blob, estimate, mean, traced};
use glam::{DVec3, UVec3, Vec3};
use tyndall::scene::{Falloff, Light, PathTraceParams, Plane, Projection, Scene, TechniqueParams};
use tyndall::technique::phase_hg;
use tyndall::volume::{Grid, ScalarType};

/// A homogeneous cube of edge 8, optical depth `tau` along it, filling an orthographic image.
fn homogeneous(tau: f64, g: f64) -> Scene {
    let opacity = -(-tau / 8.0).exp_m1();
    let mut s = scene(
        volume(cube(8), ScalarType::U8, |_| 1.0),
        constant(Vec3::ONE, opacity),
    );
    s.camera.projection = Projection::Orthographic { height: 8.0 };
    s.image.width = 16;
    s.image.height = 16;
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

#[test]
fn a_slab_transmits_exp_minus_tau() {
    let device = device();
    for tau in [1e-3, 0.05, 1.0, 4.0] {
        let mut s = traced(homogeneous(tau, 0.0), 1024, None);
        s.lights = Vec::new();
        s.image.background = Vec3::splat(2.0);
        let (image, variance) = estimate(&device, &s);
        let transmitted = mean(&image, &variance, 0);
        let expected = 2.0 * (-tau).exp();
        // In one leaf the share that never meets the medium is exact: nothing is left to chance.
        let error = (transmitted.0 / expected - 1.0).abs();
        assert!(error < 1e-5, "tau {tau}: {transmitted:?}");
        let alpha = image.pixels.iter().map(|p| f64::from(p[3])).sum::<f64>() / 256.0;
        assert!((alpha / -(-tau).exp_m1() - 1.0).abs() < 1e-4, "{alpha}");
    }
}

#[test]
fn a_slab_in_leaves_transmits_exp_minus_tau() {
    // Thickness 32 with a step in density, so that leaves differ: tau = 16 a + 16 b.
    let device = device();
    let grid = Grid::centred(UVec3::new(32, 32, 32), DVec3::ONE);
    let v = volume(grid, ScalarType::F32, |i| if i.y < 16 { 0.02 } else { 0.1 });
    let mut s = scene(v, points(&[(0.0, Vec3::ONE, 0.0), (1.0, Vec3::ONE, 1.0)]));
    s.camera.projection = Projection::Orthographic { height: 32.0 };
    s.lights = Vec::new();
    let s = traced(s, 256, None);
    let (image, _) = estimate(&device, &s);
    let alpha = image.pixels.iter().map(|p| f64::from(p[3])).sum::<f64>() / 1024.0;
    // The voxel between the halves is interpolated: its extinction's integral is close to the mean's.
    let between: f64 = (0..1000)
        .map(|i| -(-(0.02 + 0.08 * (f64::from(i) + 0.5) / 1000.0_f64)).ln_1p() / 1000.0)
        .sum();
    let tau = -15.5 * (0.98_f64.ln() + 0.9_f64.ln()) + between;
    let expected = -(-tau).exp_m1();
    let error = (expected * (1.0 - expected) / (1024.0 * 256.0)).sqrt();
    assert!((alpha - expected).abs() < Z * error, "{alpha} {expected}");
}

#[test]
fn single_scattering_of_a_front_light_is_the_closed_form() {
    let device = device();
    let tau = 2.0;
    for g in [-0.8, 0.0, 0.8] {
        let mut s = traced(homogeneous(tau, g), 2048, Some(1));
        s.lights = light_along(DVec3::Y);
        let (image, variance) = estimate(&device, &s);
        let backwards = phase_hg(-1.0, g);
        let expected = 3.0 * 0.9 * backwards * -(-2.0 * tau).exp_m1() / 2.0;
        assert_mean(
            &format!("front, g {g}"),
            mean(&image, &variance, 1),
            expected,
        );
    }
}

#[test]
fn single_scattering_of_a_back_light_is_the_closed_form() {
    let device = device();
    let tau = 2.0;
    for g in [-0.8, 0.0, 0.8] {
        let mut s = traced(homogeneous(tau, g), 2048, Some(1));
        s.lights = light_along(-DVec3::Y);
        let (image, variance) = estimate(&device, &s);
        let expected = 3.0 * 0.9 * phase_hg(1.0, g) * tau * (-tau).exp();
        assert_mean(
            &format!("back, g {g}"),
            mean(&image, &variance, 1),
            expected,
        );
    }
}

#[test]
fn single_scattering_of_a_point_light_inside_is_the_closed_form() {
    // A thin medium: L = sigma_s p int I / d^2 ds along a ray that passes at distance h.
    let device = device();
    let mut s = traced(homogeneous(8e-4, 0.0), 4096, Some(1));
    s.camera.projection = Projection::Orthographic { height: 0.02 };
    s.camera.eye += 1.5 * DVec3::X;
    s.camera.target += 1.5 * DVec3::X;
    s.lights = vec![Light::Point {
        position: DVec3::ZERO,
        intensity: Vec3::splat(5.0),
        falloff: Falloff::InverseSquare,
    }];
    let (image, variance) = estimate(&device, &s);
    let integral = 2.0 * (4.0_f64 / 1.5).atan() / 1.5;
    let expected = 0.9 * 1e-4 / (4.0 * PI) * 5.0 * integral;
    // Attenuation that the closed form leaves out: at most 8e-4.
    let (found, error) = mean(&image, &variance, 0);
    assert!(
        (found - expected).abs() < Z * error + 8e-4 * expected && error < 0.01 * expected,
        "{found} +- {error}, expected {expected}"
    );
}

#[test]
fn a_white_furnace_is_white() {
    let device = device();
    for (name, mut s) in [("even", homogeneous(3.0, 0.6)), ("blob", blob())] {
        s.medium.albedo = 1.0;
        for p in &mut s.medium.transfer_function.points {
            p.color = Vec3::ONE;
        }
        s.image.background = Vec3::ONE;
        s.lights = vec![Light::Environment {
            radiance: Vec3::ONE,
        }];
        let (image, variance) = estimate(&device, &traced(s, 64, None));
        let (found, error) = mean(&image, &variance, 2);
        // Every path ends outside with weight 1: there is no variance but rounding's.
        assert!((found - 1.0).abs() < 1e-5, "{name}: {found} +- {error}");
        let farthest = image.pixels.iter().map(|p| (p[0] - 1.0).abs());
        assert!(farthest.fold(0.0, f32::max) < 1e-4, "{name}");
    }
}

#[test]
fn both_estimators_agree_on_multiple_scattering() {
    let device = device();
    let mut s = blob();
    s.lights = vec![
        Light::Directional {
            direction: DVec3::new(1.0, 0.5, -1.0),
            irradiance: Vec3::new(3.0, 2.0, 1.0),
        },
        Light::Environment {
            radiance: Vec3::new(0.2, 0.3, 0.4),
        },
    ];
    assert_estimators_agree("two lights", &device, &traced(s, 512, None));
}

#[test]
fn both_estimators_agree_on_a_clipped_emitter_with_a_light_inside() {
    let device = device();
    let mut s = blob();
    s.medium.emission = 0.3;
    s.clip.plane = Some(Plane {
        point: DVec3::new(0.0, -1.0, 0.0),
        normal: DVec3::new(0.3, 1.0, 0.2),
    });
    s.clip.bounds = Some((DVec3::splat(-8.0), DVec3::new(5.0, 9.0, 9.0)));
    s.lights = vec![Light::Point {
        // In the thick of it: 1 / d^2 would give the textbook estimator no finite variance.
        position: DVec3::new(1.0, 3.0, 1.0),
        intensity: Vec3::splat(4.0),
        falloff: Falloff::None,
    }];
    assert_estimators_agree("clipped", &device, &traced(s, 512, None));
}

#[test]
fn both_estimators_agree_on_two_scatterings_of_a_backward_medium() {
    let device = device();
    let mut s = blob();
    s.medium.phase_g = -0.8;
    s.lights = light_along(DVec3::new(0.2, 1.0, 0.1));
    assert_estimators_agree("two events", &device, &traced(s, 512, Some(2)));
}

#[test]
fn holes_in_the_data_are_empty() {
    let device = device();
    let v = volume(cube(12), ScalarType::F32, |i| {
        if i.x < 6 { 1.0 } else { f64::NAN }
    });
    let mut s = scene(v, constant(Vec3::ONE, 0.9));
    s.camera.projection = Projection::Orthographic { height: 12.0 };
    s.image.width = 12;
    s.image.height = 12;
    let image = render(&device, &traced(s, 64, None));
    for y in 0..12 {
        assert!(image.pixel(2, y).unwrap()[3] > 0.999);
        assert_eq!(image.pixel(9, y).unwrap()[3].to_bits(), 0);
    }
}

#[test]
fn the_same_seed_gives_the_same_bits_and_another_does_not() {
    let device = device();
    let first = traced(blob(), 16, None);
    let mut other = first.clone();
    other.technique = TechniqueParams::PathTrace(PathTraceParams {
        samples: 16,
        seed: 8,
        ..PathTraceParams::default()
    });
    let bits = |s: &Scene| {
        let pixels = render(&device, s).pixels;
        pixels
            .iter()
            .map(|p| p.map(f32::to_bits))
            .collect::<Vec<_>>()
    };
    assert_eq!(bits(&first), bits(&first));
    assert_ne!(bits(&first), bits(&other));
}

#[test]
fn the_stated_variance_is_that_of_repeated_renders() {
    let device = device();
    let seeds = 24;
    let (mut means, mut stated) = (Vec::new(), 0.0);
    for seed in 0..seeds {
        let mut s = blob();
        s.technique = TechniqueParams::PathTrace(PathTraceParams {
            samples: 32,
            seed,
            ..PathTraceParams::default()
        });
        let (image, variance) = estimate(&device, &s);
        let (m, error) = mean(&image, &variance, 0);
        means.push(m);
        stated += error * error / f64::from(seeds);
    }
    let n = means.len() as f64;
    let centre = means.iter().sum::<f64>() / n;
    let found = means.iter().map(|m| (m - centre).powi(2)).sum::<f64>() / (n - 1.0);
    // A variance from 24 draws has a relative standard error of sqrt(2 / 23) = 0.29.
    let ratio = found / stated;
    assert!((0.2..2.2).contains(&ratio), "{ratio}");
}
