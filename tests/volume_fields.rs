//! Every bad header field gives a message that names file, field, what was found and expected.

#![allow(clippy::unwrap_used)]

mod volume_files;

use tempfile::TempDir;
use tyndall::volume::{ReadOptions, ScalarType};
use volume_files::{Nifti, error_with, good_meta, nrrd, refused, write};

const T: ScalarType = ScalarType::I16;

/// Field, value (none: the field is missing) and a part of what the message expects instead.
const BAD_NRRD: [(&str, &str, &str); 30] = [
    ("type", "long long", "uint8"),
    ("type", "", "uint8"),
    ("dimension", "2", "3, or 4"),
    ("dimension", "", "3, or 4"),
    ("sizes", "3 -4 5", "3 positive sizes"),
    ("sizes", "3 0 5", "3 positive sizes"),
    ("sizes", "3 4", "3 positive sizes"),
    ("sizes", "4294967295 4294967295 4294967295", "2^63 bytes"),
    ("endian", "middle", "little or big"),
    ("endian", "", "little or big"),
    ("encoding", "hex", "bzip2"),
    ("encoding", "", "bzip2"),
    ("spacings", "1 NaN 1", "finite"),
    ("spacings", "1 0 1", "other than 0"),
    ("spacings", "1 1", "3 numbers"),
    ("space", "left-up", "left-posterior-superior"),
    ("space", "left-posterior-superior-time", "LPS"),
    ("space directions", "(1,0,0) (0,1,0) (0,0,nan)", "finite"),
    ("space directions", "(1,0,0) (1,0,0) (0,0,1)", "independent"),
    ("space directions", "(1,0,0) (0,0,0) (0,0,1)", "not 0"),
    ("space directions", "(1,0,0) (0,1,0)", "3 entries"),
    (
        "space directions",
        "(1,0,0) (0,1,0) none",
        "each of the 3 axes",
    ),
    ("space origin", "(1,inf,0)", "finite"),
    ("space origin", "1 2 3", "(x,y,z)"),
    ("space units", "\"mm\" \"um\" \"mm\"", "one unit"),
    ("centerings", "cell", "3 of cell"),
    ("byte skip", "-2", "a number of bytes"),
    ("line skip", "99999999999", "at most the lines"),
    ("data file", "LIST", "one file"),
    ("data file", "I.%03d 1 99 1", "one file"),
];

#[test]
fn bad_nrrd_fields_are_named() {
    let with = |key: &str, value: &str| {
        let mut fields = vec![
            ("type", "short"),
            ("dimension", "3"),
            ("sizes", "3 4 5"),
            ("endian", "little"),
            ("encoding", "raw"),
        ];
        fields.retain(|(k, _)| *k != key);
        fields.push((key, value));
        let lines = fields.iter().filter(|(_, v)| !v.is_empty());
        let lines: Vec<String> = lines.map(|(k, v)| format!("{k}: {v}")).collect();
        nrrd(&lines.join("\n"))
    };
    for (key, value, expected) in BAD_NRRD {
        let header = with(key, value);
        let found = format!("{value:?}");
        let found = if value.is_empty() {
            "no such field"
        } else {
            found.as_str()
        };
        // The world's fields report the numbers they led to instead of the text.
        let words = match key {
            "spacings" | "space directions" | "space origin" => vec![key, expected],
            _ if expected == "2^63 bytes" => vec![key, "4294967295 × ", expected],
            _ => vec![key, found, expected],
        };
        refused("a.nrrd", &[header.as_bytes(), &[0; 10]], &words);
    }
    let twice = nrrd("type: short\ntype: float");
    refused(
        "a.nrrd",
        &[twice.as_bytes()],
        &["type", "both", "one value"],
    );
    refused("a.nrrd", &[b"NRRD0004\nhello\n"], &["header line", "hello"]);
    let open_end = with("encoding", "raw");
    let open_end = open_end.trim_end().as_bytes();
    refused(
        "a.nrrd",
        &[open_end],
        &["header", "end of the file", "blank line"],
    );
}

/// A part of the good header, what replaces it, and what the message has: field, found, expected.
const BAD_META: [(&str, &str, [&str; 3]); 15] = [
    ("NDims = 3", "NDims = 4", ["NDims", "\"4\"", "3"]),
    (
        "ObjectType = Image",
        "ObjectType = Tube",
        ["ObjectType", "Tube", "Image"],
    ),
    (
        "DimSize = 3 4 5",
        "DimSize = 3 -4 5",
        ["DimSize", "3 × -4 × 5", "sizes from 1"],
    ),
    (
        "DimSize = 3 4 5",
        "",
        ["DimSize", "no such field", "3 positive sizes"],
    ),
    (
        "MET_SHORT",
        "MET_STRING",
        ["ElementType", "MET_STRING", "MET_UCHAR"],
    ),
    ("1 1 2.5", "1 nan 2.5", ["ElementSpacing", "NaN", "finite"]),
    (
        "1 1 2.5",
        "1 0 2.5",
        ["ElementSpacing", "1 0 2.5", "other than 0"],
    ),
    ("= 1 2 3", "= 1 2", ["Offset", "\"1 2\"", "3 numbers"]),
    ("= 1 2 3", "= 1 inf 3", ["Offset", "inf", "finite"]),
    (
        "1 0 0 0 1",
        "0 1 0 0 1",
        ["TransformMatrix", "directions", "independent"],
    ),
    ("LOCAL", "LIST", ["ElementDataFile", "LIST", "one file"]),
    (
        "LOCAL",
        "i%03d.raw 1 9 1",
        ["ElementDataFile", "%03d", "one file"],
    ),
    (
        "MSB = False",
        "MSB = maybe",
        ["MSB", "maybe", "True or False"],
    ),
    (
        "NDims = 3",
        "NDims = 3\nElementNumberOfChannels = 3",
        ["ElementNumberOfChannels", "\"3\"", "1 channel"],
    ),
    (
        "NDims = 3",
        "NDims = 3\nHeaderSize = -2",
        ["HeaderSize", "-2", "a number of bytes"],
    ),
];

#[test]
fn bad_meta_image_fields_are_named() {
    for (from, to, words) in BAD_META {
        let header = good_meta("", "LOCAL").replacen(from, to, 1);
        refused("a.mha", &[header.as_bytes(), &[0; 120]], &words);
    }
    let header = good_meta("", "absent.raw");
    let dir = TempDir::new().unwrap();
    let path = write(dir.path(), "a.mhd", &[header.as_bytes()]);
    let message = error_with(&path, &ReadOptions::default());
    assert!(message.contains("absent.raw: cannot open"), "{message}");
}

#[test]
fn bad_nifti_fields_are_named() {
    type Edit = fn(&mut Nifti);
    let cases: [(Edit, [&str; 3]); 13] = [
        (|h| h.i16(40, 9), ["dim[0]", "9", "1 to 7"]),
        (
            |h| h.i16(44, -4),
            ["dim[1..3]", "3 × -4 × 5", "sizes from 1"],
        ),
        (|h| h.i16(42, 0), ["dim[1..3]", "0 × 4 × 5", "sizes from 1"]),
        (
            |h| {
                h.i16(40, 5);
                h.i16(50, 3);
            },
            ["dim[5]", "3", "one value"],
        ),
        (
            |h| {
                h.i16(40, 4);
                h.i16(48, -2);
            },
            ["dim[4]", "-2", "positive"],
        ),
        (|h| h.i16(70, 128), ["datatype", "RGB24", "2 (u8)"]),
        (
            |h| h.floats(80, &[f32::NAN]),
            ["pixdim[1]", "NaN", "finite"],
        ),
        (
            |h| h.floats(108, &[-5.0]),
            ["vox_offset", "-5", "at least 348"],
        ),
        (
            |h| h.floats(108, &[1e30]),
            ["vox_offset", "1000000000", "whole number"],
        ),
        (
            |h| h.floats(112, &[f32::INFINITY]),
            ["scl_slope", "inf", "finite"],
        ),
        (
            |h| h.floats(116, &[f32::NAN]),
            ["scl_inter", "NaN", "finite"],
        ),
        (|h| h.i16(254, 1), ["srow_x", "directions", "not 0"]),
        (
            |h| {
                h.i16(252, 1);
                h.floats(256, &[2.0]);
            },
            ["quatern_b", "2", "unit"],
        ),
    ];
    for (edit, words) in cases {
        let mut h = Nifti::new(&[3, 4, 5], T, false);
        edit(&mut h);
        refused("a.nii", &[&h.bytes, &[0; 120]], &words);
    }
    let mut h = Nifti::new(&[3, 4, 5], T, false);
    h.bytes[344..348].copy_from_slice(b"ni1\0");
    refused("a.nii", &[&h.bytes], &["file name", "a.nii", ".hdr"]);
}
