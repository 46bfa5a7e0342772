//! The medium through the device's filters and by loads: one image.
#![allow(clippy::unwrap_used)]

mod common;

use common::{device, points, render, scene, volume, with};
use glam::{DVec3, UVec3, Vec3};
use tyndall::gpu::Device;
use tyndall::scene::{Camera, Projection, Scene, Shading};
use tyndall::technique::Renderer;
use tyndall::volume::{Grid, ScalarType};

fn marches_by(device: &Device, s: &Scene) -> &'static str {
    Renderer::new(device, s.clone())
        .unwrap()
        .plan()
        .stages
        .iter()
        .map(|s| s.name)
        .find(|n| n.contains("march.march"))
        .unwrap()
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
    let tf = points(&[
        (0.0, Vec3::new(0.2, 0.4, 1.0), 0.0),
        (60.0, Vec3::ONE, 0.05),
        (200.0, Vec3::new(1.0, 0.5, 0.2), 0.5),
    ]);
    let dims = [UVec3::new(23, 17, 29), UVec3::new(1, 30, 2), UVec3::ONE];
    for scalar_type in [ScalarType::U8, ScalarType::I16, ScalarType::F32] {
        for dims in dims {
            let grid = Grid::centred(dims, DVec3::new(1.0, 1.4, 0.8));
            let wave = |i: UVec3| {
                (110.0 + 90.0 * (0.5 * f64::from(i.x)).sin() * (0.4 * f64::from(i.y + i.z)).cos())
                    .round()
            };
            let mut s = scene(volume(grid, scalar_type, wave), tf.clone());
            s.camera = Camera {
                eye: DVec3::new(30.0, -50.0, 25.0),
                projection: Projection::Perspective { vfov_deg: 30.0 },
                ..s.camera
            };
            for shading in [None, Some(Shading::default())] {
                let s = with(s.clone(), |p| p.shading = shading);
                assert_eq!(marches_by(&filtering, &s), "ray_march.march");
                assert!(marches_by(&loading, &s).starts_with("ray_march.march_r"));
                let (a, b) = (render(&loading, &s), render(&filtering, &s));
                let channels = a.pixels.iter().flatten().zip(b.pixels.iter().flatten());
                let largest = channels.map(|(x, y)| (x - y).abs()).fold(0.0, f32::max);
                // The two round positions and weights differently, 2e-5 in the volume and as much in
                // the table; a normal turns by as much as the gradient's rounding over its length.
                let limit = if shading.is_some() { 2e-3 } else { 4e-5 };
                assert!(
                    largest < limit,
                    "{scalar_type} {dims} shaded {}: {largest}",
                    shading.is_some()
                );
            }
        }
    }
}
