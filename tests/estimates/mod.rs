//! What tests of `path_trace` share: estimates with their standard errors, and a scene.
#![allow(dead_code, unreachable_pub, reason = "each test binary uses a part")]

use glam::{DVec3, UVec3, Vec3};
use tyndall::gpu::Device;
use tyndall::output::Image;
use tyndall::scene::{PathTraceParams, Scene, TechniqueParams};
use tyndall::technique::Renderer;
use tyndall::technique::path_trace::reference;
use tyndall::volume::{Grid, ScalarType};

use crate::common::{points, scene, volume};

/// Chance of a deviation beyond it is 6e-7: no test fails by chance, and every seed is fixed.
pub const Z: f64 = 5.0;

pub fn traced(mut scene: Scene, samples: u32, max_scatter: Option<u32>) -> Scene {
    scene.technique = TechniqueParams::PathTrace(PathTraceParams {
        samples,
        max_scatter,
        seed: 7,
        ..PathTraceParams::default()
    });
    scene
}

/// Image, and the squared standard error of each pixel.
pub fn estimate(device: &Device, scene: &Scene) -> (Image, Vec<[f32; 3]>) {
    let mut renderer = Renderer::new(device, scene.clone()).unwrap();
    let (image, _) = renderer.render(&mut |_, _, _| {}).unwrap();
    let variance = renderer.variance().unwrap().unwrap();
    drop(renderer);
    device.check_validation().unwrap();
    assert_eq!(device.live_allocations(), vec![], "memory left behind");
    assert_eq!(image.non_finite(), 0);
    (image, variance)
}

/// Mean over the image of one channel, and its standard error.
pub fn mean(image: &Image, variance: &[[f32; 3]], channel: usize) -> (f64, f64) {
    let n = image.pixels.len() as f64;
    let sum: f64 = image.pixels.iter().map(|p| f64::from(p[channel])).sum();
    let squares: f64 = variance.iter().map(|v| f64::from(v[channel])).sum();
    (sum / n, squares.sqrt() / n)
}

pub fn assert_mean(what: &str, (found, error): (f64, f64), expected: f64) {
    let z = (found - expected) / error;
    assert!(
        z.abs() < Z && error < 0.02 * expected,
        "{what}: found {found} with standard error {error}, expected {expected}: z = {z}"
    );
}

/// A dense blob in an empty surrounding, anisotropic voxels, colours by value.
pub fn blob() -> Scene {
    let grid = Grid::centred(UVec3::new(20, 24, 16), DVec3::new(1.2, 1.0, 1.5));
    let v = volume(grid, ScalarType::U16, |i| {
        let p = (i.as_dvec3() + 0.5) / DVec3::new(20.0, 24.0, 16.0) - 0.5;
        (1000.0 * (-p.length_squared() * 20.0).exp()).round()
    });
    let mut s = scene(
        v,
        points(&[
            (0.0, Vec3::new(0.2, 0.9, 0.4), 0.0),
            (150.0, Vec3::new(0.2, 0.9, 0.4), 0.0),
            (500.0, Vec3::new(0.9, 0.6, 0.3), 0.3),
            (1000.0, Vec3::ONE, 0.6),
        ]),
    );
    s.image.width = 12;
    s.image.height = 12;
    s.medium.albedo = 0.95;
    s.medium.phase_g = 0.5;
    s
}

/// Fails where pixel means or the image's mean differ by more than chance explains.
pub fn assert_estimators_agree(what: &str, device: &Device, scene: &Scene) {
    let TechniqueParams::PathTrace(params) = scene.technique else {
        unreachable!()
    };
    let (image, variance) = estimate(device, scene);
    let more = PathTraceParams {
        samples: 4 * params.samples,
        ..params
    };
    let textbook = reference::render(scene, &more);
    for channel in 0..3 {
        let n = textbook.len() as f64;
        let expected = textbook.iter().map(|e| e.mean[channel]).sum::<f64>() / n;
        let squares: f64 = textbook.iter().map(|e| e.variance[channel]).sum();
        let (found, error) = mean(&image, &variance, channel);
        let error = (error * error + squares / n / n).sqrt();
        let z = (found - expected) / error;
        assert!(
            z.abs() < Z && error < 0.02 * expected,
            "{what}, channel {channel}: {found}, textbook {expected} +- {error}: z = {z}"
        );
    }
    let alpha = |i: usize| f64::from(image.pixels[i][3]) - textbook[i].alpha;
    let bias = (0..textbook.len()).map(alpha).sum::<f64>() / textbook.len() as f64;
    assert!(bias.abs() < 0.01, "{what}: alpha differs by {bias}");
}
