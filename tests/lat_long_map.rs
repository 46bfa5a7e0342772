//! Environment maps: what is read, what is refused, where a direction looks.
#![allow(clippy::unwrap_used, clippy::expect_used)]

use std::f64::consts::PI;
use std::path::Path;

use glam::DVec3;
use tyndall::output::{Image, Metadata, exr};
use tyndall::scene::{LatLongMap, world_from_map};

fn write_exr(path: &Path, width: u32, height: u32, pixel: impl Fn(u32, u32) -> [f32; 4]) {
    let pixels = (0..width * height).map(|i| pixel(i % width, i / width));
    let image = Image {
        width,
        height,
        pixels: pixels.collect(),
    };
    exr::write(path, &image, &Metadata::default()).unwrap();
}

/// A Radiance picture, uncompressed: mantissas and a common exponent.
fn hdr(width: u32, height: u32, texels: &[[u8; 4]]) -> Vec<u8> {
    let mut bytes =
        format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n").into_bytes();
    bytes.extend(texels.iter().flatten());
    bytes
}

#[test]
fn open_exr_and_radiance_pictures_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    write_exr(&path, 4, 2, |x, y| [x as f32, y as f32, 0.25, 1.0]);
    let map = LatLongMap::read(&path).unwrap();
    assert_eq!((map.width, map.height, map.name.as_str()), (4, 2, "a.exr"));
    assert_eq!(
        map.texels[6].map(f32::to_bits),
        [2.0, 1.0, 0.25].map(f32::to_bits)
    );
    let path = folder.path().join("named_wrongly.exr");
    // 128 / 256 * 2^(130 - 128) = 2.
    std::fs::write(&path, hdr(2, 1, &[[128, 64, 0, 130], [0, 0, 0, 0]])).unwrap();
    let map = LatLongMap::read(&path).unwrap();
    assert_eq!((map.width, map.height), (2, 1));
    assert!((map.texels[0][0] - 2.0).abs() < 0.02, "{:?}", map.texels);
    assert_eq!(map.texels[1].map(f32::to_bits), [0; 3]);
}

#[test]
fn what_is_no_picture_of_radiance_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.hdr");
    let refused = |bytes: &[u8], expected: &str| {
        std::fs::write(&path, bytes).unwrap();
        let text = LatLongMap::read(&path).unwrap_err().to_string();
        assert!(text.contains("a.hdr") && text.contains(expected), "{text}");
    };
    refused(b"", "neither an OpenEXR");
    refused(b"\x89PNG\r\n\x1a\n", "neither an OpenEXR");
    refused(b"#?RADIANCE\n", "cannot be read");
    refused(&hdr(9, 9, &[[1; 4]]), "cannot be read");
    refused(&hdr(0, 1, &[]), "0 x 1");
    refused(&hdr(4_000_000_000, 4_000_000_000, &[]), "a.hdr");
    refused(&[0x76, 0x2f, 0x31, 0x01, 0, 0, 0, 0], "a.hdr");
    let missing = LatLongMap::read(&folder.path().join("none.hdr")).unwrap_err();
    assert!(missing.to_string().contains("none.hdr: cannot be opened"));
    let a_folder = LatLongMap::read(folder.path()).unwrap_err();
    assert!(a_folder.to_string().contains("no regular file"));
}

#[test]
fn a_bad_texel_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    for bad in [f32::NAN, f32::INFINITY, -0.5] {
        write_exr(&path, 4, 4, |x, y| {
            if (x, y) == (2, 3) { [bad; 4] } else { [1.0; 4] }
        });
        let text = LatLongMap::read(&path).unwrap_err().to_string();
        assert!(text.contains("column 2, row 3"), "{text}");
    }
}

fn gradient() -> LatLongMap {
    LatLongMap {
        name: "gradient".to_owned(),
        width: 8,
        height: 4,
        texels: (0..32)
            .map(|i| [(i % 8) as f32, (i / 8) as f32, 1.0])
            .collect(),
    }
}

#[test]
fn directions_look_where_the_convention_says() {
    let map = gradient();
    let at = |d: DVec3| map.radiance(d.normalize());
    // Texel centres are at (column + 1/2) / width: u = 1/4 lies between columns 1 and 2.
    assert!((at(DVec3::X) - DVec3::new(1.5, 1.5, 1.0)).length() < 1e-12);
    assert!((at(DVec3::Z) - DVec3::new(3.5, 1.5, 1.0)).length() < 1e-12);
    assert!((at(-DVec3::X) - DVec3::new(5.5, 1.5, 1.0)).length() < 1e-12);
    // The seam lies between the last column and the first.
    assert!((at(-DVec3::Z) - DVec3::new(3.5, 1.5, 1.0)).length() < 1e-12);
    assert!((at(DVec3::Y).y).abs() < 1e-12);
    assert!((at(-DVec3::Y).y - 3.0).abs() < 1e-12);
}

#[test]
fn the_mean_weighs_rows_by_their_solid_angle() {
    let mean = gradient().mean();
    assert!((mean.x - 3.5).abs() < 1e-6 && (mean.z - 1.0).abs() < 1e-6);
    let cap = |a: f64, b: f64| 0.5 * ((PI * a / 4.0).cos() - (PI * b / 4.0).cos());
    let expected = cap(1.0, 2.0) + 2.0 * cap(2.0, 3.0) + 3.0 * cap(3.0, 4.0);
    assert!((mean.y - expected).abs() < 1e-12, "{mean}");
}

#[test]
fn maps_stand_upright_and_turn_counterclockwise() {
    let still = world_from_map(DVec3::Z, 0.0);
    let close = |a: DVec3, b: DVec3| assert!((a - b).length() < 1e-12, "{a} {b}");
    close(still * DVec3::Y, DVec3::Z);
    close(still * DVec3::Z, -DVec3::Y);
    close(world_from_map(DVec3::Y, 0.0) * DVec3::Z, DVec3::Z);
    // From above, +x turns to +y.
    close(world_from_map(DVec3::Z, 90.0) * DVec3::X, DVec3::Y);
    close(world_from_map(-DVec3::Y, 0.0) * DVec3::Y, -DVec3::Y);
}
