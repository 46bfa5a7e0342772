//! Transfer functions over values and gradients: every technique sees one medium, that of the equations.
#![allow(clippy::unwrap_used, clippy::expect_used)]

mod common;
mod estimates;
mod materials;

use common::{centre, device, params, render, scene, volume, with};
use estimates::{assert_estimators_agree, traced};
use glam::{DVec3, UVec3, Vec3};
use materials::{assert_all_see_the_equations, every_technique, shapes};
use tyndall::scene::transfer_function::{Primitive, Shape};
use tyndall::scene::{Projection, Scene, Shading, TechniqueParams};
use tyndall::technique::Renderer;
use tyndall::technique::summed_area::{FieldKind, probe, reference};
use tyndall::volume::{Grid, ScalarType};

fn even_box(value: [f64; 2], gradient: [f64; 2], opacity: f64) -> Primitive {
    Primitive {
        shape: Shape::Box,
        value,
        gradient,
        color: Vec3::new(0.8, 0.6, 0.4),
        opacity,
    }
}

/// Smooth bumps on anisotropic voxels, 0 at the sides, of values to 1000.
fn bumps(scalar_type: ScalarType) -> Scene {
    let dims = UVec3::new(20, 24, 18);
    let grid = Grid::centred(dims, DVec3::new(1.2, 1.0, 1.5));
    let v = volume(grid, scalar_type, |i| {
        let p = (i.as_dvec3() + 0.5) / dims.as_dvec3() - 0.5;
        let bump = |c: DVec3, r: f64| (-(p - c).length_squared() / (r * r)).exp();
        let sum = bump(DVec3::new(0.1, 0.05, -0.1), 0.2) + 0.7 * bump(DVec3::splat(-0.15), 0.15);
        (1000.0 * sum).min(1000.0).round()
    });
    let mut s = scene(
        v,
        shapes(&[
            Primitive {
                shape: Shape::Gaussian,
                value: [100.0, 500.0],
                gradient: [20.0, 300.0],
                color: Vec3::new(0.8, 0.6, 0.4),
                opacity: 0.4,
            },
            Primitive {
                shape: Shape::Triangle,
                value: [300.0, 900.0],
                // Its upper side, which has no slope, is beyond all gradients.
                gradient: [0.0, 400.0],
                color: Vec3::new(0.2, 0.9, 0.3),
                opacity: 0.5,
            },
            Primitive {
                shape: Shape::Gaussian,
                value: [500.0, 1100.0],
                gradient: [0.0, 120.0],
                color: Vec3::new(0.9, 0.3, 0.2),
                opacity: 0.4,
            },
        ]),
    );
    (s.image.width, s.image.height) = (12, 12);
    s.medium.albedo = 0.9;
    s
}

#[test]
fn a_ramp_is_as_steep_as_its_world_says() {
    // Values rise by 6 a voxel along x: 6 / spacing a world unit, whatever the axis' direction in the grid.
    let device = device();
    for (spacing, steep) in [(1.0, 6.0), (0.25, 24.0), (30.0, 0.2)] {
        let grid = Grid::centred(UVec3::splat(16), DVec3::new(spacing, 1.0, 1.0));
        let v = volume(grid, ScalarType::F32, |i| 10.0 + 6.0 * f64::from(i.x));
        let depth = 0.7;
        let opacity = -(-depth / 16.0_f64).exp_m1();
        let around = [0.9 * steep, 1.1 * steep];
        for (gradient, expected) in [
            (around, -(-depth).exp_m1()),
            ([1.2 * steep, 2.0 * steep], 0.0),
            ([0.0, 0.8 * steep], 0.0),
        ] {
            let mut s = scene(
                v.clone(),
                shapes(&[even_box([-1e3, 1e3], gradient, opacity)]),
            );
            s.camera.projection = Projection::Orthographic {
                height: 4.0 * spacing.min(1.0),
            };
            // At the faces too, where differences are to one side.
            for shift in [0.0, 0.49 * 16.0 * spacing] {
                let mut s = s.clone();
                s.camera.eye.x += shift;
                s.camera.target.x += shift;
                (s.image.width, s.image.height) = (1, 1);
                let found = f64::from(centre(&render(&device, &s))[3]);
                assert!(
                    (found - expected).abs() < 1e-4,
                    "spacing {spacing}, {gradient:?}, at {shift}: {found}, not {expected}"
                );
            }
        }
    }
}

#[test]
fn every_technique_sees_the_medium_of_the_equations() {
    let device = device();
    for scalar_type in [ScalarType::U16, ScalarType::F32] {
        assert_all_see_the_equations(&device, &bumps(scalar_type));
    }
    let mut filtering = device;
    filtering.prefer_filter();
    assert_all_see_the_equations(&filtering, &bumps(ScalarType::I16));
}

#[test]
fn paths_are_those_of_the_textbook() {
    assert_estimators_agree(
        "gradients",
        &device(),
        &traced(bumps(ScalarType::U16), 600, None),
    );
}

#[test]
fn summed_areas_are_the_naive_sums() {
    let device = device();
    let s = bumps(ScalarType::U16);
    let (plan, texels, _) = probe(&device, &s, FieldKind::AmbientExtinction, 2.0).unwrap();
    let expected = reference::field(&s, &plan);
    let largest = expected.iter().copied().fold(0.0, f64::max);
    assert!(largest > 0.1);
    for (found, expected) in texels.iter().zip(&expected) {
        // The table's bilinear filter, and half floats.
        assert!((f64::from(*found) - expected).abs() < 1e-3 * expected + 2e-3 * largest);
    }
}

#[test]
fn skipping_changes_nothing_and_a_smaller_step_hardly_anything() {
    let device = device();
    let mut s = bumps(ScalarType::U16);
    // A triangle's tip is narrower than any step.
    let smooth = &mut s.medium.transfer_function.primitives;
    smooth.retain(|p| p.shape == Shape::Gaussian);
    let p = Renderer::new(&device, s.clone()).unwrap().plan().clone();
    assert!(p.stages.iter().any(|s| s.name == "medium.cell_distance"));
    for shading in [None, Some(Shading::default())] {
        let at = |step, skip| {
            let s = with(s.clone(), |p| {
                (p.step, p.shading, p.empty_space_skipping) = (step, shading, skip);
            });
            render(&device, &s)
        };
        let image = at(0.5, true);
        if shading.is_some() {
            assert_eq!(image.pixels, at(0.5, false).pixels);
        }
        let finer = at(0.25, false);
        let farthest = image
            .pixels
            .iter()
            .flatten()
            .zip(finer.pixels.iter().flatten());
        let farthest = farthest.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(farthest < 6e-3, "{farthest}");
    }
}

#[test]
fn a_volume_without_a_shape_is_empty_and_holes_are_too() {
    let device = device();
    let dims = UVec3::splat(12);
    let v = volume(Grid::centred(dims, DVec3::ONE), ScalarType::F32, |i| {
        if i == UVec3::splat(6) {
            f64::NAN
        } else {
            f64::from(i.x)
        }
    });
    let mut s = scene(v, shapes(&[even_box([0.0, 20.0], [0.9, 1.1], 0.5)]));
    s.technique = TechniqueParams::RayMarch(params());
    let image = render(&device, &s);
    // Next to the hole the gradient is not known: 3 voxels and what the filter reaches are missing on the rays
    // through it, and no other gradient is invented.
    let (hole, beside) = (centre(&image)[3], image.pixel(22, 22).unwrap()[3]);
    assert!(hole < beside && hole > 0.9, "{hole} {beside}");
    s.medium.transfer_function = shapes(&[even_box([0.0, 20.0], [3.0, 4.0], 0.5)]);
    for s in every_technique(&s) {
        assert!(render(&device, &s).pixels.iter().all(|p| p[3] == 0.0));
    }
}
