//! What `ambient_scattering` computes on the host: tubes, radii and albedos.
#![allow(clippy::unwrap_used)]

mod common;

use common::{constant, cube, points, scene, volume};
use glam::{DVec3, Vec3};
use tyndall::scene::{AmbientScatteringParams, Radius, TechniqueParams};
use tyndall::technique::ambient_scattering::slab::Slab;
use tyndall::technique::ambient_scattering::{albedo, radius};
use tyndall::volume::ScalarType;

fn passed(slab: &Slab, depth: f64) -> f64 {
    (-depth * slab.dimming(depth)).exp()
}

#[test]
fn a_tube_passes_all_in_vacuum_and_never_less_than_beer_lambert_and_falls_with_depth() {
    for g in [-0.99, -0.9, -0.5, 0.0, 0.3, 0.8, 0.9, 0.99] {
        for albedo in [0.0, 0.3, 0.9, 1.0] {
            let slab = Slab::new(albedo, g);
            assert_eq!(passed(&slab, 0.0), 1.0, "vacuum, g {g}, albedo {albedo}");
            let mut before = 1.0;
            for i in 0..400 {
                let depth = 1e-4 * (1.04_f64).powi(i);
                let found = passed(&slab, depth);
                let what = format!("g {g}, albedo {albedo}, depth {depth}: {found} after {before}");
                assert!(found <= before && found > 0.0 || depth > 600.0, "{what}");
                // Rounding of a logarithm and its exponential.
                assert!(found >= (-depth).exp() * (1.0 - 1e-9), "{what}");
                before = found;
            }
        }
    }
}

#[test]
fn a_tube_without_scattering_is_beer_lambert() {
    for g in [-0.9, 0.0, 0.9] {
        let slab = Slab::new(0.0, g);
        for depth in [1e-5, 0.1, 1.0, 7.3, 50.0, 900.0] {
            // 1e-9: cancellation in the thinnest layer.
            assert!((slab.dimming(depth) - 1.0).abs() < 1e-9, "{g}, {depth}");
        }
    }
}

/// Analog estimate of the share of a front's power that passes a slab, and its standard error.
fn traced(depth: f64, albedo: f64, g: f64, paths: u32) -> (f64, f64) {
    use rand::{RngExt, SeedableRng};
    let mut random = rand_pcg::Pcg64Mcg::seed_from_u64(7);
    let mut count = 0.0;
    for _ in 0..paths {
        let (mut z, mut mu) = (0.0, 1.0_f64);
        loop {
            z -= (1.0 - random.random::<f64>()).ln() * mu;
            if z >= depth {
                count += 1.0;
                break;
            }
            if z < 0.0 || random.random::<f64>() > albedo {
                break;
            }
            let u: f64 = random.random();
            let cos: f64 = if g == 0.0 {
                1.0 - 2.0 * u
            } else {
                let s = (1.0 - g * g) / (1.0 - g + 2.0 * g * u);
                (1.0 + g * g - s * s) / (2.0 * g)
            };
            let phi = std::f64::consts::TAU * random.random::<f64>();
            let sin2 = (1.0 - mu * mu).max(0.0) * (1.0 - cos * cos).max(0.0);
            mu = (mu * cos + sin2.sqrt() * phi.cos()).clamp(-1.0, 1.0);
        }
    }
    let n = f64::from(paths);
    let mean = count / n;
    (mean, (mean * (1.0 - mean) / n).sqrt())
}

#[test]
fn slabs_agree_with_paths_of_light() {
    for (depth, albedo, g) in [
        (0.3, 0.9, 0.0),
        (2.0, 0.9, 0.0),
        (2.0, 0.9, -0.8),
        (3.0, 0.9, 0.8),
        (6.0, 1.0, 0.3),
        (1.0, 0.5, 0.9),
    ] {
        let (mean, error) = traced(depth, albedo, g, 40_000);
        let found = passed(&Slab::new(albedo, g), depth);
        // Four standard errors, and half a per cent for twelve directions and what is between the nodes.
        let limit = 4.0 * error + 5e-3 * mean;
        assert!(
            (found - mean).abs() < limit,
            "depth {depth}, albedo {albedo}, g {g}: {found}, by paths {mean} +- {error}"
        );
    }
}

#[test]
fn an_automatic_radius_is_a_mean_free_path_within_a_voxel_and_a_sixteenth() {
    let of = |opacity: f64, n: u32| {
        let s = scene(
            volume(cube(n), ScalarType::U8, |_| 1.0),
            constant(Vec3::ONE, opacity),
        );
        radius(&s, Radius::Auto)
    };
    // Extinction -ln(1 - opacity) a voxel.
    assert!(
        (of(0.3, 64) + 1.0 / (0.7_f64).ln()).abs() < 1e-9,
        "free path"
    );
    assert_eq!(of(0.999, 64), 1.0, "a voxel");
    assert_eq!(of(1e-6, 64), 4.0, "a sixteenth");
    assert_eq!(of(0.999, 2), 0.125, "coarse voxels do not matter");
    let s = scene(
        volume(cube(64), ScalarType::U8, |_| 1.0),
        constant(Vec3::ONE, 0.5),
    );
    assert_eq!(radius(&s, Radius::Voxels(7.0)), 7.0);
    assert_eq!(radius(&s, Radius::World(2.5)), 2.5);
    assert_eq!(radius(&s, Radius::Voxels(1000.0)), 32.0, "half the volume");
}

#[test]
fn the_tables_albedo_is_the_mean_weighted_by_extinction() {
    let red = Vec3::new(1.0, 0.0, 0.0);
    let mut s = scene(
        volume(cube(8), ScalarType::U8, |i| f64::from(255 * (i.x % 2))),
        points(&[(0.0, Vec3::ONE, 0.0), (254.0, red, 0.5), (255.0, red, 0.5)]),
    );
    s.medium.albedo = 0.8;
    s.technique = TechniqueParams::AmbientScattering(AmbientScatteringParams::default());
    let found = albedo(&s);
    // The histogram's bins stand for the values in them.
    assert!(
        (found - DVec3::new(0.8, 0.0, 0.0)).length() < 1e-3,
        "{found}"
    );
}
