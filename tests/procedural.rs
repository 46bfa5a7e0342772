//! The procedural volumes: what the formulas promise, and that volumes hold them.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::f64::consts::PI;

use glam::{DVec3, UVec3};
use tyndall::volume::procedural::Procedural;
use tyndall::volume::{ScalarType, Statistics, Volume, Voxels};

/// Half a step of the 16 bit quantisation.
const HALF_STEP: f64 = 0.5 / 65535.0;

fn voxel_centre(i: UVec3, n: u32) -> DVec3 {
    2.0 * (i.as_dvec3() + 0.5) / f64::from(n) - 1.0
}

fn indices(n: u32) -> impl Iterator<Item = UVec3> {
    (0..n * n * n).map(move |i| UVec3::new(i % n, i / n % n, i / n / n))
}

fn mean(volume: &Volume) -> f64 {
    Statistics::of(volume).mean
}

fn assert_near(found: f64, expected: f64, tolerance: f64, what: &str) {
    assert!(
        (found - expected).abs() <= tolerance,
        "{what}: {found}, expected {expected} +- {tolerance}"
    );
}

#[test]
fn volumes_hold_the_formula_at_voxel_centres() {
    // Not a power of two: centres are not exact in binary.
    let n = 27;
    for kind in Procedural::ALL {
        let volume = kind.volume(n);
        assert_eq!(volume.name, kind.name());
        for i in indices(n) {
            let index = volume.grid.linear_index(i);
            let world = volume.grid.world_from_index.transform_point3(i.as_dvec3());
            let p = voxel_centre(i, n);
            assert!(world.distance(p) < 1e-14, "{i}: {world} is not {p}");
            let expected = kind.evaluate(p);
            assert!((0.0..=1.0).contains(&expected), "{kind:?} {p}: {expected}");
            let found = volume.value(index);
            assert!((0.0..=1.0).contains(&found), "{kind:?} {p}: {found}");
            assert_near(found, expected, HALF_STEP * 1.001, kind.name());
        }
    }
}

#[test]
fn a_formula_is_stretched_over_a_grid_of_cubes() {
    let dims = UVec3::new(9, 5, 14);
    for kind in Procedural::ALL {
        let volume = kind.volume_of(dims);
        assert_eq!(volume.grid.dims, dims);
        assert_eq!(volume.grid.spacing(), DVec3::splat(2.0 / 14.0));
        let (lo, hi) = volume.grid.world_bounds();
        assert!((lo + hi).length() < 1e-14, "the box is centred: {lo} {hi}");
        for i in [UVec3::ZERO, UVec3::new(4, 2, 7), dims - 1] {
            let p = 2.0 * (i.as_dvec3() + 0.5) / dims.as_dvec3() - 1.0;
            let found = volume.value(volume.grid.linear_index(i));
            assert_near(found, kind.evaluate(p), HALF_STEP * 1.001, kind.name());
        }
        assert_eq!(kind.volume(7), kind.volume_of(UVec3::splat(7)));
    }
}

#[test]
fn precision_is_kept_where_it_is_the_point() {
    for kind in Procedural::ALL {
        let expected = match kind {
            Procedural::MarschnerLobb => ScalarType::F32,
            _ => ScalarType::U16,
        };
        assert_eq!(kind.volume(2).voxels.scalar_type(), expected);
    }
}

#[test]
fn every_resolution_fills_the_box() {
    for kind in Procedural::ALL {
        for n in [1, 2, 3, 17] {
            let volume = kind.volume(n);
            assert_eq!(volume.grid.dims, UVec3::splat(n));
            assert_eq!(volume.voxels.len(), (n * n * n) as usize);
            let (low, high) = volume.grid.world_bounds();
            assert!(low.distance(DVec3::NEG_ONE) < 1e-14, "{n}: {low}");
            assert!(high.distance(DVec3::ONE) < 1e-14, "{n}: {high}");
        }
        let single = kind.volume(1).value(0);
        assert_near(single, kind.evaluate(DVec3::ZERO), HALF_STEP, kind.name());
        assert_eq!(kind.volume(0), kind.volume(1));
    }
}

/// FNV-1a over the stored bits.
fn checksum(volume: &Volume) -> u64 {
    let hash = |h: u64, bits: u32| (h ^ u64::from(bits)).wrapping_mul(0x100_0000_01b3);
    match &volume.voxels {
        Voxels::U16(v) => v.iter().fold(0xcbf2, |h, &x| hash(h, x.into())),
        Voxels::F32(v) => v.iter().fold(0xcbf2, |h, &x| hash(h, x.to_bits())),
        other => unreachable!("{} is not used", other.scalar_type()),
    }
}

#[test]
fn the_same_bits_on_every_run_and_for_any_number_of_threads() {
    let pool = |threads| {
        rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap()
    };
    for kind in Procedural::ALL {
        let first = checksum(&kind.volume(24));
        assert_eq!(first, checksum(&kind.volume(24)), "{kind:?}");
        for threads in [1, 3] {
            let again = pool(threads).install(|| checksum(&kind.volume(24)));
            assert_eq!(first, again, "{kind:?}, {threads} threads");
        }
    }
}

#[test]
fn volumes_differ() {
    let sums: Vec<u64> = Procedural::ALL.map(|k| checksum(&k.volume(16))).to_vec();
    let mut unique = sums.clone();
    unique.sort_unstable();
    unique.dedup();
    assert_eq!(unique.len(), sums.len());
}

/// Mean difference between coarse voxels and averages of eight fine ones, `shift` fine voxels off.
fn coarse_from_fine(coarse: &Volume, fine: &Volume, shift: u32) -> f64 {
    let n = coarse.grid.dims.x;
    let last = 2 * n - 1;
    let sum: f64 = indices(n)
        .map(|i| {
            let eight: f64 = indices(2)
                .map(|o| (2 * i + o + shift).min(UVec3::splat(last)))
                .map(|j| fine.value(fine.grid.linear_index(j)))
                .sum();
            (eight / 8.0 - coarse.value(coarse.grid.linear_index(i))).abs()
        })
        .sum();
    sum / f64::from(n).powi(3)
}

/// Eight fine voxels average to the coarse one up to the curvature within a voxel (a coarse one is
/// as wide as the thinnest filaments, hence not exactly), at least twice as well as grids half a
/// coarse voxel apart do. Means are integrals by the midpoint rule, which errs much less.
#[test]
fn resolutions_agree() {
    for kind in [
        Procedural::Supernova,
        Procedural::Cloud,
        Procedural::MechanicalPart,
        Procedural::Cumulus,
    ] {
        let (coarse, fine) = (kind.volume(48), kind.volume(96));
        let difference = coarse_from_fine(&coarse, &fine, 0);
        let apart = coarse_from_fine(&coarse, &fine, 1);
        assert!(
            difference < 0.5 * apart && difference < 0.01,
            "{kind:?}: {difference}, {apart} if half a voxel apart"
        );
        assert_near(mean(&coarse), mean(&fine), 0.01 * mean(&fine), kind.name());
    }
}

#[test]
fn objects_do_not_touch_the_box() {
    for kind in Procedural::ALL {
        if kind == Procedural::MarschnerLobb {
            continue;
        }
        for i in indices(41) {
            let p = i.as_dvec3() / 20.0 - 1.0;
            if p.abs().max_element() == 1.0 {
                assert_eq!(kind.evaluate(p), 0.0, "{kind:?} {p}");
            }
        }
    }
}

#[test]
fn marschner_lobb_at_points_derived_by_hand() {
    let f = |x: f64, y: f64, z: f64| Procedural::MarschnerLobb.evaluate(DVec3::new(x, y, z));
    // r = 0: rho_r = cos(12 pi) = 1, so the signal is (1.5 - sin(pi z / 2)) / 2.5.
    assert_near(f(0.0, 0.0, 0.0), 0.6, 1e-12, "origin");
    assert_near(f(0.0, 0.0, 1.0), 0.2, 1e-12, "top");
    assert_near(f(0.0, 0.0, -1.0), 1.0, 1e-12, "bottom");
    assert_near(f(0.0, 0.0, 1.0 / 3.0), 0.4, 1e-12, "sin(pi / 6) = 1/2");
    // r = 1: cos(pi / 2) = 0, so rho_r = 1 again.
    assert_near(f(0.6, 0.8, 0.0), 0.6, 1e-12, "r = 1");
    // 12 pi cos(pi r / 2) = 11 pi: a trough, rho_r = -1.
    let r = (11.0_f64 / 12.0).acos() * 2.0 / PI;
    assert_near(f(r, 0.0, 0.0), 0.4, 1e-12, "first trough");
    assert_near(
        f(0.0, -r, 1.0),
        0.0,
        1e-12,
        "trough at the top: the smallest value",
    );
}

#[test]
fn shepp_logan_tissues() {
    let at = |x, y, z, expected: f64| {
        let found = Procedural::SheppLogan.evaluate(DVec3::new(x, y, z));
        assert_eq!(found, expected, "({x}, {y}, {z})");
    };
    at(0.95, 0.95, 0.95, 0.0);
    at(0.0, 0.9, 0.0, 1.0);
    at(0.675, 0.0, 0.0, 1.0);
    at(0.0, 0.0, -0.89, 1.0);
    at(0.0, 0.0, 0.0, 0.2);
    at(-0.22, 0.0, -0.25, 0.0);
    at(0.22, 0.0, -0.25, 0.0);
    at(0.0, 0.35, -0.25, 0.4);
    at(0.0, 0.09, -0.25, 0.4);
    at(-0.08, -0.65, -0.25, 0.3);
    at(0.06, -0.65, -0.25, 0.3);
    at(0.06, -0.105, 0.625, 0.4);
    at(0.0, 0.1, 0.625, 0.0);
    // The ventricles' long axes lean: the tops towards each other is the mirror image.
    at(-0.22 - 0.108, 0.333, -0.25, 0.0);
    at(-0.22 + 0.108, 0.333, -0.25, 0.4);
    at(0.22 + 0.08, 0.246, -0.25, 0.0);
}

/// All ellipsoids add up, so the integral is the sum of `4/3 pi a b c` times value.
#[test]
fn shepp_logan_integral() {
    let value_times_axes = [
        (1.0, 0.69 * 0.92 * 0.9),
        (-0.8, 0.6624 * 0.874 * 0.88),
        (-0.2, 0.41 * 0.16 * 0.21),
        (-0.2, 0.31 * 0.11 * 0.22),
        (0.2, 0.21 * 0.25 * 0.5),
        (0.2, 0.046 * 0.046 * 0.046),
        (0.1, 0.046 * 0.023 * 0.02),
        (0.1, 0.046 * 0.023 * 0.02),
        (0.2, 0.056 * 0.04 * 0.1),
        (-0.2, 0.056 * 0.056 * 0.1),
    ];
    let integral: f64 = value_times_axes.iter().map(|(v, abc)| v * abc).sum();
    let expected = integral * PI * 4.0 / 3.0 / 8.0;
    // Sharp edges: each voxel the surface cuts is all or nothing, at random.
    assert_near(
        mean(&Procedural::SheppLogan.volume(96)),
        expected,
        0.01 * expected,
        "mean",
    );
}

#[test]
fn supernova_bands() {
    let f = |p| Procedural::Supernova.evaluate(p);
    assert_eq!(f(DVec3::ZERO), 1.0);
    let (mut blast, mut shell, mut dense) = (0.0_f64, 0.0_f64, 0);
    for i in indices(64) {
        let p = voxel_centre(i, 64);
        let (r, value) = (p.length(), f(p));
        if r > 0.97 {
            assert_eq!(value, 0.0, "{p}");
        } else if r > 0.88 {
            blast = blast.max(value);
        } else if r > 0.4 {
            shell = shell.max(value);
            dense += u32::from(value > 0.35);
        }
    }
    assert!((0.05..=0.13).contains(&blast), "{blast}");
    assert!((0.7..=0.9).contains(&shell), "{shell}");
    // Filaments, not a ball: they fill a few percent of the shell's 64^3 * 0.3 voxels.
    assert!((1500..12000).contains(&dense), "{dense}");
}

#[test]
fn cloud_has_a_flat_base_and_a_dense_core() {
    let f = |p| Procedural::Cloud.evaluate(p);
    for i in indices(48) {
        let p = voxel_centre(i, 48);
        assert!(p.z >= -0.5 || f(p) == 0.0, "{p}");
    }
    assert!(f(DVec3::new(0.1, 0.04, 0.0)) > 0.5);
    let above_base = indices(48)
        .map(|i| voxel_centre(i, 48))
        .filter(|p| (-0.43..-0.38).contains(&p.z) && f(*p) > 0.3)
        .count();
    assert!(above_base > 150, "{above_base}");
}

#[test]
fn mechanical_part_materials() {
    let at = |x, y, z, expected: f64| {
        let found = Procedural::MechanicalPart.evaluate(DVec3::new(x, y, z));
        assert_near(found, expected, 1e-12, &format!("({x}, {y}, {z})"));
    };
    at(0.0, 0.0, 0.0, 0.0); // bore
    at(-0.345, 0.0, 0.0, 0.45); // hub
    at(0.78, 0.0, -0.55, 0.45); // flange
    at(-0.21, 0.0, 0.0, 0.85); // bushing
    at(0.20, 0.0, 0.0, 0.0); // its keyway
    at(0.0, -0.66, -0.5, 0.0); // empty bolt hole
    at(0.0, 0.66, -0.5, 0.85); // screw
    at(0.0, 0.66, -0.33, 0.0); // its socket
    at(0.0, 0.40, 0.16, 0.0); // oil port
    at(-0.60, 0.0, -0.30, 0.45); // rib
    at(0.72, 0.05, -0.385, 0.0); // the arrow's head
    at(0.72, -0.05, -0.385, 0.45); // the flange beside its shaft
}

#[test]
fn no_mirror_image_or_turn_of_the_mechanical_part_is_the_same() {
    let f = |p| Procedural::MechanicalPart.evaluate(p);
    let turned = |p: DVec3, degrees: f64| {
        let (sin, cos) = degrees.to_radians().sin_cos();
        DVec3::new(cos * p.x - sin * p.y, sin * p.x + cos * p.y, p.z)
    };
    let images: [(&str, &dyn Fn(DVec3) -> DVec3); 7] = [
        ("-x", &|p| p * DVec3::new(-1.0, 1.0, 1.0)),
        ("-y", &|p| p * DVec3::new(1.0, -1.0, 1.0)),
        ("-z", &|p| p * DVec3::new(1.0, 1.0, -1.0)),
        ("xy", &|p| DVec3::new(p.y, p.x, p.z)),
        ("60", &|p| turned(p, 60.0)),
        ("120", &|p| turned(p, 120.0)),
        ("180", &|p| turned(p, 180.0)),
    ];
    for (name, image) in images {
        let changed = indices(48)
            .map(|i| voxel_centre(i, 48))
            .filter(|&p| (f(p) - f(image(p))).abs() > 0.2)
            .count();
        assert!(changed > 50, "{name}: {changed} voxels differ");
    }
}
