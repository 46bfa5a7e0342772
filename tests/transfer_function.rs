//! Transfer functions as a user meets them: evaluation, baking, presets, automatic choice, files.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use std::path::PathBuf;

use glam::{DVec3, UVec3, Vec3};
use tyndall::scene::transfer_function::{
    OPACITY_MAX, Preset, TransferFunctionError, automatic, read_file, read_paraview,
};
use tyndall::scene::{ControlPoint, TransferFunction, linear_from_srgb};
use tyndall::volume::{Grid, Rescale, Space, Statistics, Volume, Voxels};

fn grid() -> Grid {
    Grid::centred(UVec3::new(3, 4, 12), DVec3::ONE)
}

fn volume(voxels: Voxels) -> Volume {
    Volume {
        name: "test".to_owned(),
        grid: grid(),
        voxels,
        rescale: Rescale::IDENTITY,
        spatial_unit: None,
        height_field: None,
    }
}

/// Statistics with `count` voxels in the bin of each `(from, to)` range of values.
fn statistics(min: f64, max: f64, ranges: &[(f64, f64, u64)]) -> Statistics {
    let bins = Statistics::BINS;
    let width = (max - min) / bins as f64;
    let histogram = (0..bins)
        .map(|i| min + (i as f64 + 0.5) * width)
        .map(|v| {
            let inside = ranges.iter().filter(|r| r.0 <= v && v < r.1);
            inside.map(|r| r.2).sum()
        })
        .collect();
    Statistics {
        min,
        max,
        histogram,
        ..Statistics::of(&volume(Voxels::U8(vec![0; 144])))
    }
}

fn point(value: f64, color: [f32; 3], opacity: f64) -> ControlPoint {
    ControlPoint {
        value,
        color: Vec3::from(color),
        opacity,
    }
}

fn function(points: Vec<ControlPoint>) -> TransferFunction {
    TransferFunction::new("test", points, 2.0).unwrap()
}

/// The file stays until the folder is dropped.
fn file(name: &str, text: &str) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, text).unwrap();
    (folder, path)
}

fn json(text: &str, data: (f64, f64)) -> Result<TransferFunction, TransferFunctionError> {
    let (_folder, path) = file("map.json", text);
    read_paraview(&path, &statistics(data.0, data.1, &[(data.0, data.1, 1)]))
}

fn toml(text: &str) -> Result<TransferFunction, TransferFunctionError> {
    let (_folder, path) = file("map.toml", text);
    read_file(&path, &grid(), &statistics(0.0, 1.0, &[(0.0, 1.0, 1)]))
}

#[track_caller]
fn assert_color(found: Vec3, expected: [f32; 3]) {
    let difference = (found - Vec3::from(expected)).abs().max_element();
    assert!(difference < 2e-3, "{found} instead of {expected:?}");
}

#[test]
fn evaluates_at_between_and_beyond_nodes() {
    let f = function(vec![
        point(-1.0, [0.0, 0.0, 0.0], 0.2),
        point(1.0, [1.0, 0.5, 2.0], 0.6),
    ]);
    assert_eq!(f.evaluate(-5.0), (Vec3::ZERO, 0.2));
    assert_eq!(f.evaluate(-1.0), (Vec3::ZERO, 0.2));
    assert_eq!(f.evaluate(1.0), (Vec3::new(1.0, 0.5, 2.0), 0.6));
    assert_eq!(f.evaluate(f64::INFINITY), (Vec3::new(1.0, 0.5, 2.0), 0.6));
    let (color, opacity) = f.evaluate(0.0);
    assert_eq!(color, Vec3::new(0.5, 0.25, 1.0));
    assert!((opacity - 0.4).abs() < 1e-15);
    assert_eq!(f.evaluate(f64::NAN), (Vec3::ZERO, 0.0));
}

#[test]
fn a_jump_takes_its_upper_side() {
    let f = function(vec![
        point(0.0, [0.0; 3], 0.0),
        point(1.0, [0.0; 3], 0.0),
        point(1.0, [1.0; 3], 0.8),
    ]);
    assert_eq!(f.evaluate(1.0 - 1e-12).1, 0.0);
    assert_eq!(f.evaluate(1.0), (Vec3::ONE, 0.8));
    let table = f.bake(0.0, 2.0, 3, 1.0);
    assert_eq!(table[0][3], 0.0);
    assert_eq!(table[1][3], f.sigma_t(1.0) as f32);
    assert_eq!(f.bake(0.0, 1.0, 5, 1.0)[4][3], f.sigma_t(1.0) as f32);
}

#[test]
fn an_empty_function_is_transparent() {
    let f = function(Vec::new());
    assert_eq!(f.evaluate(3.0), (Vec3::ZERO, 0.0));
    assert_eq!(f.range(), None);
    assert_eq!(f.bake(0.0, 1.0, 4, 1.0), vec![[0.0; 4]; 4]);
    assert_eq!(f.entries_needed(0.0, 1.0), 1024);
}

#[test]
fn baked_entries_are_evaluated_values() {
    let f = function(vec![
        point(0.0, [0.0, 0.2, 1.0], 0.0),
        point(30.0, [1.0, 0.4, 0.0], 0.5),
        point(100.0, [0.5, 0.5, 0.5], 0.9),
    ]);
    let entries = f.entries_needed(-10.0, 110.0);
    let table = f.bake(-10.0, 110.0, entries, 3.0);
    assert_eq!(table.len(), entries);
    for (i, entry) in table.iter().enumerate() {
        let value = -10.0 + 120.0 * (i as f64 / (entries - 1) as f64);
        let (color, _) = f.evaluate(value);
        assert_color(Vec3::from_slice(&entry[..3]), color.to_array());
        let sigma_t = f.sigma_t(value) * 3.0;
        assert!((f64::from(entry[3]) - sigma_t).abs() <= 1e-6 * (1.0 + sigma_t));
    }
    assert_eq!(f.bake(30.0, 30.0, 4, 1.0), vec![table_entry(&f, 30.0); 4]);
    assert_eq!(f.bake(30.0, 90.0, 1, 1.0), vec![table_entry(&f, 30.0)]);
    assert!(f.bake(0.0, 1.0, 0, 1.0).is_empty());
}

fn table_entry(f: &TransferFunction, value: f64) -> [f32; 4] {
    let (color, _) = f.evaluate(value);
    [color.x, color.y, color.z, f.sigma_t(value) as f32]
}

#[test]
fn a_one_bin_spike_is_resolved_or_kept() {
    let spike = |width: f64| {
        function(vec![
            point(500.0 - width, [1.0; 3], 0.0),
            point(500.0, [1.0; 3], 0.9),
            point(500.0 + width, [1.0; 3], 0.0),
        ])
    };
    let peak = spike(1.0).sigma_t(500.0) as f32;
    for width in [1.0, 0.1, 1e-6] {
        let f = spike(width);
        let table = f.bake(0.0, 1000.0, f.entries_needed(0.0, 1000.0), 1.0);
        let highest = table.iter().map(|e| e[3]).fold(0.0, f32::max);
        assert!(highest > 0.3 * peak, "width {width}: {highest} of {peak}");
    }
}

#[test]
fn extinction_is_limited_at_opacity_1() {
    let f = function(vec![point(0.0, [1.0; 3], 1.0)]);
    let limit = -(1.0 - OPACITY_MAX).ln() / 2.0;
    assert!((f.sigma_t(0.0) - limit).abs() < 1e-9);
    assert!((f.bake(0.0, 1.0, 2, 10.0)[1][3] - 10.0 * limit as f32).abs() < 1e-3);
}

#[test]
fn tiny_opacities_do_not_vanish() {
    let f = function(vec![point(0.0, [1.0; 3], 1e-20)]);
    assert_eq!(f.sigma_t(0.0), 0.5e-20);
}

#[test]
fn ct_presets_hide_air_and_show_bone() {
    let s = statistics(-1024.0, 3000.0, &[(-1024.0, 3000.0, 1)]);
    let of = |preset: Preset| preset.transfer_function(&grid(), &s);
    for preset in [Preset::CtBone, Preset::CtSkinBone, Preset::CtSoftTissue] {
        let f = of(preset);
        assert_eq!(f.name, preset.name());
        assert_eq!(f.opacity_unit_distance, 1.0);
        assert_eq!(f.evaluate(-1000.0).1, 0.0, "{}", preset.name());
        assert_eq!(f.evaluate(-600.0).1, 0.0, "{}", preset.name());
        assert!(f.evaluate(1500.0).1 > 0.85, "{}", preset.name());
    }
    for hidden in [-100.0, 40.0, 100.0] {
        assert_eq!(of(Preset::CtBone).evaluate(hidden).1, 0.0);
        assert_eq!(of(Preset::CtSkinBone).evaluate(hidden).1, 0.0);
    }
    let skin = of(Preset::CtSkinBone).evaluate(-300.0).1;
    assert!((0.05..0.6).contains(&skin));
    let soft = of(Preset::CtSoftTissue);
    assert!(soft.evaluate(-90.0).1 < 0.01 && soft.evaluate(60.0).1 > 0.1);
}

#[test]
fn relative_presets_follow_the_histogram() {
    // A background with its peak at 100, a foreground from 400 to 900, one outlier at 10000.
    let ranges = [
        (0.0, 200.0, 1000),
        (400.0, 900.0, 100),
        (9990.0, 10000.0, 1),
    ];
    let s = statistics(0.0, 10000.0, &ranges);
    for preset in [Preset::Mri, Preset::Fluorescence, Preset::Generic] {
        let f = preset.transfer_function(&grid(), &s);
        let (low, high) = f.range().unwrap();
        assert!((150.0..420.0).contains(&low), "{}: {low}", preset.name());
        assert!((700.0..1000.0).contains(&high), "{}: {high}", preset.name());
        assert_eq!(f.evaluate(100.0).1, 0.0);
        assert!(f.evaluate(10000.0).1 > 0.3);
        assert!((f.opacity_unit_distance - 13.0 * 0.005).abs() < 1e-12);
    }
}

#[test]
fn hounsfield_units_are_recognised() {
    let air = (-1024.0, -900.0, 1000);
    let tissue = (-100.0, 100.0, 400);
    let bone = (200.0, 2900.0, 5);
    let scan = volume(Voxels::I16(vec![0; 144]));
    let f = automatic(&scan, &statistics(-1024.0, 3000.0, &[air, tissue, bone]));
    assert!(f.name.starts_with("automatic: ct_skin_bone"), "{}", f.name);
    assert!(f.name.contains("(-1024 … 3000)"), "{}", f.name);

    let little_air = (-1024.0, -900.0, 40);
    let f = automatic(
        &scan,
        &statistics(-1024.0, 3000.0, &[little_air, tissue, bone]),
    );
    assert!(f.name.starts_with("automatic: ct_bone"), "{}", f.name);

    // Outside the scanner's circle: padding.
    let padding = (-3024.0, -3010.0, 3000);
    let f = automatic(
        &scan,
        &statistics(-3024.0, 3000.0, &[padding, air, tissue, bone]),
    );
    assert!(f.name.starts_with("automatic: ct_skin_bone"), "{}", f.name);

    // Unsigned values with a negative intercept are CT, without one they cannot be.
    let mut stored = volume(Voxels::U16(vec![0; 144]));
    stored.rescale.intercept = -1024.0;
    let f = automatic(&stored, &statistics(-1024.0, 3000.0, &[air, tissue, bone]));
    assert!(f.name.starts_with("automatic: ct_skin_bone"), "{}", f.name);
}

#[test]
fn signed_values_without_air_are_not_hounsfield_units() {
    let scan = volume(Voxels::I16(vec![0; 144]));
    // An offset scan: -2000 outside the circle, air at 0 to 100, clay at 2300.
    let ranges = [
        (-2000.0, -1994.0, 20000),
        (0.0, 100.0, 4000),
        (100.0, 2200.0, 10),
        (2200.0, 2500.0, 60),
    ];
    let f = automatic(&scan, &statistics(-2000.0, 4095.0, &ranges));
    assert!(f.name.starts_with("automatic: generic"), "{}", f.name);
    assert_eq!(f.evaluate(-2000.0).1, 0.0);
    assert_eq!(f.evaluate(60.0).1, 0.0);
    assert!(f.evaluate(2400.0).1 > 0.5);
    // Symmetric amplitudes.
    let f = automatic(&scan, &statistics(-2000.0, 2000.0, &[(-2000.0, 2000.0, 5)]));
    assert!(f.name.starts_with("automatic: generic"), "{}", f.name);
}

#[test]
fn mri_needs_a_tissue_peak_in_patient_space() {
    let ranges = [
        (0.0, 20.0, 2000),
        (20.0, 60.0, 3),
        (60.0, 200.0, 120),
        (200.0, 255.0, 2),
    ];
    let s = statistics(0.0, 255.0, &ranges);
    let mut scan = volume(Voxels::U8(vec![0; 144]));
    assert!(automatic(&scan, &s).name.starts_with("automatic: generic"));
    scan.grid.space = Space::PatientRas;
    let f = automatic(&scan, &s);
    assert!(f.name.starts_with("automatic: mri"), "{}", f.name);
    assert_eq!(f.evaluate(10.0).1, 0.0);
    assert!(f.evaluate(120.0).1 > 0.5);
}

#[test]
fn sparse_volumes_are_opaque_from_the_threshold() {
    let mask = statistics(0.0, 1.0, &[(0.0, 0.001, 950), (0.999, 1.0, 50)]);
    let f = automatic(&volume(Voxels::U8(vec![0; 144])), &mask);
    assert!(f.name.contains("opaque from 0.5000"), "{}", f.name);
    assert_eq!(f.evaluate(0.0).1, 0.0);
    assert!(f.evaluate(0.25).1 < 0.3 && f.evaluate(0.5).1 > 0.85);
    assert!(TransferFunction::new("", f.points, 1.0).is_ok());
}

#[test]
fn every_histogram_gets_a_valid_function_that_shows_its_highest_value() {
    let scan = volume(Voxels::F32(vec![0.0; 144]));
    for (min, max) in [
        (0.0, 1.0),
        (-5.0, -4.0),
        (1e-30, 2e-30),
        (-1e30, 1e30),
        (0.0, 1e6),
    ] {
        let w = max - min;
        let low = (min, min + 0.01 * w, 1000);
        for ranges in [
            vec![(min, max, 1)],
            vec![low, (max - 0.01 * w, max, 1)],
            vec![low, (max - 0.01 * w, max, 100_000)],
            vec![low, (min + 0.5 * w, max, 3)],
        ] {
            let f = automatic(&scan, &statistics(min, max, &ranges));
            let f = TransferFunction::new(f.name, f.points, f.opacity_unit_distance).unwrap();
            assert_eq!(f.evaluate(min).1, 0.0, "{}", f.name);
            assert!(f.evaluate(max).1 > 0.3, "{}", f.name);
        }
    }
}

#[test]
fn constant_and_empty_volumes_get_a_function() {
    let scan = volume(Voxels::F32(vec![7.0; 144]));
    let mut s = statistics(0.0, 1.0, &[]);
    (s.min, s.max) = (7.0, 7.0);
    let f = automatic(&scan, &s);
    assert!(f.name.contains("all values are 7"), "{}", f.name);
    assert!(f.evaluate(7.0).1 > 0.5);
    (s.min, s.max) = (0.0, 0.0);
    assert_eq!(automatic(&scan, &s).evaluate(0.0).1, 0.0);
}

#[test]
fn paraview_rgb_is_read_as_srgb_with_a_ramp() {
    let f = json(
        r#"[{"ColorSpace": "RGB", "Name": "two", "NanColor": [1, 0, 0],
            "RGBPoints": [100, 1, 1, 1, 0, 0, 0.5, 0]}]"#,
        (0.0, 100.0),
    )
    .unwrap();
    assert!(f.name.ends_with("map.json: two"), "{}", f.name);
    assert_eq!(
        (f.range(), f.opacity_unit_distance),
        (Some((0.0, 100.0)), 1.0)
    );
    assert_color(f.evaluate(0.0).0, [0.0, linear_from_srgb(0.5), 0.0]);
    // Straight in encoded values, not in linear ones.
    let half = linear_from_srgb(0.5);
    assert_color(f.evaluate(50.0).0, [half, linear_from_srgb(0.75), half]);
    assert!((f.evaluate(25.0).1 - 0.25).abs() < 1e-12);
}

#[test]
fn paraview_color_spaces_and_steps() {
    let map = |space: &str, s: f64| {
        let points = "[0, 0.23, 0.299, 0.754, 1, 0.706, 0.016, 0.15]";
        let text = format!(r#"{{"ColorSpace": "{space}", "RGBPoints": {points}}}"#);
        json(&text, (0.0, 1.0)).unwrap().evaluate(s).0
    };
    // Encoded colours by VTK 9's vtkColorTransferFunction.
    for (space, s, encoded) in [
        ("RGB", 0.5, [0.468, 0.1575, 0.452]),
        ("HSV", 0.5, [0.63054, 0.11961, 0.73]),
        ("Lab", 0.5, [0.58062, 0.20323, 0.444]),
        ("CIELAB", 0.25, [0.46652, 0.25393, 0.59617]),
        ("Diverging", 0.5, [0.8654, 0.86541, 0.8654]),
        ("Step", 0.25, [0.706, 0.016, 0.15]),
        ("Step", 0.75, [0.706, 0.016, 0.15]),
    ] {
        assert_color(map(space, s), encoded.map(linear_from_srgb));
    }
}

#[test]
fn paraview_opacities_keep_midpoint_and_sharpness() {
    let f = json(
        r#"{"RGBPoints": [0, 0, 0, 0, 2, 1, 1, 1],
            "Points": [0, 0, 0.3, 0.4, 1, 1, 0.7, 0, 2, 0.2, 0.5, 0]}"#,
        (0.0, 2.0),
    )
    .unwrap();
    // The first by VTK 9's vtkPiecewiseFunction, the second by hand.
    assert!((f.evaluate(0.5).1 - 0.934_491).abs() < 1e-3);
    assert!((f.evaluate(1.7).1 - 0.6).abs() < 1e-12);
    assert!((f.evaluate(2.0).1 - 0.2).abs() < 1e-12);
}

#[test]
fn paraview_maps_are_stretched_only_where_they_must_be() {
    let text = r#"{"RGBPoints": [0, 0, 0, 0, 1, 1, 1, 1]}"#;
    let f = json(text, (-1000.0, 3000.0)).unwrap();
    assert_eq!(f.range(), Some((-1000.0, 3000.0)));
    assert!(f.name.contains("stretched over the data: -1000 … 3000"));
    assert_eq!(json(text, (0.0, 0.5)).unwrap().range(), Some((0.0, 1.0)));
    let text = r#"{"RGBPoints": [200, 0, 0, 0, 300, 1, 1, 1]}"#;
    assert_eq!(
        json(text, (0.0, 255.0)).unwrap().range(),
        Some((200.0, 300.0))
    );
    assert_eq!(json(text, (0.0, 1.0)).unwrap().range(), Some((0.0, 1.0)));
    // Colours of a preset, opacities in data values.
    let text =
        r#"{"RGBPoints": [0, 0, 0, 0, 1, 1, 1, 1], "Points": [10, 0, 0.5, 0, 90, 1, 0.5, 0]}"#;
    let f = json(text, (0.0, 100.0)).unwrap();
    assert_eq!((f.evaluate(10.0).1, f.evaluate(90.0).1), (0.0, 1.0));
    assert_color(f.evaluate(100.0).0, [1.0; 3]);
}

#[test]
fn a_plain_list_is_linear_and_per_world_unit() {
    let (_folder, path) = file("list.json", "[[0, 0, 0, 0, 0], [0.5, 1, 0.5, 0.25, 0.4]]");
    let s = statistics(0.0, 1000.0, &[(0.0, 1000.0, 1)]);
    let f = read_file(&path, &grid(), &s).unwrap();
    assert_eq!(f.opacity_unit_distance, 1.0);
    assert_eq!(f.evaluate(0.5), (Vec3::new(1.0, 0.5, 0.25), 0.4));
}

#[test]
fn read_file_takes_paraviews_unit_distance_and_toml() {
    let (_folder, path) = file("map.JSON", r#"[{"RGBPoints": [0, 0, 0, 0, 1, 1, 1, 1]}]"#);
    let s = statistics(0.0, 1.0, &[(0.0, 1.0, 1)]);
    let f = read_file(&path, &grid(), &s).unwrap();
    assert!((f.opacity_unit_distance - 13.0 / 144f64.cbrt()).abs() < 1e-12);

    let body = "opacity_unit_distance = 0.5\nunits = \"data\"\npoints = [[3, 0.5, 0, 1, 0.25]]";
    let f = toml(&format!("color_space = \"srgb\"\n{body}")).unwrap();
    assert_color(f.evaluate(3.0).0, [linear_from_srgb(0.5), 0.0, 1.0]);
    assert_eq!(f.opacity_unit_distance, 0.5);
    let f = toml(&format!("color_space = \"linear\"\n{body}")).unwrap();
    assert_color(f.evaluate(3.0).0, [0.5, 0.0, 1.0]);
}

#[test]
fn errors_name_file_field_and_expectation() {
    let color = r#""RGBPoints": [0, 0, 0, 0, 1, 1, 1, 1]"#;
    for (text, expected) in [
        ("[{".to_owned(), "line 1 column 2"),
        ("7".to_owned(), "expected a ParaView colour map"),
        ("[]".to_owned(), "no colour map"),
        ("{}".to_owned(), "`RGBPoints` is missing"),
        (r#"{"IndexedColors": [1, 0, 0]}"#.to_owned(), "categories"),
        (r#"{"RGBPoints": 3}"#.to_owned(), "`RGBPoints` is 3"),
        (r#"{"RGBPoints": [0, 0, 0]}"#.to_owned(), "multiple of 4"),
        (r#"{"RGBPoints": []}"#.to_owned(), "`RGBPoints` is empty"),
        (
            r#"{"RGBPoints": [0, 0, null, 0]}"#.to_owned(),
            "`RGBPoints`[2] is null",
        ),
        (
            r#"{"RGBPoints": [0, 0, 255, 0]}"#.to_owned(),
            "point 0 has the colour",
        ),
        (
            r#"{"RGBPoints": [1e999, 0, 0, 0]}"#.to_owned(),
            "number out of range",
        ),
        (
            r#"{"RGBPoints": [NaN, 0, 0, 0]}"#.to_owned(),
            "line 1 column",
        ),
        (
            format!(r#"{{{color}, "ColorSpace": "Oklab"}}"#),
            "\"Oklab\"",
        ),
        (
            format!(r#"{{{color}, "ColorSpace": 1}}"#),
            "expected a string",
        ),
        (
            format!(r#"{{{color}, "Points": [0, 2, 0.5, 0]}}"#),
            "opacity 2",
        ),
        (
            format!(r#"{{{color}, "Points": [0, 1, 0.5, -1]}}"#),
            "sharpness -1",
        ),
        ("[[0, 0, 0, 0]]".to_owned(), "[0] has 4 numbers, expected 5"),
        (
            "[[0, 0, 0, 0, 0], [1, 0, 0, 0, 3]]".to_owned(),
            "points[1]: opacity is 3",
        ),
        (
            "[[1, 0, 0, 0, 0], [0, 0, 0, 0, 0]]".to_owned(),
            "expected ascending",
        ),
        ("[[1, 0, 0, 0, 0], 5]".to_owned(), "[1] is 5"),
    ] {
        let error = json(&text, (0.0, 1.0)).unwrap_err();
        assert!(error.path.ends_with("map.json"), "{error}");
        assert!(error.to_string().contains(expected), "{text}: {error}");
    }
    let many = format!("[{}]", vec!["[0,0,0,0,0]"; 100_001].join(","));
    assert!(
        json(&many, (0.0, 1.0))
            .unwrap_err()
            .to_string()
            .contains("at most 100000")
    );
    let head = "color_space = \"linear\"\nunits = \"data\"\nopacity_unit_distance = 1\n";
    let error = toml(&format!("{head}points = [[nan, 1, 1, 1, 0]]")).unwrap_err();
    assert!(
        error.to_string().contains("map.toml: points[0]: value NaN"),
        "{error}"
    );
}

#[test]
fn missing_files_and_unknown_endings_are_named() {
    let s = statistics(0.0, 1.0, &[(0.0, 1.0, 1)]);
    let error = read_file(&PathBuf::from("no/such.json"), &grid(), &s).unwrap_err();
    assert!(
        error
            .to_string()
            .starts_with("no/such.json: cannot be opened")
    );
    let error = read_file(&PathBuf::from("map.xml"), &grid(), &s).unwrap_err();
    assert!(error.to_string().contains("the ending is `xml`"));
}

#[test]
fn points_of_one_value_beyond_a_jump_are_dropped() {
    let f = json(
        r#"{"RGBPoints": [0,0,0,0, 1,0,0,0, 1,0.3,0,0, 1,1,1,1, 2,1,1,1]}"#,
        (0.0, 2.0),
    )
    .unwrap();
    assert_eq!(f.evaluate(0.99).0, Vec3::ZERO);
    assert_color(f.evaluate(1.0).0, [1.0; 3]);
}
