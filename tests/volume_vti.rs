//! VTK image files: every way of writing the data, where the voxels lie, which array is taken.

#![allow(clippy::unwrap_used, clippy::panic)]

mod volume_files;

use glam::{DVec3, UVec3};
use tempfile::TempDir;
use tyndall::volume::{Format, ReadOptions, ScalarType, Space, Volume, read, read_header};
use volume_files::{Encoding, Vti, payload, refused, values, write};

/// Reads a file of these bytes.
#[track_caller]
fn load(bytes: &[u8]) -> Volume {
    let dir = TempDir::new().unwrap();
    let path = write(dir.path(), "a.vti", &[bytes]);
    read(&path, &ReadOptions::default(), &mut |_, _| {}).unwrap_or_else(|e| panic!("{e}"))
}

fn stored(volume: &Volume) -> Vec<f64> {
    let n = volume.voxels.len();
    (0..n).map(|i| volume.voxels.get(i)).collect()
}

#[test]
fn every_encoding_of_every_type_gives_the_same_values() {
    for scalar_type in ScalarType::ALL {
        let v = values(scalar_type, 60);
        for format in ["ascii", "binary", "raw", "base64"] {
            for zlib in [None, Some(1), Some(56), Some(1 << 15)] {
                for (wide, big) in [(false, false), (true, true)] {
                    let vti = Vti {
                        zlib,
                        wide,
                        big,
                        ..Vti::new(scalar_type, format)
                    };
                    let volume = load(&vti.file("0 2 0 3 0 4", &vti.data(&v)));
                    assert_eq!(volume.grid.dims, UVec3::new(3, 4, 5), "{vti:?}");
                    assert_eq!(stored(&volume), v, "{vti:?}");
                }
            }
        }
    }
}

#[test]
fn base64_may_be_broken_into_lines_and_padded_after_the_header() {
    let vti = Vti::new(ScalarType::U8, "binary");
    let v = values(ScalarType::U8, 60);
    let encode = |b: &[u8]| base64::Engine::encode(&base64::prelude::BASE64_STANDARD, b);
    let raw = payload(&v, ScalarType::U8, false, Encoding::Raw);
    let text = format!("  {}\n{}  \n", encode(&vti.words(&[60])), encode(&raw));
    let (a, b) = text.split_at(31);
    let broken = format!("{a}\r\n\t{b}");
    assert_eq!(
        stored(&load(&vti.file("0 2 0 3 0 4", broken.as_bytes()))),
        v
    );
}

#[test]
fn points_are_voxel_centres_counted_from_the_origin() {
    let vti = Vti::new(ScalarType::U8, "ascii");
    let data = vti.data(&values(ScalarType::U8, 60));
    // x points along the world's y, y along -x; the first point is (10, 20, -3).
    let image = "Origin=\"1 2 3\" Spacing=\"2 3 0.5\" Direction=\"0 -1 0 1 0 0 0 0 1\"";
    let grid = load(&vti.file_with("10 12 20 23 -3 1", image, "PointData", &data)).grid;
    let at = |i: DVec3| grid.world_from_index.transform_point3(i);
    let first = DVec3::new(1.0 - 20.0 * 3.0, 2.0 + 10.0 * 2.0, 3.0 - 3.0 * 0.5);
    assert_eq!(at(DVec3::ZERO), first);
    assert_eq!(at(DVec3::X) - first, DVec3::new(0.0, 2.0, 0.0));
    assert_eq!(at(DVec3::Y) - first, DVec3::new(-3.0, 0.0, 0.0));
    assert_eq!(at(DVec3::Z) - first, DVec3::new(0.0, 0.0, 0.5));
    assert_eq!(grid.space, Space::Unspecified);
}

#[test]
fn cells_lie_between_the_points() {
    let vti = Vti::new(ScalarType::U8, "ascii");
    let data = vti.data(&values(ScalarType::U8, 60));
    let image = "Origin=\"5 0 0\" Spacing=\"2 2 2\"";
    let volume = load(&vti.file_with("1 4 0 4 0 5", image, "CellData", &data));
    assert_eq!(volume.grid.dims, UVec3::new(3, 4, 5));
    let first = volume.grid.world_from_index.translation;
    assert_eq!(first, DVec3::new(5.0 + 1.5 * 2.0, 1.0, 1.0));
    // A flat image has one layer of cells, in its plane.
    let flat = load(&vti.file_with("0 60 0 1 3 3", image, "CellData", &data));
    assert_eq!(flat.grid.dims, UVec3::new(60, 1, 1));
    let first = flat.grid.world_from_index.translation;
    assert_eq!(first, DVec3::new(6.0, 1.0, 6.0));
}

/// An image of 2 x 2 x 2 points with these arrays.
fn with_arrays(points: &str) -> Vec<u8> {
    format!(
        "<VTKFile type=\"ImageData\"><ImageData WholeExtent=\"0 1 0 1 0 1\"><Piece Extent=\"0 1 0 1 0 1\">\
         {points}</Piece></ImageData></VTKFile>"
    )
    .into_bytes()
}

fn array(name: &str, components: u32, first: u32) -> String {
    let numbers: Vec<_> = (0..8 * components)
        .map(|i| (first + i).to_string())
        .collect();
    format!(
        "<DataArray type=\"Int16\" Name=\"{name}\" NumberOfComponents=\"{components}\" format=\"ascii\">{}\
         </DataArray>",
        numbers.join(" ")
    )
}

#[test]
fn the_active_scalars_or_the_first_array_of_one_component_is_taken() {
    let three = [array("v", 3, 0), array("a", 1, 30), array("b", 1, 60)].concat();
    let first = |points: String| stored(&load(&with_arrays(&points)))[0];
    let points = |attributes: &str| format!("<PointData {attributes}>{three}</PointData>");
    assert_eq!(first(points("Scalars=\"b\"")), 60.0);
    assert_eq!(first(points("")), 30.0);
    assert_eq!(first(points("Scalars=\"v\"")), 30.0);
    assert_eq!(first(points("Scalars=\"gone\"")), 30.0);
    let fields = format!("<FieldData>{}</FieldData>", array("f", 1, 90));
    let both = format!(
        "{fields}<CellData>{}</CellData>{}",
        array("c", 1, 99),
        points("")
    );
    assert_eq!(first(both), 30.0);
    let none = format!("<PointData>{}</PointData><CellData/>", array("v", 3, 0));
    let words = ["v of 3 components", "one component"];
    refused("a.vti", &[&with_arrays(&none)], &words);
    refused("a.vti", &[&with_arrays("")], &["no array"]);
}

#[test]
fn wrong_headers_are_named() {
    let vti = Vti::new(ScalarType::I16, "ascii");
    let good = vti.file("0 2 0 3 0 4", &vti.data(&values(ScalarType::I16, 60)));
    let good = String::from_utf8(good).unwrap();
    let cases = [
        (
            "type=\"ImageData\"",
            "type=\"PolyData\"",
            "VTKFile type: found \"PolyData\", expected ImageData",
        ),
        ("LittleEndian", "MiddleEndian", "byte_order"),
        ("UInt32", "UInt16", "header_type"),
        (
            "UInt32\"",
            "UInt32\" compressor=\"vtkLZ4DataCompressor\"",
            "vtkLZ4DataCompressor",
        ),
        ("WholeExtent=\"0 2", "WholeExtent=\"0 -2", "WholeExtent"),
        ("WholeExtent=\"0 2", "WholeExtent=\"2", "6 whole numbers"),
        (
            "Piece Extent=\"0 2",
            "Piece Extent=\"0 1",
            "the whole extent, \"0 2 0 3 0 4\"",
        ),
        ("Spacing=\"1 1 1\"", "Spacing=\"1 0 1\"", "Spacing"),
        ("Spacing=\"1 1 1\"", "Spacing=\"1 1\"", "3 numbers"),
        ("Spacing=\"1 1 1\"", "Origin=\"nan 0 0\"", "Origin"),
        (
            "Spacing=\"1 1 1\"",
            "Direction=\"1 0 0 1 0 0 0 0 1\"",
            "Direction",
        ),
        (
            "type=\"Int16\"",
            "type=\"Int64\"",
            "DataArray type: found \"Int64\"",
        ),
        (
            "format=\"ascii\"",
            "format=\"hex\"",
            "ascii, binary or appended",
        ),
        ("format=\"ascii\"", "format=\"appended\"", "AppendedData"),
        ("<Piece", "<Piece/><Piece", "2 pieces"),
        ("<VTKFile", "<VTKfile", "XML"),
    ];
    for (from, to, word) in cases {
        assert!(good.contains(from), "{from}");
        refused("a.vti", &[good.replacen(from, to, 1).as_bytes()], &[word]);
    }
    let raw = Vti::new(ScalarType::I16, "raw");
    let file = raw.file("0 2 0 3 0 4", &raw.data(&values(ScalarType::I16, 59)));
    refused("a.vti", &[&file], &["an array of 118 bytes", "120 bytes"]);
    let file = String::from_utf8_lossy(&file).replace("offset=\"0\"", "offset=\"9999\"");
    refused("a.vti", &[file.as_bytes()], &["offset", "9999"]);
}

#[test]
fn the_format_is_known_by_what_is_in_it() {
    let dir = TempDir::new().unwrap();
    let vti = Vti::new(ScalarType::U8, "raw");
    let file = vti.file("0 2 0 3 0 4", &vti.data(&values(ScalarType::U8, 60)));
    let path = write(dir.path(), "noname", &[&file]);
    let header = read_header(&path, &ReadOptions::default()).unwrap();
    assert_eq!((header.format, header.time_steps), (Format::Vti, 1));
    let later = ReadOptions { raw: None, time: 1 };
    let message = read_header(&path, &later).unwrap_err().to_string();
    assert!(message.contains("time step 1"), "{message}");
}
