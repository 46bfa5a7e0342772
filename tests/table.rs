//! The preintegration table on the CPU: what is shipped, its files, its limits.
#![allow(clippy::unwrap_used, clippy::panic)]

use std::f64::consts::PI;
use std::fs;
use std::path::Path;

use tyndall::technique::ambient_scattering::table::check::{agrees, compare, read};
use tyndall::technique::ambient_scattering::table::{
    Axis, Grid, Shipped, Table, format, reference, shipped,
};
use tyndall::technique::phase_hg;

fn tables() -> &'static Shipped {
    shipped().unwrap()
}

fn close(what: &str, found: f64, expected: f64, relative: f64) {
    assert!(
        (found / expected - 1.0).abs() < relative,
        "{what}: found {found:e}, expected {expected:e} within {relative}"
    );
}

#[test]
fn vacuum_lets_the_front_through() {
    for g in [-0.9, -0.35, 0.0, 0.5, 0.97] {
        let slice = tables().slice(g, 0.6);
        for theta in [0.0, 0.3, PI / 2.0, PI] {
            let expected = phase_hg(theta.cos(), g);
            close("table", slice.radiance(theta, 0.0), expected, 1e-6);
            let point = reference::entry(theta, 0.0, g, 0.6, 2, 1);
            close("reference", point.radiance, expected, 1e-12);
        }
    }
}

#[test]
fn the_shipped_tables_agree_with_independent_values() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cases/avs_points.json");
    let points = read(&path).unwrap();
    let table = |p: &_| entry(tables(), p);
    let comparisons = compare(&points, table);
    for c in comparisons.iter().filter(|c| c.z.abs() > 3.0) {
        eprintln!("{c:?}");
    }
    assert!(points.len() == 82 && agrees(&comparisons));
    // Forward for backward must not pass.
    let reversed = |p: &_| {
        let p: &tyndall::technique::ambient_scattering::table::check::Point = p;
        tables().entry(p.theta, p.sigma_t, -p.g, p.albedo)
    };
    assert!(!agrees(&compare(&points, reversed)));
}

fn entry(
    shipped: &Shipped,
    p: &tyndall::technique::ambient_scattering::table::check::Point,
) -> [f64; 2] {
    shipped.entry(p.theta, p.sigma_t, p.g, p.albedo)
}

#[test]
fn slices_are_finite_above_zero_and_meet_at_nodes() {
    let table = tables().table();
    assert_eq!(table.radiance.len(), Grid::PAPER.len());
    for (i, g) in table.grid.gs.nodes().enumerate().step_by(6) {
        let slice = tables().slice(g, 0.9);
        for (sigma, theta) in [(0, 0), (1, 255), (77, 128), (255, 3), (255, 255)] {
            let expected = f64::from(table.radiance[table.index(i, sigma, theta)]);
            let found = f64::from(slice.radiance[sigma * 256 + theta]);
            close("node", found, expected, 1e-5);
        }
    }
    for (g, albedo) in [
        (-0.99, 0.0),
        (-0.95, 1.0),
        (0.05, 0.01),
        (0.93, 0.5),
        (0.99, 0.9),
    ] {
        let slice = tables().slice(g, albedo);
        let good = |v: &f32| v.is_finite() && *v > 0.0;
        assert!(slice.radiance.iter().all(good), "g {g} albedo {albedo}");
        let wide = slice.tabulate(&[0.0, 19.0, 30.0, 100.0, 1e4]);
        assert!(wide.iter().all(good), "g {g} albedo {albedo}");
    }
}

#[test]
fn more_albedo_means_more_light() {
    let slices: Vec<_> = [0.0, 0.2, 0.5, 0.85, 0.9, 0.97, 1.0]
        .map(|a| tables().slice(0.3, a))
        .into();
    for (theta, sigma) in [(0.5, 2.0), (1.5, 8.0), (3.0, 15.0)] {
        let values: Vec<_> = slices.iter().map(|s| s.radiance(theta, sigma)).collect();
        assert!(values.is_sorted(), "{values:?}");
    }
}

#[test]
fn beyond_the_last_extinction_the_lit_side_stays_and_the_other_decays() {
    let slice = tables().slice(0.0, 0.9);
    let ratio = |theta, a, b| slice.radiance(theta, b) / slice.radiance(theta, a);
    // A half-space: nothing changes but by what noise the trend keeps.
    close("lit", ratio(PI, 20.0, 60.0), 1.0, 0.1);
    // Light comes around the sphere's limb, 1 to sqrt(2) radii away, and falls off at 0.525 per mean free path
    // (the root of diffusion's exact equation at albedo 0.9), the straight way at 1.
    let per_radius = -ratio(0.0, 20.0, 30.0).ln() / 10.0;
    assert!((0.4..1.2).contains(&per_radius), "{per_radius}");
    let steady = -ratio(0.0, 30.0, 40.0).ln() / 10.0;
    close("exponential", steady, per_radius, 0.05);
}

#[test]
fn slice_files_come_back_as_they_were() {
    let folder = tempfile::tempdir().unwrap();
    let mut table = tables().table();
    table.samples = 123_456;
    let paths = format::write(folder.path(), &table).unwrap();
    assert_eq!(paths.len(), 19);
    let names: Vec<_> = paths.iter().map(|p| p.file_name().unwrap()).collect();
    assert_eq!(names[0], "AVSTable2D_a09_g-09.tab");
    assert_eq!(names[9], "AVSTable2D_a09_g00.tab");
    assert_eq!(names[18], "AVSTable2D_a09_g09.tab");
    assert_eq!(fs::metadata(&paths[0]).unwrap().len(), 32 + 4 * 256 * 256);
    let bytes = fs::read(&paths[0]).unwrap();
    assert_eq!(bytes[..4], 0.9f32.to_le_bytes());
    assert_eq!(bytes[4..8], (-0.9f32).to_le_bytes());
    let back = format::read(folder.path()).unwrap();
    assert_eq!(back.radiance, table.radiance);
    assert_eq!((back.albedo, back.samples), (0.9, 123_456));
    assert!((back.grid.gs.min + 0.9).abs() < 1e-9 && back.grid.gs.count == 19);
    assert_eq!(format::file_name(0.85, 0.25), "AVSTable2D_a0.85_g0.25.tab");
    assert_eq!(format::file_name(1.0, -0.1), "AVSTable2D_a10_g-01.tab");
    let one = format::read(&paths[4]).unwrap();
    let slice = one.slice(-0.5);
    close(
        "one slice",
        slice.radiance(1.0, 5.0),
        back.slice(-0.5).radiance(1.0, 5.0),
        1e-5,
    );
}

#[test]
fn hostile_slice_files_are_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("AVSTable2D_a09_g00.tab");
    let small = Table {
        albedo: 0.9,
        samples: 1,
        grid: Grid {
            thetas: Axis {
                count: 4,
                ..Grid::PAPER.thetas
            },
            sigmas: Axis {
                count: 3,
                ..Grid::PAPER.sigmas
            },
            gs: Axis {
                count: 1,
                min: 0.0,
                max: 0.0,
            },
        },
        radiance: vec![0.5; 12],
        standard_error: Vec::new(),
    };
    format::write(folder.path(), &small).unwrap();
    let good = fs::read(&path).unwrap();
    let nan = f32::NAN.to_le_bytes();
    let huge = i32::MAX.to_le_bytes();
    let cases: [(usize, [u8; 4], &str); 12] = [
        (0, 1.5f32.to_le_bytes(), "albedo is 1.5, expected 0 to 1"),
        (0, nan, "albedo is NaN"),
        (4, 1.0f32.to_le_bytes(), "g is 1"),
        (8, (-1i32).to_le_bytes(), "path samples is -1"),
        (12, huge, "extinctions is 2147483647"),
        (16, huge, "angles is 2147483647"),
        (16, 0i32.to_le_bytes(), "angles is 0"),
        (12, 4i32.to_le_bytes(), "the size is 80 bytes, expected 96"),
        (20, nan, "extinction is NaN"),
        (24, f32::INFINITY.to_le_bytes(), "extinction is 0 to inf"),
        (28, 0f32.to_le_bytes(), "radius is 0"),
        (36, nan, "radiance is NaN at value 1"),
    ];
    for (at, word, expected) in cases {
        let mut bad = good.clone();
        bad[at..at + 4].copy_from_slice(&word);
        refused(&path, &bad, expected);
    }
    refused(&path, &good[..79], "the size is 79 bytes");
    refused(
        &path,
        &good[..31],
        "the size is 31 bytes, expected at least 32",
    );
    refused(&path, &[], "the size is 0 bytes");
    refused(
        &path,
        &[good.as_slice(), &[0]].concat(),
        "the size is 81 bytes",
    );
    fs::write(&path, &good).unwrap();
    let other = folder.path().join("AVSTable2D_a08_g01.tab");
    let mut bad = good.clone();
    bad[..4].copy_from_slice(&0.8f32.to_le_bytes());
    bad[4..8].copy_from_slice(&0.1f32.to_le_bytes());
    fs::write(other, bad).unwrap();
    let error = format::read(folder.path()).unwrap_err().to_string();
    assert!(
        error.contains("of albedo 0.8") && error.contains("of albedo 0.9"),
        "{error}"
    );
    let empty = tempfile::tempdir().unwrap();
    let error = format::read(empty.path()).unwrap_err().to_string();
    assert!(error.contains("without tables"), "{error}");
    assert!(format::read(&empty.path().join("none.tab")).is_err());
}

fn refused(path: &Path, bytes: &[u8], expected: &str) {
    fs::write(path, bytes).unwrap();
    let error = format::read(path).unwrap_err().to_string();
    assert!(
        error.contains(expected) && error.contains("AVSTable2D_a09_g00.tab"),
        "{error}"
    );
}

#[test]
fn packed_tables_that_are_none_are_refused() {
    let path = Path::new("some.tynpack");
    for bytes in [&b""[..], b"TYNPACK2", b"TYNPACK2garbage", b"TYNPACK1"] {
        let error = Shipped::unpack(path, bytes).err().unwrap().to_string();
        assert!(error.contains("some.tynpack"), "{error}");
    }
}

#[test]
fn points_that_are_none_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("points.json");
    let point = r#"{"albedo": 2, "g": 0, "sigma_t": 1, "theta": 0, "Lo": 1, "stderr": 0}"#;
    for text in ["", "{}", "[1]", &format!("{{\"points\": [{point}]}}")] {
        fs::write(&path, text).unwrap();
        let error = read(&path).unwrap_err().to_string();
        assert!(
            error.contains("points.json") && error.contains("expected"),
            "{error}"
        );
    }
}
