//! What an image must show: orientation, clips, skipping, odd data, the CPU reference.
#![allow(clippy::unwrap_used)]

mod common;

use common::{
    assert_close, centre, constant, cube, device, params_of, points, render, scene, volume, with,
};
use glam::{DAffine3, DMat3, DQuat, DVec2, DVec3, UVec3, Vec3};
use tyndall::output::Image;
use tyndall::scene::{Camera, Falloff, Light, Plane, Projection, Scene, Shading};
use tyndall::technique::ray_march::reference;
use tyndall::volume::procedural::Procedural;
use tyndall::volume::{Grid, ScalarType, Space};

const WHITE: Vec3 = Vec3::ONE;

/// A smooth blob with some texture, far from symmetric.
fn blob(i: UVec3, n: f64) -> f64 {
    let p = i.as_dvec3() / n - DVec3::new(0.4, 0.55, 0.5);
    (1.2 * (-12.0 * p.length_squared()).exp() + 0.1 * (25.0 * p.x).sin() * (20.0 * p.z).cos())
        .clamp(0.0, 1.0)
}

fn blob_scene(n: u32) -> Scene {
    let v = volume(cube(n), ScalarType::F32, |i| blob(i, f64::from(n)));
    let tf = points(&[
        (0.0, Vec3::new(0.1, 0.2, 0.9), 0.0),
        (0.3, Vec3::new(0.1, 0.8, 0.3), 0.0),
        (0.5, Vec3::new(0.9, 0.6, 0.1), 0.08),
        (1.0, Vec3::new(1.0, 0.9, 0.8), 0.4),
    ]);
    scene(v, tf)
}

/// A gradient for every sample.
fn shaded(s: Scene) -> Scene {
    with(s, |p| {
        p.shading = Some(Shading {
            ambient: 0.5,
            diffuse: 0.8,
            specular: 0.4,
            shininess: 12.0,
            merge_opacity: 0.0,
        })
    })
}

/// Neighbouring samples share gradients, as by default.
fn merged(s: Scene) -> Scene {
    with(shaded(s), |p| {
        if let Some(shading) = &mut p.shading {
            shading.merge_opacity = Shading::default().merge_opacity;
        }
    })
}

/// Largest difference of any channel.
fn largest_difference(a: &Image, b: &Image) -> f32 {
    a.pixels
        .iter()
        .flatten()
        .zip(b.pixels.iter().flatten())
        .map(|(x, y)| (x - y).abs())
        .fold(0.0, f32::max)
}

#[test]
fn a_marked_voxel_appears_on_its_side_of_the_image() {
    let device = device();
    // From the front (-y) with z up, the image's right is +x.
    for (voxel, x, y) in [
        (UVec3::new(7, 4, 4), 26, 14),
        (UVec3::new(0, 4, 4), 5, 14),
        (UVec3::new(4, 4, 7), 17, 5),
        (UVec3::new(4, 4, 0), 17, 26),
    ] {
        let v = volume(cube(8), ScalarType::U8, |i| {
            if i == voxel { 255.0 } else { 0.0 }
        });
        let mut s = scene(v, points(&[(0.0, WHITE, 0.0), (255.0, WHITE, 0.9)]));
        s.camera.projection = Projection::Orthographic { height: 11.0 };
        let image = render(&device, &s);
        let brightest = (0..32 * 32u32)
            .max_by(|a, b| {
                let alpha = |i: u32| image.pixel(i % 32, i / 32).unwrap()[3];
                alpha(*a).total_cmp(&alpha(*b))
            })
            .unwrap();
        let (bx, by) = (brightest % 32, brightest / 32);
        assert!(
            bx.abs_diff(x) <= 2 && by.abs_diff(y) <= 2,
            "{voxel}: found ({bx}, {by}), expected ({x}, {y})"
        );
    }
}

#[test]
fn a_mirrored_oblique_grid_shows_the_same_anatomy() {
    let device = device();
    let plain = blob_scene(24);
    let expected = render(&device, &plain);
    // The same field stored with x running the other way and y and z exchanged.
    let n = 24u32;
    let v = volume(cube(n), ScalarType::F32, |i| {
        blob(UVec3::new(n - 1 - i.x, i.z, i.y), f64::from(n))
    });
    let mut s = plain.clone();
    let half = 0.5 * f64::from(n - 1);
    let mut v = v;
    v.grid = Grid {
        dims: UVec3::splat(n),
        world_from_index: DAffine3::from_mat3_translation(
            DMat3::from_cols(-DVec3::X, DVec3::Z, DVec3::Y),
            DVec3::new(half, -half, -half),
        ),
        space: Space::Unspecified,
    };
    s.volume = std::sync::Arc::new(v);
    let found = render(&device, &s);
    let difference = largest_difference(&expected, &found);
    assert!(difference < 2e-5, "{difference}");
}

#[test]
fn the_image_follows_the_cpu_reference() {
    let device = device();
    let mut perspective = shaded(blob_scene(24));
    perspective.camera = Camera {
        eye: DVec3::new(30.0, -40.0, 25.0),
        target: DVec3::new(1.0, 0.0, -1.0),
        up: DVec3::Z,
        projection: Projection::Perspective { vfov_deg: 35.0 },
    };
    perspective.image.height = 24;
    perspective.image.background = Vec3::new(0.1, 0.2, 0.3);
    perspective.lights = vec![
        Light::Directional {
            direction: DVec3::new(1.0, 2.0, -1.0),
            irradiance: Vec3::new(3.0, 2.5, 2.0),
        },
        Light::Point {
            position: DVec3::new(-20.0, -15.0, 10.0),
            intensity: Vec3::new(400.0, 500.0, 900.0),
            falloff: Falloff::InverseSquare,
        },
        Light::Point {
            position: DVec3::new(5.0, -25.0, 0.0),
            intensity: Vec3::splat(0.5),
            falloff: Falloff::None,
        },
        Light::Environment {
            radiance: Vec3::splat(0.2),
        },
    ];
    let mut clipped = perspective.clone();
    clipped.clip.bounds = Some((DVec3::splat(-8.0), DVec3::new(6.0, 9.0, 10.0)));
    clipped.clip.plane = Some(Plane {
        point: DVec3::ZERO,
        normal: DVec3::new(-1.0, 0.4, 0.2),
    });
    for (what, s) in [
        ("emission", blob_scene(24)),
        ("shaded", perspective),
        ("clipped", clipped),
    ] {
        let image = render(&device, &s);
        for y in 0..s.image.height {
            for x in 0..s.image.width {
                let at = DVec2::new(
                    (f64::from(x) + 0.5) / f64::from(s.image.width),
                    (f64::from(y) + 0.5) / f64::from(s.image.height),
                );
                let expected = reference::march(&s, &params_of(&s), at)
                    .as_vec4()
                    .to_array();
                let found = image.pixel(x, y).unwrap();
                for channel in 0..4 {
                    // f32 positions move samples by 1e-6 of the volume; the table has 1024 entries.
                    let difference = (found[channel] - expected[channel]).abs();
                    assert!(
                        difference < 1e-3,
                        "{what} ({x}, {y}): found {found:?}, expected {expected:?}"
                    );
                }
            }
        }
    }
}

#[test]
fn skipping_empty_space_changes_nothing_but_rounding() {
    let device = device();
    let sparse = |i: UVec3| {
        if (i.x / 5 + i.y / 7 + i.z / 3).is_multiple_of(4) {
            f64::from(i.x * 8)
        } else {
            0.0
        }
    };
    let grid = Grid::centred(UVec3::new(37, 29, 22), DVec3::new(1.0, 1.3, 0.7));
    let tf = points(&[
        (0.0, WHITE, 0.0),
        (40.0, WHITE, 0.0),
        (60.0, Vec3::new(0.9, 0.3, 0.1), 0.3),
        (300.0, WHITE, 0.6),
    ]);
    let mut scenes = vec![scene(volume(grid, ScalarType::U16, sparse), tf.clone())];
    scenes.push(shaded(blob_scene(30)));
    scenes.push(merged(blob_scene(30)));
    let marked = volume(cube(33), ScalarType::U8, |i| {
        if i == UVec3::splat(16) { 255.0 } else { 0.0 }
    });
    scenes.push(scene(
        marked,
        points(&[(0.0, WHITE, 0.0), (5.0, WHITE, 0.0), (255.0, WHITE, 0.9)]),
    ));
    for (i, s) in scenes.into_iter().enumerate() {
        for (eye, step) in [
            (DVec3::new(40.0, -60.0, 33.0), 0.5),
            (DVec3::new(0.0, -60.0, 0.0), 1.0),
            (DVec3::new(-3.0, 2.0, 5.0), 0.3),
        ] {
            let mut s = with(s.clone(), |p| {
                p.step = step;
                p.early_termination = 0.98;
            });
            s.camera = Camera {
                eye,
                projection: Projection::Perspective { vfov_deg: 40.0 },
                ..s.camera
            };
            // An odd size has a ray through the centre, where the single voxel is.
            (s.image.width, s.image.height) = (33, 33);
            let skipped = render(&device, &s);
            let whole = render(&device, &with(s, |p| p.empty_space_skipping = false));
            let difference = largest_difference(&skipped, &whole);
            assert!(
                difference <= 4.0 * f32::EPSILON,
                "scene {i} from {eye}: {difference}"
            );
            let seen = skipped.pixels.iter().any(|p| p[3] > 0.0);
            // The camera inside looks away from the single voxel's few pixels.
            assert!(
                seen || (i == 2 && eye.x < 0.0),
                "scene {i} from {eye} shows something"
            );
        }
    }
}

#[test]
fn results_converge_as_the_step_shrinks() {
    let device = device();
    let at = |step: f64| render(&device, &with(blob_scene(24), |p| p.step = step));
    let finest = at(1.0 / 32.0);
    let errors: Vec<f32> = [1.0, 0.5, 0.25]
        .map(|s| largest_difference(&at(s), &finest))
        .to_vec();
    // The midpoint rule is of second order where the transfer function is smooth.
    assert!(
        errors[1] < 0.6 * errors[0] && errors[2] < 0.6 * errors[1],
        "{errors:?}"
    );
    assert!(errors[2] < 0.01, "{errors:?}");
}

#[test]
fn early_termination_leaves_at_most_its_share() {
    let device = device();
    let exact = render(&device, &blob_scene(24));
    let early = render(
        &device,
        &with(blob_scene(24), |p| p.early_termination = 0.9),
    );
    let difference = largest_difference(&exact, &early);
    assert!(difference > 0.0 && difference <= 0.1, "{difference}");
}

#[test]
fn the_lit_side_faces_the_light_whatever_the_spacing() {
    let device = device();
    for spacing in [DVec3::ONE, DVec3::new(1.0, 0.2, 3.0)] {
        let dims = (DVec3::splat(24.0) / spacing).round().as_uvec3();
        let grid = Grid::centred(dims, spacing);
        let ball = |i: UVec3| {
            let r = grid
                .world_from_index
                .transform_point3(i.as_dvec3())
                .length();
            255.0 * (0.5 * (8.0 - r) + 0.5).clamp(0.0, 1.0)
        };
        let tf = points(&[
            (0.0, WHITE, 0.0),
            (100.0, WHITE, 0.0),
            (140.0, WHITE, 0.999),
        ]);
        let mut s = shaded(scene(volume(grid, ScalarType::U8, ball), tf));
        // From the left and above: the light travels to the right and down.
        s.lights = vec![Light::Directional {
            direction: DVec3::new(1.0, 0.6, -1.0),
            irradiance: Vec3::splat(3.0),
        }];
        s.camera.projection = Projection::Orthographic { height: 24.0 };
        s = with(s, |p| p.step = 0.25);
        let image = render(&device, &s);
        let at = |x: u32, y: u32| image.pixel(x, y).unwrap()[0];
        let (lit, dark) = (at(10, 10), at(21, 21));
        assert!(
            lit > 0.5 && dark < 0.3 * lit,
            "spacing {spacing}: lit {lit}, dark {dark}"
        );
        assert!(at(10, 10) > at(21, 10) && at(10, 10) > at(10, 21));
    }
}

#[test]
fn clips_keep_their_side() {
    let device = device();
    let s = || {
        scene(
            volume(cube(8), ScalarType::U8, |_| 1.0),
            constant(WHITE, 0.1),
        )
    };
    let full = 1.0 - 0.9f64.powi(8);
    let mut half = s();
    half.clip.plane = Some(Plane {
        point: DVec3::new(1.0, 0.0, 0.0),
        normal: DVec3::X,
    });
    half.camera.projection = Projection::Orthographic { height: 8.0 };
    let image = render(&device, &half);
    assert_eq!(
        image.pixel(4, 16).unwrap()[3],
        0.0,
        "left of x = 1 is cut away"
    );
    assert_close(
        "right is kept",
        f64::from(image.pixel(28, 16).unwrap()[3]),
        full,
        1e-5,
    );
    let mut thin = s();
    thin.clip.bounds = Some((DVec3::new(-9.0, -1.0, -9.0), DVec3::new(9.0, 0.5, 9.0)));
    let kept = 1.0 - 0.9f64.powf(1.5);
    assert_close(
        "box",
        f64::from(centre(&render(&device, &thin))[3]),
        kept,
        1e-5,
    );
    let mut none = s();
    none.clip.bounds = Some((DVec3::splat(50.0), DVec3::splat(60.0)));
    assert_eq!(
        centre(&render(&device, &none)),
        [0.0; 4],
        "a box beside the volume leaves nothing"
    );
}

#[test]
fn voxels_that_are_no_number_are_empty() {
    let device = device();
    for (bad, scalar_type) in [
        (f64::NAN, ScalarType::F32),
        (f64::INFINITY, ScalarType::F64),
        (f64::NEG_INFINITY, ScalarType::F32),
    ] {
        // The half x > 0 is bad; the constant opacity would show any replacement.
        let v = volume(cube(8), scalar_type, |i| if i.x > 3 { bad } else { 1.0 });
        let mut s = scene(v, constant(WHITE, 0.1));
        assert_eq!(s.statistics.nan + s.statistics.infinite, 256);
        s.camera.projection = Projection::Orthographic { height: 8.0 };
        let image = render(&device, &s);
        assert_eq!(image.pixel(24, 16).unwrap()[3], 0.0, "{bad}");
        assert_close(
            "finite half",
            f64::from(image.pixel(6, 16).unwrap()[3]),
            1.0 - 0.9f64.powi(8),
            1e-5,
        );
        assert_eq!(image.non_finite(), 0);
    }
}

#[test]
fn odd_volumes_images_and_functions_render() {
    let device = device();
    for dims in [
        UVec3::ONE,
        UVec3::new(1, 1, 50),
        UVec3::new(64, 1, 1),
        UVec3::new(1, 40, 2),
    ] {
        let v = volume(
            Grid::centred(dims, DVec3::new(1.0, 1.0, 30.0)),
            ScalarType::I8,
            |_| -128.0,
        );
        let mut s = shaded(scene(v, constant(WHITE, 0.5)));
        s.camera.projection = Projection::Orthographic { height: 0.5 };
        let image = render(&device, &s);
        assert!(image.non_finite() == 0 && centre(&image)[3] > 0.0, "{dims}");
    }
    let mut one = blob_scene(8);
    (one.image.width, one.image.height) = (1, 1);
    assert_eq!(render(&device, &one).pixels.len(), 1);
    let empty = scene(
        volume(cube(8), ScalarType::U8, |i| f64::from(i.x)),
        points(&[]),
    );
    assert!(
        render(&device, &empty)
            .pixels
            .iter()
            .all(|p| *p == [0.0; 4]),
        "an empty function shows nothing"
    );
    let nothing = volume(cube(4), ScalarType::F32, |_| f64::NAN);
    assert!(
        render(&device, &scene(nothing, constant(WHITE, 0.9)))
            .pixels
            .iter()
            .all(|p| *p == [0.0; 4])
    );
}

#[test]
fn a_spike_of_one_value_is_not_lost() {
    let device = device();
    // 16-bit data over the whole range, one value of it visible.
    let v = volume(cube(16), ScalarType::U16, |i| match (i.x, i.z) {
        (0, 0) => 0.0,
        (15, 15) => 65535.0,
        _ => 30_000.0,
    });
    let tf = points(&[
        (29_999.0, WHITE, 0.0),
        (30_000.0, WHITE, 0.3),
        (30_001.0, WHITE, 0.0),
    ]);
    assert!(centre(&render(&device, &scene(v, tf)))[3] > 0.5);
}

#[test]
fn sub_samples_average_over_the_pixel() {
    let device = device();
    let mut coarse = blob_scene(16);
    (
        coarse.image.width,
        coarse.image.height,
        coarse.image.samples_per_axis,
    ) = (8, 8, 4);
    let mut fine = coarse.clone();
    (
        fine.image.width,
        fine.image.height,
        fine.image.samples_per_axis,
    ) = (32, 32, 1);
    let (coarse, fine) = (render(&device, &coarse), render(&device, &fine));
    for y in 0..8 {
        for x in 0..8 {
            for channel in 0..4 {
                let sum: f32 = (0..16)
                    .map(|k| fine.pixel(4 * x + k % 4, 4 * y + k / 4).unwrap()[channel])
                    .sum();
                let found = coarse.pixel(x, y).unwrap()[channel];
                assert!((found - sum / 16.0).abs() < 1e-5, "({x}, {y})");
            }
        }
    }
}

#[test]
fn the_same_scene_gives_the_same_bits() {
    let device = device();
    let mut s = shaded(blob_scene(24));
    s.volume = std::sync::Arc::new(Procedural::Cloud.volume(24));
    let turn = DQuat::from_rotation_z(0.7);
    s.camera.eye = turn * s.camera.eye;
    assert_eq!(render(&device, &s).pixels, render(&device, &s).pixels);
}

#[test]
fn a_step_too_small_or_too_many_lights_are_refused_with_the_fix() {
    let device = device();
    let grid = Grid::centred(UVec3::new(1, 1, 4096), DVec3::ONE);
    let mut s = scene(volume(grid, ScalarType::U8, |_| 1.0), constant(WHITE, 0.1));
    s = with(s, |p| p.step = 1.0 / 64.0);
    let message = tyndall::technique::plan(&s, &device.info().limits)
        .unwrap_err()
        .to_string();
    assert!(
        message.contains("technique.ray_march.step") && message.contains("raise"),
        "{message}"
    );
    let mut s = blob_scene(8);
    s.lights = vec![s.lights[0].clone(); 40];
    let message = tyndall::technique::plan(&s, &device.info().limits)
        .unwrap_err()
        .to_string();
    assert!(
        message.contains("40") && message.contains("32"),
        "{message}"
    );
}

#[test]
fn samples_that_share_a_gradient_change_little() {
    let device = device();
    for step in [0.25, 1.0] {
        let step = |s: Scene| with(s, |p| p.step = step);
        let each = render(&device, &step(shaded(blob_scene(40))));
        let shared = render(&device, &step(merged(blob_scene(40))));
        // Opacity does not depend on shading, so only the light of a group of 1/64 and its last
        // sample can change, by as much as the cosines inside it differ.
        let alpha = |i: &Image| i.pixels.iter().map(|p| p[3].to_bits()).collect::<Vec<_>>();
        assert_eq!(alpha(&each), alpha(&shared));
        let largest = largest_difference(&each, &shared);
        assert!(0.0 < largest && largest < 0.02, "{largest}");
        let mean = |i: &Image| i.pixels.iter().map(|p| f64::from(p[1])).sum::<f64>();
        let bias = mean(&shared) / mean(&each) - 1.0;
        assert!(bias.abs() < 2e-3, "{bias}");
    }
}
