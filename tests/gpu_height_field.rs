//! Height fields: every technique sees the medium of the equations about the surface, and none makes it a volume.
#![allow(clippy::unwrap_used, clippy::expect_used)]

mod common;
mod estimates;
mod materials;

use std::sync::Arc;

use common::{constant, device, params, points, render, scene, with};
use estimates::{assert_estimators_agree, estimate, traced};
use glam::{DVec2, DVec3, UVec2, UVec3, Vec3};
use materials::{
    assert_all_see_the_equations, assert_leaves_bound, assert_skipped_is_empty,
    assert_sums_are_the_naive_ones, every_technique, shapes,
};
use tyndall::scene::transfer_function::{Primitive, Shape};
use tyndall::scene::{
    Light, Octave, Perturbation, Projection, Scene, Shading, SingleScatterParams, TechniqueParams,
};
use tyndall::technique::{Renderer, ResourceKind};
use tyndall::volume::{ColorVolume, HeightMap, Layer, Rescale, Sheet, Statistics, Volume, Voxels};

const LAYER: Layer = Layer {
    bottom: -4.0,
    top: 1.5,
    ramp: 1.0,
};

fn map(dims: UVec2, value: impl Fn(DVec2) -> f64) -> HeightMap {
    let at = |i: u32| DVec2::new((i % dims.x).into(), (i / dims.x).into()) / dims.as_dvec2();
    let values = (0..dims.element_product()).map(|i| value(at(i)) as f32);
    HeightMap {
        name: "map".to_owned(),
        dims,
        voxels: Voxels::F32(values.collect()),
        rescale: Rescale::IDENTITY,
        spacing: None,
        spatial_unit: None,
    }
}

fn waves(p: DVec2) -> f64 {
    2.0 + (7.0 * p.x).sin() + (5.0 * p.y + 3.0 * p.x).cos()
}

fn field(map: &HeightMap, scalars: Option<HeightMap>, layer: Layer) -> Volume {
    let sheet = Sheet {
        size: DVec2::new(24.0, 20.0),
        height: 2.5,
        layer,
        margin: 0.0,
    };
    map.volume(scalars, &sheet).unwrap()
}

/// Waves of heights 0 to 4, 24 x 20 world units, seen from above at a slant; denser where they are high.
fn hills() -> Scene {
    let heights = map(UVec2::new(24, 20), waves);
    let mut s = scene(
        field(&heights, None, LAYER),
        points(&[
            (0.0, Vec3::new(0.9, 0.5, 0.3), 0.05),
            (2.0, Vec3::new(0.3, 0.9, 0.4), 0.15),
            (4.0, Vec3::new(0.4, 0.5, 0.9), 0.3),
        ]),
    );
    (s.image.width, s.image.height) = (12, 12);
    s.camera.eye = s.camera.target + DVec3::new(8.0, -22.0, 18.0);
    s.camera.projection = Projection::Perspective { vfov_deg: 50.0 };
    s.medium.albedo = 0.9;
    s
}

fn noise() -> Perturbation {
    let octave = |frequency, displacement, opacity| Octave {
        frequency,
        displacement,
        opacity,
        color: Vec3::ZERO,
        offset: DVec3::new(0.3, -0.1, 0.7),
        velocity: DVec3::ZERO,
    };
    Perturbation {
        seed: 3,
        octaves: vec![octave(0.3, 1.2, 0.0), octave(0.7, 0.4, 0.5)],
        time: 0.0,
    }
}

#[test]
fn every_technique_sees_the_medium_of_the_equations() {
    let mut device = device();
    assert_all_see_the_equations(&device, &hills());
    device.prefer_filter();
    assert_all_see_the_equations(&device, &hills());
}

#[test]
fn noise_moves_the_surface() {
    let device = device();
    let mut s = hills();
    s.medium.perturbation = Some(noise());
    assert_all_see_the_equations(&device, &s);
}

#[test]
fn scalars_and_colors_lie_over_it_and_slopes_classify_it() {
    let device = device();
    let dims = UVec2::new(24, 20);
    let scalars = map(dims, |p| 100.0 * p.x * (1.0 - p.y));
    let mut s = hills();
    s.volume = Arc::new(field(&map(dims, waves), Some(scalars), LAYER));
    s.statistics = Arc::new(Statistics::of(&s.volume));
    s.medium.transfer_function = shapes(&[
        Primitive {
            shape: Shape::Gaussian,
            value: [-20.0, 60.0],
            gradient: [0.0, 8.0],
            color: Vec3::new(0.9, 0.5, 0.7),
            opacity: 0.2,
        },
        Primitive {
            shape: Shape::Triangle,
            value: [20.0, 110.0],
            gradient: [1.0, 9.0],
            color: Vec3::new(0.2, 0.9, 0.3),
            opacity: 0.3,
        },
    ]);
    let color = |i: u32| [(i % 24) as f32 / 24.0, 0.5, (i / 24) as f32 / 20.0];
    let colors: Vec<_> = (0..dims.element_product()).map(color).collect();
    let colors = ColorVolume::new("colors", dims.extend(1), &colors);
    s.medium.albedo_volume = Some(Arc::new(colors));
    assert_all_see_the_equations(&device, &s);
}

#[test]
fn paths_are_those_of_the_textbook() {
    let device = device();
    assert_estimators_agree("hills", &device, &traced(hills(), 1600, None));
    let mut s = hills();
    s.medium.perturbation = Some(noise());
    assert_estimators_agree("moving hills", &device, &traced(s, 1600, None));
    // One extinction for all values: neither the walk's shortcut for a straight line nor the one leaf of a thin medium
    // forgets where the layer ends.
    for opacity in [0.2, 0.002] {
        let mut s = hills();
        s.medium.transfer_function = constant(Vec3::new(0.9, 0.6, 0.4), opacity);
        assert_estimators_agree("even hills", &device, &traced(s, 1600, None));
    }
}

#[test]
fn a_slope_is_lit_as_it_lies() {
    // From its edges to its middle, in a box of many layers and of few.
    let device = device();
    for (slope, bottom) in [(0.0, -0.02), (0.0, -4.0), (0.5, -1.0), (-0.4, -1.0)] {
        let layer = Layer {
            bottom,
            top: 0.0,
            ramp: -0.25 * bottom,
        };
        let columns = |p: DVec2| slope * 24.0 * (p.x + 0.5 / 24.0) / 2.5;
        let mut s = scene(
            field(&map(UVec2::new(24, 20), columns), None, layer),
            constant(Vec3::ONE, 1.0 - 1e-6),
        );
        s.medium.density_scale = 50.0;
        s.camera.eye = s.camera.target + 100.0 * DVec3::Z;
        s.camera.up = DVec3::Y;
        s.camera.projection = Projection::Orthographic { height: 19.0 };
        let normal = DVec3::new(-slope, 0.0, 1.0).normalize();
        let direction = DVec3::new(0.6, 0.0, -0.8);
        s.lights = vec![Light::Directional {
            direction,
            irradiance: Vec3::splat(std::f32::consts::PI),
        }];
        let shading = Shading {
            ambient: 0.0,
            diffuse: 1.0,
            specular: 0.0,
            ..Shading::default()
        };
        let image = render(
            &device,
            &with(s, |p| (p.step, p.shading) = (0.25, Some(shading))),
        );
        let expected = -normal.dot(direction);
        for pixel in &image.pixels {
            let found = f64::from(pixel[0]);
            assert!(
                (found - expected).abs() < 2e-3,
                "{slope}: {found}, {expected}"
            );
        }
    }
}

#[test]
fn holes_of_the_scalars_are_empty() {
    let device = device();
    let dims = UVec2::new(24, 20);
    let scalars = map(dims, |p| if p.x > 0.5 { f64::NAN } else { 1.0 });
    let mut s = scene(
        field(&map(dims, |_| 1.0), Some(scalars), LAYER),
        constant(Vec3::ONE, 0.5),
    );
    s.camera.eye = s.camera.target + 100.0 * DVec3::Z;
    s.camera.up = DVec3::Y;
    for s in every_technique(&s)
        .into_iter()
        .chain([traced(s.clone(), 16, None)])
    {
        let image = render(&device, &s);
        let (left, right): (Vec<_>, Vec<_>) = (0..32 * 32)
            .filter(|i| (8..24).contains(&(i / 32)))
            .partition(|i| i % 32 < 15);
        let solid = left.iter().filter(|i| image.pixels[**i][3] > 0.5).count();
        let seen = right
            .iter()
            .filter(|i| *i % 32 > 16 && image.pixels[**i][3] > 0.0)
            .count();
        assert!(
            solid > 100 && seen == 0,
            "{}: {solid}, {seen}",
            s.technique.name()
        );
    }
}

#[test]
fn paths_and_the_march_scatter_once_alike() {
    let device = device();
    let mut s = hills();
    s.medium.density_scale = 0.05;
    let (image, variance) = estimate(&device, &traced(s.clone(), 4000, Some(1)));
    s.technique = TechniqueParams::SingleScatter(SingleScatterParams {
        step: 0.25,
        ..SingleScatterParams::default()
    });
    s.image.samples_per_axis = 4;
    let marched = render(&device, &s);
    for channel in 0..3 {
        let (found, error) = estimates::mean(&image, &variance, channel);
        let sum: f64 = marched.pixels.iter().map(|p| f64::from(p[channel])).sum();
        let expected = sum / marched.pixels.len() as f64;
        // The march's own error, beside the estimate's.
        assert!(
            (found - expected).abs() < 4.0 * error + 3e-3 * expected,
            "{found} +- {error}, {expected}"
        );
    }
}

#[test]
fn a_flat_layer_dims_as_its_ramps_say() {
    // Full between the ramps, half on average within: the depth is sigma_t (thickness - ramp).
    let device = device();
    for layer in [
        LAYER,
        Layer {
            bottom: -1.0,
            top: 1.0,
            ramp: 0.05,
        },
    ] {
        let opacity = 0.2;
        let mut s = scene(
            field(&map(UVec2::splat(8), |_| 3.0), None, layer),
            constant(Vec3::ONE, opacity),
        );
        s.camera.eye = s.camera.target + 50.0 * DVec3::Z;
        s.camera.up = DVec3::Y;
        s.camera.projection = Projection::Orthographic { height: 4.0 };
        let image = render(&device, &with(s, |p| p.step = 0.125));
        let depth = -(1.0_f64 - opacity).ln() * (layer.top - layer.bottom - layer.ramp);
        for pixel in &image.pixels {
            let alpha = f64::from(pixel[3]);
            assert!((alpha + (-depth).exp_m1()).abs() < 2e-5, "{alpha}, {depth}");
        }
    }
}

#[test]
fn what_is_skipped_is_empty() {
    let device = device();
    for perturbation in [None, Some(noise())] {
        let mut s = hills();
        s.medium.perturbation = perturbation;
        (s.image.width, s.image.height) = (48, 48);
        assert_skipped_is_empty(&device, &s);
    }
}

#[test]
fn leaves_bound_it_and_summed_areas_are_the_naive_sums() {
    let device = device();
    let mut s = hills();
    let steep = map(UVec2::new(40, 36), |p| 3.0 * waves(p));
    s.volume = Arc::new(field(&steep, None, LAYER));
    s.statistics = Arc::new(Statistics::of(&s.volume));
    // Where it is thin, leaves are better left whole.
    s.medium.density_scale = 20.0;
    let [within, empty] = assert_leaves_bound(&device, &s);
    assert!(
        within > 100 && empty > 100,
        "bounds are of use: {within}, {empty}"
    );
    assert_sums_are_the_naive_ones(&device, &s);
}

#[test]
fn nothing_is_stored_along_z() {
    let device = device();
    let heights = map(UVec2::splat(1024), waves);
    let sheet = Sheet {
        size: DVec2::splat(20.0),
        height: 2.5,
        layer: LAYER,
        margin: 0.0,
    };
    let v = heights.volume(None, &sheet).unwrap();
    let grid = v.grid.dims;
    assert!(grid.z > 500, "{grid}");
    let mut s = scene(v, constant(Vec3::ONE, 0.5));
    (s.image.width, s.image.height) = (8, 8);
    s.technique = TechniqueParams::RayMarch(params());
    for s in [s.clone(), every_technique(&s)[4].clone()] {
        let plan = Renderer::new(&device, s).unwrap().plan().clone();
        let map = 1024 * 1024;
        for r in &plan.resources {
            let texels = r.extent.as_u64vec3().element_product();
            let is_image = r.kind != ResourceKind::Staging;
            assert!(!is_image || texels <= map, "{}: {}", r.name, r.extent);
            if r.kind == ResourceKind::Volume {
                assert_eq!(r.extent, UVec3::new(1024, 1024, 1), "{}", r.name);
            }
        }
    }
}
