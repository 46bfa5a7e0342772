//! Environment maps and albedo volumes in `path_trace`: against closed forms, against the textbook
//! estimator, and the orientation of both.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;
mod estimates;

use std::f64::consts::PI;
use std::sync::Arc;

use common::{constant, cube, device, scene, volume};
use estimates::{Z, assert_estimators_agree, assert_mean, blob, estimate, mean, traced};
use glam::{DVec3, UVec3, Vec3};
use tyndall::scene::{LatLongMap, Light, Projection, Scene};
use tyndall::technique::RenderError;
use tyndall::technique::Renderer;
use tyndall::volume::{ColorVolume, ScalarType};

fn map(width: u32, height: u32, radiance: impl Fn(u32, u32) -> [f32; 3]) -> Arc<LatLongMap> {
    Arc::new(LatLongMap {
        name: "map".to_owned(),
        width,
        height,
        texels: (0..width * height)
            .map(|i| radiance(i % width, i / width))
            .collect(),
    })
}

fn around(map: &Arc<LatLongMap>) -> Light {
    Light::EnvironmentMap {
        map: map.clone(),
        scale: Vec3::ONE,
        up: DVec3::Z,
        rotation_deg: 0.0,
    }
}

/// Faint everywhere, with a sun a hundred times as bright: no smaller, for the textbook estimator must
/// meet it by chance.
fn sky() -> Arc<LatLongMap> {
    map(64, 32, |x, y| {
        let faint = 0.1 + 0.02 * y as f32;
        let sun = if (40..48).contains(&x) && (6..10).contains(&y) {
            20.0
        } else {
            0.0
        };
        [
            faint + sun,
            0.5 * faint + 0.9 * sun,
            2.0 * faint + 0.5 * sun,
        ]
    })
}

#[test]
fn a_white_furnace_under_an_even_map_is_white() {
    let device = device();
    let mut s = blob();
    s.medium.albedo = 1.0;
    for p in &mut s.medium.transfer_function.points {
        p.color = Vec3::ONE;
    }
    s.image.background = Vec3::ONE;
    s.lights = vec![around(&map(8, 4, |_, _| [1.0; 3]))];
    let (image, variance) = estimate(&device, &traced(s, 256, None));
    for channel in 0..3 {
        let found = mean(&image, &variance, channel);
        assert_mean(&format!("channel {channel}"), found, 1.0);
        assert!(found.1 < 2e-3, "standard error {}", found.1);
    }
}

#[test]
fn both_estimators_agree_under_a_sky_with_a_sun() {
    let device = device();
    let mut s = blob();
    s.lights = vec![Light::EnvironmentMap {
        map: sky(),
        scale: Vec3::new(1.0, 2.0, 0.5),
        up: DVec3::new(0.2, -0.3, 1.0).normalize(),
        rotation_deg: 70.0,
    }];
    assert_estimators_agree("sky", &device, &traced(s, 4096, None));
}

#[test]
fn both_estimators_agree_under_a_sky_beside_other_lights() {
    let device = device();
    let mut s = blob();
    s.medium.phase_g = -0.4;
    s.lights = vec![
        Light::Environment {
            radiance: Vec3::splat(0.2),
        },
        around(&sky()),
        Light::Directional {
            direction: DVec3::new(1.0, 0.5, -1.0),
            irradiance: Vec3::new(3.0, 2.0, 1.0),
        },
    ];
    assert_estimators_agree("sky and others", &device, &traced(s, 2048, Some(3)));
}

/// A thin even cube that fills an orthographic image looking along +y, up +z.
fn thin() -> Scene {
    let opacity = -(-1e-4_f64).exp_m1();
    let v = volume(cube(8), ScalarType::U8, |_| 1.0);
    let mut s = scene(v, constant(Vec3::ONE, opacity));
    s.camera.projection = Projection::Orthographic { height: 6.0 };
    s.image.width = 8;
    s.image.height = 8;
    s.medium.phase_g = 0.9;
    s
}

/// Light that a thin forward medium sends on to the camera from a map that is bright on one column.
fn from_behind(column: u32, rotation_deg: f64) -> f64 {
    let device = device();
    let mut s = thin();
    let bright = map(4, 4, |x, y| {
        if x == column && (1..3).contains(&y) {
            [1.0; 3]
        } else {
            [0.0; 3]
        }
    });
    s.lights = vec![Light::EnvironmentMap {
        map: bright,
        scale: Vec3::ONE,
        up: DVec3::Z,
        rotation_deg,
    }];
    let (image, variance) = estimate(&device, &traced(s, 256, Some(1)));
    mean(&image, &variance, 0).0
}

#[test]
fn the_middle_of_a_map_is_behind_a_camera_that_looks_along_y() {
    // Columns are interpolated: 1 and 2 are about the middle, 3 and 0 about the seam.
    let [seam, middle] = [from_behind(0, 0.0), from_behind(2, 0.0)];
    assert!(seam > 5.0 * middle, "seam {seam}, middle {middle}");
    // Half a turn brings the middle opposite the camera.
    let turned = from_behind(2, 180.0);
    assert!(
        (turned / seam - 1.0).abs() < 0.05,
        "turned {turned}, seam {seam}"
    );
}

#[test]
fn a_map_turns_counterclockwise_about_up() {
    // Seen from above, +x turns to +y, which is opposite the camera: u = 1/4 is at +x.
    let right = map(64, 32, |x, _| {
        if (12..20).contains(&x) {
            [1.0; 3]
        } else {
            [0.0; 3]
        }
    });
    let found = |rotation_deg| {
        let mut s = thin();
        s.lights = vec![Light::EnvironmentMap {
            map: right.clone(),
            scale: Vec3::ONE,
            up: DVec3::Z,
            rotation_deg,
        }];
        let (image, variance) = estimate(&device(), &traced(s, 256, Some(1)));
        mean(&image, &variance, 0).0
    };
    let [still, ahead, back] = [found(0.0), found(90.0), found(-90.0)];
    assert!(
        ahead > 5.0 * still && still > 2.0 * back,
        "{still} {ahead} {back}"
    );
}

#[test]
fn a_small_sun_is_a_directional_light() {
    // A texel of solid angle w and radiance 1 / w has irradiance 1.
    let device = device();
    let (width, height) = (256, 128);
    let angle = |y: f64| (PI * y / f64::from(height)).cos();
    let solid = 2.0 * PI / f64::from(width) * (angle(63.0) - angle(64.0));
    // Interpolation spreads it over four texels' area with the same integral, nearly.
    let sun = map(width, height, |x, y| {
        if (x, y) == (64, 63) {
            [(1.0 / solid) as f32; 3]
        } else {
            [0.0; 3]
        }
    });
    let mut s = thin();
    s.medium.phase_g = 0.0;
    s.lights = vec![around(&sun)];
    let by_map = estimate(&device, &traced(s.clone(), 1024, Some(1)));
    s.lights = vec![Light::Directional {
        direction: -DVec3::X,
        irradiance: Vec3::ONE,
    }];
    let by_light = estimate(&device, &traced(s, 1024, Some(1)));
    let (a, b) = (
        mean(&by_map.0, &by_map.1, 0),
        mean(&by_light.0, &by_light.1, 0),
    );
    // 1e-3: the sine varies across the texel.
    let error = Z * a.1.hypot(b.1) + 1e-3 * b.0;
    assert!((a.0 - b.0).abs() < error, "{a:?} {b:?}");
}

#[test]
fn a_second_map_is_refused() {
    let mut s = traced(blob(), 1, None);
    s.lights = vec![around(&sky()), around(&sky())];
    let Err(RenderError::Plan(error)) = Renderer::new(&device(), s) else {
        panic!("accepted");
    };
    let text = error.to_string();
    assert!(text.contains("2 environment maps"), "{text}");
}

#[test]
fn a_new_map_takes_the_place_of_the_old_one() {
    let device = device();
    let scene = |level: f32| {
        let mut s = traced(blob(), 64, None);
        s.lights = vec![around(&map(8, 4, |_, _| [level; 3]))];
        s
    };
    let mut renderer = Renderer::new(&device, scene(1.0)).unwrap();
    let (first, _) = renderer.render(&mut |_, _, _| {}).unwrap();
    renderer.set_scene(scene(2.0)).unwrap();
    let (second, report) = renderer.render(&mut |_, _, _| {}).unwrap();
    let stages: Vec<_> = report.stages.iter().map(|s| s.name.as_str()).collect();
    assert!(
        stages.contains(&"path_trace.upload_environment"),
        "{stages:?}"
    );
    for (a, b) in first.pixels.iter().zip(&second.pixels) {
        assert!((2.0 * a[0] - b[0]).abs() <= 1e-5 * b[0], "{a:?} {b:?}");
    }
}

/// Red at low x, blue at high z, green in between.
fn colors(dims: UVec3) -> ColorVolume {
    let color = |i: u32| {
        let (x, z) = (i % dims.x, i / (dims.x * dims.y));
        let (x, z) = (x as f32 / dims.x as f32, z as f32 / dims.z as f32);
        [1.0 - x, 0.5, z]
    };
    let colors: Vec<_> = (0..dims.element_product()).map(color).collect();
    ColorVolume::new("colors", dims, &colors)
}

#[test]
fn both_estimators_agree_on_an_albedo_volume() {
    let device = device();
    let mut s = blob();
    s.medium.albedo_volume = Some(Arc::new(colors(s.volume.grid.dims)));
    s.medium.emission = 0.1;
    s.lights = vec![Light::Directional {
        direction: DVec3::new(1.0, 0.5, -1.0),
        irradiance: Vec3::splat(3.0),
    }];
    assert_estimators_agree("albedo volume", &device, &traced(s, 512, None));
}

#[test]
fn an_albedo_volume_lies_where_the_volume_does() {
    let device = device();
    let mut s = thin();
    s.medium.phase_g = 0.0;
    s.medium.albedo_volume = Some(Arc::new(colors(UVec3::splat(8))));
    s.lights = vec![Light::Environment {
        radiance: Vec3::ONE,
    }];
    let (image, _) = estimate(&device, &traced(s, 4096, Some(1)));
    // The image's right is +x, its top +z. Of a thin medium L = albedo * tau.
    let [left, right] = [0, 7].map(|x| image.pixel(x, 4).unwrap());
    let [top, bottom] = [0, 7].map(|y| image.pixel(4, y).unwrap());
    assert!(left[0] > 3.0 * right[0], "{left:?} {right:?}");
    assert!(top[2] > 3.0 * bottom[2], "{top:?} {bottom:?}");
    // 8e-4: attenuation.
    assert!(
        (f64::from(left[1]) / (0.5 * 8e-4) - 1.0).abs() < 1e-3,
        "{left:?}"
    );
}
