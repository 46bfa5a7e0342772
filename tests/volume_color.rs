//! Colour volumes: what is read, what is refused.
#![allow(clippy::unwrap_used, clippy::expect_used)]

use std::path::{Path, PathBuf};

use glam::{DVec3, UVec3};
use tempfile::TempDir;
use tyndall::volume::{ColorVolume, RawLayout, ReadOptions, ScalarType, read, read_color};

const HEADER: &str = "NRRD0004\ntype: float\ndimension: 4\nsizes: 3 2 1 2\n\
                      kinds: RGB-color domain domain domain\nendian: little\nencoding: raw\n\n";

/// Values i / 12 of 2 x 1 x 2 colours.
fn floats() -> Vec<u8> {
    let values = (0..12u8).flat_map(|i| (f32::from(i) / 12.0).to_le_bytes());
    values.collect()
}

fn file(folder: &TempDir, header: &str, payload: &[u8]) -> PathBuf {
    let path = folder.path().join("c.nrrd");
    let mut bytes = header.as_bytes().to_vec();
    bytes.extend(payload);
    std::fs::write(&path, bytes).unwrap();
    path
}

fn refused(path: &Path, expected: &str) {
    let text = read_color(path, None).unwrap_err().to_string();
    assert!(text.contains("c.nrrd") && text.contains(expected), "{text}");
}

#[test]
fn the_first_axis_holds_the_colours() {
    let folder = tempfile::tempdir().unwrap();
    let kinds = "kinds: RGB-color domain domain domain\n";
    for header in [HEADER.to_owned(), HEADER.replace(kinds, "")] {
        let colors = read_color(&file(&folder, &header, &floats()), None).unwrap();
        assert_eq!(colors.dims, UVec3::new(2, 1, 2));
        let last = DVec3::new(9.0, 10.0, 11.0) / 12.0;
        assert!((colors.color(3) - last).length() < 1e-7);
        let between = colors.sample_index(DVec3::new(0.5, 0.0, 1.0));
        assert!((between - DVec3::new(7.5, 8.5, 9.5) / 12.0).length() < 1e-7);
    }
}

#[test]
fn integers_count_to_one() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("c.raw");
    std::fs::write(&path, [0u8, 51, 255]).unwrap();
    let layout = RawLayout {
        dims: [1, 1, 1],
        scalar_type: ScalarType::U8,
        spacing: [1.0; 3],
        big_endian: false,
        skip_bytes: 0,
    };
    let colors = read_color(&path, Some(layout)).unwrap();
    assert!(colors.is_8_bit());
    assert!((colors.color(0) - DVec3::new(0.0, 0.2, 1.0)).length() < 1e-12);
}

#[test]
fn wrong_files_name_what_is_wrong() {
    let folder = tempfile::tempdir().unwrap();
    let refuse = |from: &str, to: &str, expected: &str| {
        refused(
            &file(&folder, &HEADER.replace(from, to), &floats()),
            expected,
        );
    };
    refuse("type: float", "type: int8", "colours as u8 or u16");
    refuse("3 2 1 2", "4 2 1 2", "3 colours on the first");
    refuse("3 2 1 2", "3 2 1 3", "voxel data");
    refuse("3 2 1 2", "3 4000000000 1 2", "at most 1431655765");
    refuse(
        "RGB-color domain domain domain",
        "domain domain domain time",
        "3 colours on the first",
    );
    refuse(
        "dimension: 4\nsizes: 3 2 1 2\nkinds: RGB-color domain domain domain",
        "dimension: 3\nsizes: 3 2 2",
        "4 with the 3 colours",
    );
    let mut out = floats();
    out[40..44].copy_from_slice(&1.5f32.to_le_bytes());
    refused(&file(&folder, HEADER, &out), "1.5 as value 10");
    out[40..44].copy_from_slice(&f32::NAN.to_le_bytes());
    refused(&file(&folder, HEADER, &out), "NaN as value 10");
}

#[test]
fn colours_are_no_scalars() {
    let folder = tempfile::tempdir().unwrap();
    let path = file(&folder, HEADER, &floats());
    let error = read(&path, &ReadOptions::default(), &mut |_, _| {}).unwrap_err();
    assert!(error.to_string().contains("one value a voxel"), "{error}");
}

#[test]
fn a_volume_of_colours_can_be_made() {
    let colors = ColorVolume::new(
        "made",
        UVec3::new(1, 2, 1),
        &[[0.0, 0.5, 1.0], [1.0, 0.5, 0.0]],
    );
    let middle = colors.sample_index(DVec3::new(0.0, 0.5, 0.0));
    assert!((middle - DVec3::splat(0.5)).length() < 1e-12);
}
