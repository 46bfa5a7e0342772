//! Noise that moves what is looked up and varies what is found: every technique sees one medium, that of the
//! equations; nothing is skipped that it moves in.
#![allow(clippy::unwrap_used, clippy::expect_used)]

mod common;
mod estimates;
mod materials;

use std::sync::Arc;

use common::{constant, cube, device, points, render, scene, volume, with};
use estimates::{assert_estimators_agree, blob, estimate, traced};
use glam::{DVec3, UVec3, Vec3};
use materials::{
    assert_all_see_the_equations, assert_leaves_bound, assert_skipped_is_empty,
    assert_sums_are_the_naive_ones, every_technique, shapes,
};
use tyndall::scene::transfer_function::{Primitive, Shape};
use tyndall::scene::{
    Octave, Perturbation, Projection, Scene, SingleScatterParams, TechniqueParams,
};
use tyndall::technique::Renderer;
use tyndall::technique::summed_area::{FieldKind, probe};
use tyndall::volume::{ColorVolume, Grid, ScalarType};

fn octave(frequency: f64, displacement: f64, opacity: f64, color: Vec3) -> Octave {
    Octave {
        frequency,
        displacement,
        opacity,
        color,
        offset: DVec3::new(0.3, -0.1, 0.7),
        velocity: DVec3::new(0.5, 0.25, -1.0),
    }
}

/// Three octaves that move, one that varies, and one that does both.
fn noise() -> Perturbation {
    Perturbation {
        seed: 3,
        octaves: vec![
            octave(0.2, 2.0, 0.0, Vec3::ZERO),
            octave(0.4, 1.0, 0.0, Vec3::ZERO),
            octave(0.3, 0.0, 0.4, Vec3::new(0.5, 0.1, 0.0)),
            octave(0.8, 0.5, 0.3, Vec3::new(0.0, 0.3, 0.6)),
        ],
        time: 2.0,
    }
}

fn perturbed(mut s: Scene) -> Scene {
    s.medium.perturbation = Some(noise());
    s
}

/// A small ball in vacuum, which noise carries across several cells.
fn ball() -> Scene {
    let dims = UVec3::new(40, 36, 44);
    let v = volume(
        Grid::centred(dims, DVec3::new(1.0, 1.1, 0.9)),
        ScalarType::U8,
        |i| {
            let p = i.as_dvec3() - 0.5 * dims.as_dvec3();
            (255.0 * (2.0 - p.length() / 5.0)).clamp(0.0, 255.0).round()
        },
    );
    let mut s = scene(
        v,
        points(&[
            (0.0, Vec3::ONE, 0.0),
            (20.0, Vec3::ONE, 0.0),
            (255.0, Vec3::ONE, 0.4),
        ]),
    );
    s.medium.perturbation = Some(Perturbation {
        seed: 1,
        octaves: vec![
            octave(0.1, 6.0, 0.0, Vec3::ZERO),
            octave(0.25, 4.0, 0.0, Vec3::ZERO),
            octave(0.5, 2.0, 0.5, Vec3::ZERO),
        ],
        time: 0.0,
    });
    (s.image.width, s.image.height) = (48, 48);
    s
}

#[test]
fn every_technique_sees_the_medium_of_the_equations() {
    let mut device = device();
    let mut s = perturbed(blob());
    assert_all_see_the_equations(&device, &s);
    device.prefer_filter();
    assert_all_see_the_equations(&device, &s);
    // Where gradients decide as well.
    s.medium.transfer_function = shapes(&[Primitive {
        shape: Shape::Gaussian,
        value: [0.0, 1200.0],
        gradient: [0.0, 400.0],
        color: Vec3::new(0.9, 0.5, 0.7),
        opacity: 0.4,
    }]);
    assert_all_see_the_equations(&device, &s);
}

#[test]
fn an_albedo_volume_moves_along() {
    let device = device();
    let mut s = perturbed(blob());
    let dims = s.volume.grid.dims;
    let color = |i: u32| {
        let x = i % dims.x;
        [x as f32 / dims.x as f32, 0.5, 0.25]
    };
    let colors: Vec<_> = (0..dims.element_product()).map(color).collect();
    s.medium.albedo_volume = Some(Arc::new(ColorVolume::new("colors", dims, &colors)));
    assert_all_see_the_equations(&device, &s);
}

#[test]
fn paths_are_those_of_the_textbook() {
    let device = device();
    assert_estimators_agree("noise", &device, &traced(perturbed(blob()), 1600, None));
}

#[test]
fn summed_areas_are_the_naive_sums() {
    let device = device();
    let s = perturbed(blob());
    assert_sums_are_the_naive_ones(&device, &s);
}

#[test]
fn cells_that_noise_may_reach_are_not_skipped() {
    let device = device();
    let s = ball();
    let still = Scene {
        medium: tyndall::scene::Medium {
            perturbation: None,
            ..s.medium.clone()
        },
        ..s.clone()
    };
    let all = assert_skipped_is_empty(&device, &s);
    let resting = render(&device, &still);
    let pairs = all.pixels.iter().zip(&resting.pixels);
    let moved = pairs.filter(|(a, b)| a[3] > 0.0 && b[3] == 0.0).count();
    assert!(moved > 10, "noise moves it: {moved}");
}

#[test]
fn leaves_bound_the_noise() {
    let device = device();
    for s in [ball(), perturbed(blob())] {
        let (plan, _, _) = probe(&device, &s, FieldKind::AmbientExtinction, 1.0).unwrap();
        assert_eq!(plan.area.cell, UVec3::ONE);
        let [within, _] = assert_leaves_bound(&device, &s);
        assert!(within > 100, "bounds are of use: {within}");
    }
}

#[test]
fn a_thin_medium_is_scattered_in_once_by_paths_and_by_the_march() {
    let device = device();
    let mut s = perturbed(blob());
    s.medium.density_scale = 1e-3;
    s.medium.phase_g = 0.0;
    let (image, variance) = estimate(&device, &traced(s.clone(), 4000, Some(1)));
    s.technique = TechniqueParams::SingleScatter(SingleScatterParams {
        step: 0.25,
        ..SingleScatterParams::default()
    });
    // The reference averages over the pixel's area.
    s.image.samples_per_axis = 4;
    let marched = render(&device, &s);
    for channel in 0..3 {
        let (found, error) = estimates::mean(&image, &variance, channel);
        let n = marched.pixels.len() as f64;
        let expected = marched
            .pixels
            .iter()
            .map(|p| f64::from(p[channel]))
            .sum::<f64>()
            / n;
        let off = (found - expected).abs();
        assert!(
            off < 5.0 * error + 0.01 * expected && error < 0.03 * expected,
            "{found} {expected}"
        );
    }
}

#[test]
fn noise_that_varies_an_even_medium_keeps_its_mean() {
    // The optical depth along rays that cross many texels is that of the even medium, on average.
    let device = device();
    let mut s = scene(
        volume(cube(32), ScalarType::U8, |_| 1.0),
        constant(Vec3::ONE, 0.01),
    );
    s.camera.projection = Projection::Orthographic { height: 32.0 };
    let depth = |s: &Scene| {
        let image = render(&device, s);
        let sum: f64 = image
            .pixels
            .iter()
            .map(|p| -f64::from(1.0 - p[3]).ln())
            .sum();
        sum / image.pixels.len() as f64
    };
    let even = depth(&s);
    s.medium.perturbation = Some(Perturbation {
        seed: 0,
        // One tile across: the mean over it is exactly a half.
        octaves: vec![octave(1.0, 0.0, 1.0, Vec3::ZERO)],
        time: 0.0,
    });
    let varied = depth(&s);
    assert!((varied / even - 1.0).abs() < 1e-3, "{varied} {even}");
}

#[test]
fn a_smaller_step_changes_hardly_anything() {
    let device = device();
    let s = perturbed(blob());
    let at = |step| render(&device, &with(s.clone(), |p| p.step = step));
    let (coarse, fine) = (at(0.5), at(0.125));
    let pairs = coarse
        .pixels
        .iter()
        .flatten()
        .zip(fine.pixels.iter().flatten());
    let farthest = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(farthest < 1e-2, "{farthest}");
}

#[test]
fn time_runs_the_stages_that_depend_on_noise_and_no_upload_of_voxels() {
    let device = device();
    for s in every_technique(&ball()) {
        let mut renderer = Renderer::new(&device, s.clone()).unwrap();
        let (before, _) = renderer.render(&mut |_, _, _| {}).unwrap();
        let mut later = s.clone();
        later.medium.perturbation.as_mut().unwrap().time = 1.5;
        renderer.set_scene(later.clone()).unwrap();
        let (after, report) = renderer.render(&mut |_, _, _| {}).unwrap();
        let ran = |name: &str| report.stages.iter().any(|s| s.name == name);
        assert!(!ran("medium.upload_volume") && ran("medium.upload_table"));
        assert_ne!(before.pixels, after.pixels);
        drop(renderer);
        // The same as a fresh start.
        assert_eq!(render(&device, &later).pixels, after.pixels);
    }
}
