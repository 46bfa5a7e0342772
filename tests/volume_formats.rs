//! Every format, type, byte order and encoding read back from files written by hand.

#![allow(clippy::unwrap_used, clippy::panic)]

mod volume_files;

use std::path::Path;

use glam::{DMat3, DQuat, DVec3, UVec3};
use tempfile::TempDir;
use tyndall::volume::{
    Format, RawLayout, ReadOptions, Rescale, ScalarType, Space, Volume, read, read_header,
};
use volume_files::{Encoding, Nifti, compress, meta_type, nrrd_type, payload, values, write};

const DIMS: [u32; 3] = [3, 4, 5];
const SPACING: DVec3 = DVec3::new(0.5, 1.25, 3.0);
const ORIGIN: DVec3 = DVec3::new(-10.0, 20.5, 1024.0);

fn load(path: &Path, options: &ReadOptions) -> Volume {
    let mut last = (0, 1);
    let volume = read(path, options, &mut |done, all| {
        assert!(done > last.0 && done <= all, "progress goes back");
        last = (done, all);
    });
    let volume = volume.unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(last.0, last.1, "the last report is the whole");
    let header = read_header(path, options).unwrap();
    assert_eq!(header.grid, volume.grid);
    assert_eq!(header.scalar_type, volume.voxels.scalar_type());
    assert_eq!(header.rescale, volume.rescale);
    volume
}

fn load_plain(path: &Path) -> Volume {
    load(path, &ReadOptions::default())
}

fn error(path: &Path, options: &ReadOptions) -> String {
    read(path, options, &mut |_, _| {}).unwrap_err().to_string()
}

#[track_caller]
fn check(volume: &Volume, t: ScalarType, expected: &[f64], origin: DVec3) {
    assert_eq!(volume.voxels.scalar_type(), t);
    assert_eq!(volume.grid.dims, UVec3::from_array(DIMS));
    assert_eq!(volume.grid.spacing(), SPACING);
    assert_eq!(volume.grid.world_from_index.translation, origin);
    let found: Vec<f64> = (0..volume.voxels.len())
        .map(|i| volume.voxels.get(i))
        .collect();
    assert_eq!(found, expected);
}

fn nrrd_header(t: ScalarType, big: bool, encoding: &str, more: &str) -> String {
    let endian = if big { "big" } else { "little" };
    format!(
        "NRRD0005\n# a comment: with a colon\ntype: {}\ndimension: 3\nsizes: 3 4 5\n\
         space dimension: 3\nspace directions: (0.5,0,0) (0, 1.25, 0) (0,0,3)\n\
         space origin: (-10,20.5,1024)\nspace units: \"mm\" \"mm\" \"mm\"\n\
         my key:=some: value\nendian: {endian}\nencoding: {encoding}\n{more}",
        nrrd_type(t)
    )
}

#[test]
fn nrrd_reads_every_type_order_and_encoding() {
    let dir = TempDir::new().unwrap();
    for t in ScalarType::ALL {
        let v = values(t, 60);
        for big in [false, true] {
            for (encoding, name) in [
                (Encoding::Raw, "raw"),
                (Encoding::Gzip, "gzip"),
                (Encoding::Bzip2, "bz2"),
                (Encoding::Text, "ascii"),
            ] {
                let data = payload(&v, t, big, encoding);
                let attached = nrrd_header(t, big, name, "\n");
                let path = write(dir.path(), "a.nrrd", &[attached.as_bytes(), &data, b" "]);
                check(&load_plain(&path), t, &v, ORIGIN);

                write(dir.path(), "some voxels.dat", &[&data]);
                let detached = nrrd_header(t, big, name, "data file: some voxels.dat\n");
                let path = write(dir.path(), "a.nhdr", &[detached.as_bytes()]);
                let volume = load_plain(&path);
                check(&volume, t, &v, ORIGIN);
                assert_eq!(volume.spatial_unit.as_deref(), Some("mm"));
            }
        }
    }
}

#[test]
fn nrrd_skips_lines_and_bytes() {
    let dir = TempDir::new().unwrap();
    let t = ScalarType::I16;
    let v = values(t, 60);
    let raw = payload(&v, t, true, Encoding::Raw);
    write(dir.path(), "v.raw", &[b"one\ntwo\nabc", &raw]);
    for more in [
        "line skip: 2\nbyte skip: 3\n",
        "byteskip: 11\n",
        "byte skip: -1\n",
    ] {
        let text = nrrd_header(t, true, "raw", &format!("{more}datafile: v.raw\n"));
        let crlf = text.replace('\n', "\r\n");
        let path = write(dir.path(), "a.nhdr", &[crlf.as_bytes()]);
        check(&load_plain(&path), t, &v, ORIGIN);
    }
    // Lines are skipped before, bytes after decompression.
    let packed = compress(&[b"abc".as_slice(), &raw].concat(), Encoding::Gzip);
    let text = nrrd_header(t, true, "gzip", "line skip: 1\nbyte skip: 3\n\n");
    let path = write(dir.path(), "a.nrrd", &[text.as_bytes(), b"line\n", &packed]);
    check(&load_plain(&path), t, &v, ORIGIN);
}

#[test]
fn nrrd_places_axes_without_directions() {
    let dir = TempDir::new().unwrap();
    let place = |fields: &str| {
        let text = format!(
            "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 2 2\nencoding: raw\n{fields}\n\n"
        );
        let path = write(dir.path(), "a.nrrd", &[text.as_bytes(), &[0; 8]]);
        load_plain(&path).grid
    };
    let grid = place("spacings: 1 2 3");
    assert_eq!(grid.spacing(), DVec3::new(1.0, 2.0, 3.0));
    assert_eq!(grid.world_from_index.translation, DVec3::ZERO);
    assert_eq!(grid.space, Space::Unspecified);
    let grid = place("spacings: 1 2 3\naxis mins: 5 6 7\ncenterings: cell node ???");
    let origin = DVec3::new(5.5, 6.0, 7.0);
    assert_eq!(grid.world_from_index.translation, origin);
    let grid = place("axis mins: 0 0 0\naxis maxs: 4 4 4\ncenterings: cell node node");
    assert_eq!(grid.spacing(), DVec3::new(2.0, 4.0, 4.0));
    let grid = place("space: LPS\nspacings: 1 2 3\nspace origin: (1,2,3)");
    let origin = DVec3::new(-1.0, -2.0, 3.0);
    assert_eq!(grid.world_from_index.translation, origin);
    assert_eq!(grid.space, Space::PatientRas);
    assert_eq!(
        place("spacings: 1 1 1\nunits: \"um\" \"um\" \"um\"").spacing(),
        DVec3::ONE
    );
}

fn meta_header(t: ScalarType, fields: &str, data: &str) -> String {
    format!(
        "ObjectType = Image\nNDims = 3\n{fields}\nComment = a = b\nComment = c\nOffset = -10 20.5 1024\n\
         ElementSpacing = 0.5 1.25 3\nDimSize = 3 4 5\nElementType = {}\n\
         ElementDataFile = {data}\n",
        meta_type(t)
    )
}

#[test]
fn meta_image_reads_every_type_order_and_encoding() {
    let dir = TempDir::new().unwrap();
    for t in ScalarType::ALL {
        let v = values(t, 60);
        for (big, order) in [
            (false, "BinaryDataByteOrderMSB = False"),
            (true, "BinaryDataByteOrderMSB = True"),
            (true, "ElementByteOrderMSB = True"),
        ] {
            for (encoding, how) in [
                (Encoding::Raw, "CompressedData = False"),
                (Encoding::Zlib, "BinaryData = True\nCompressedData = True"),
                (Encoding::Text, "BinaryData = False"),
            ] {
                let data = payload(&v, t, big, encoding);
                let fields = format!("{order}\n{how}\nDistanceUnits = um");
                let local = meta_header(t, &fields, "LOCAL");
                let path = write(dir.path(), "a.mha", &[local.as_bytes(), &data]);
                let volume = load_plain(&path);
                check(&volume, t, &v, ORIGIN);
                assert_eq!(volume.spatial_unit.as_deref(), Some("um"));

                write(dir.path(), "v.zraw", &[&data]);
                let detached = meta_header(t, &fields, "v.zraw");
                let path = write(dir.path(), "a.mhd", &[detached.as_bytes()]);
                check(&load_plain(&path), t, &v, ORIGIN);
            }
        }
    }
}

#[test]
fn meta_image_header_size_and_synonyms() {
    let dir = TempDir::new().unwrap();
    let t = ScalarType::U16;
    let v = values(t, 60);
    let data = payload(&v, t, false, Encoding::Raw);
    write(dir.path(), "v.raw", &[b"12345", &data]);
    for size in ["5", "-1"] {
        let text = meta_header(t, &format!("HeaderSize = {size}"), "v.raw")
            .replace("Offset", "Position")
            .replace("ElementSpacing", "ElementSize");
        let path = write(dir.path(), "a.mhd", &[text.as_bytes()]);
        check(&load_plain(&path), t, &v, ORIGIN);
    }
}

#[test]
fn nifti_reads_every_type_order_and_container() {
    let dir = TempDir::new().unwrap();
    for t in ScalarType::ALL {
        let v = values(t, 60);
        for big in [false, true] {
            let data = payload(&v, t, big, Encoding::Raw);
            let mut h = Nifti::new(&[3, 4, 5], t, big);
            h.floats(76, &[1.0, 0.5, 1.25, 3.0]);
            h.bytes[123] = 10;
            let path = write(dir.path(), "a.nii", &[&h.bytes, &data, b"more"]);
            check(&load_plain(&path), t, &v, DVec3::ZERO);

            let whole = [h.bytes.as_slice(), &data].concat();
            let packed = compress(&whole, Encoding::Gzip);
            let path = write(dir.path(), "a.nii.gz", &[&packed]);
            let volume = load_plain(&path);
            check(&volume, t, &v, DVec3::ZERO);
            assert_eq!(volume.spatial_unit.as_deref(), Some("mm"));
            assert_eq!(volume.grid.space, Space::Unspecified);

            h.bytes[344..348].copy_from_slice(b"ni1\0");
            h.floats(108, &[0.0]);
            write(dir.path(), "p.img", &[&data]);
            let path = write(dir.path(), "p.hdr", &[&h.bytes]);
            check(&load_plain(&path), t, &v, DVec3::ZERO);
        }
    }
}

#[test]
fn nifti_rescales() {
    let dir = TempDir::new().unwrap();
    let rescale = |slope: f32, intercept: f32| {
        let mut h = Nifti::new(&[1, 1, 2], ScalarType::I16, true);
        h.floats(112, &[slope, intercept]);
        let data = payload(&[-3.0, 7.0], ScalarType::I16, true, Encoding::Raw);
        let path = write(dir.path(), "a.nii", &[&h.bytes, &data]);
        load_plain(&path)
    };
    let volume = rescale(2.5, -1000.0);
    assert_eq!((volume.value(0), volume.value(1)), (-1007.5, -982.5));
    assert_eq!(rescale(0.0, 5.0).rescale, Rescale::IDENTITY);
    assert_eq!(rescale(f32::NAN, f32::NAN).rescale, Rescale::IDENTITY);
}

#[test]
fn a_time_step_is_picked_out() {
    let dir = TempDir::new().unwrap();
    let t = ScalarType::F32;
    let v: Vec<f64> = (0..24).map(f64::from).collect();
    let at = |time| ReadOptions { raw: None, time };
    let data = payload(&v, t, false, Encoding::Raw);
    let h = Nifti::new(&[2, 2, 2, 3], t, false);
    let whole = [h.bytes.as_slice(), &data].concat();
    let nrrd = "NRRD0004\ntype: float\ndimension: 4\nsizes: 2 2 2 3\nendian: little\n\
                kinds: domain domain domain list\nspace: RAS\nspace origin: (0,0,0)\n\
                space directions: (1,0,0) (0,1,0) (0,0,1) none\n";
    let text = payload(&v, t, false, Encoding::Text);
    let gz = compress(&data, Encoding::Gzip);
    let nrrd_raw = format!("{nrrd}encoding: raw\n\n");
    let nrrd_gz = format!("{nrrd}encoding: gzip\n\n");
    let nrrd_text = format!("{nrrd}encoding: text\n\n");
    let files = [
        write(dir.path(), "a.nii", &[&whole]),
        write(dir.path(), "a.nii.gz", &[&compress(&whole, Encoding::Gzip)]),
        write(dir.path(), "r.nrrd", &[nrrd_raw.as_bytes(), &data]),
        write(dir.path(), "g.nrrd", &[nrrd_gz.as_bytes(), &gz]),
        write(dir.path(), "t.nrrd", &[nrrd_text.as_bytes(), &text]),
    ];
    for path in files {
        assert_eq!(read_header(&path, &at(0)).unwrap().time_steps, 3);
        for time in 0..3 {
            let volume = load(&path, &at(time));
            assert_eq!(volume.voxels.len(), 8);
            let first = f64::from(time) * 8.0;
            assert_eq!((volume.value(0), volume.value(7)), (first, first + 7.0));
        }
        let message = error(&path, &at(3));
        assert!(message.contains("0 to 2"), "{message}");
    }
}

#[test]
fn nrrd_with_several_values_a_voxel_is_refused() {
    let dir = TempDir::new().unwrap();
    let text = "NRRD0004\ntype: uchar\ndimension: 4\nsizes: 3 2 2 2\nencoding: raw\n\
                kinds: RGB-color domain domain domain\n\n";
    let path = write(dir.path(), "rgb.nrrd", &[text.as_bytes(), &[0; 24]]);
    let message = error(&path, &ReadOptions::default());
    assert!(
        message.contains("kinds") && message.contains("slowest"),
        "{message}"
    );
}

#[test]
fn raw_reads_every_type_order_and_skip() {
    let dir = TempDir::new().unwrap();
    for scalar_type in ScalarType::ALL {
        let v = values(scalar_type, 60);
        for big_endian in [false, true] {
            for skip_bytes in [0, 7] {
                let skip = vec![9; skip_bytes as usize];
                let data = payload(&v, scalar_type, big_endian, Encoding::Raw);
                let whole = [skip, data].concat();
                let options = ReadOptions {
                    raw: Some(RawLayout {
                        dims: DIMS,
                        scalar_type,
                        spacing: SPACING.to_array(),
                        big_endian,
                        skip_bytes,
                    }),
                    time: 0,
                };
                let path = write(dir.path(), "a.raw", &[&whole]);
                check(&load(&path, &options), scalar_type, &v, DVec3::ZERO);
                let packed = compress(&whole, Encoding::Gzip);
                let path = write(dir.path(), "a.raw.gz", &[&packed]);
                check(&load(&path, &options), scalar_type, &v, DVec3::ZERO);
            }
        }
    }
}

#[test]
fn raw_without_a_layout_says_what_to_give() {
    let dir = TempDir::new().unwrap();
    let path = write(dir.path(), "a.raw", &[&[1, 2, 3]]);
    let message = error(&path, &ReadOptions::default());
    for word in [
        "a.raw",
        "--dims X,Y,Z",
        "--type u8|",
        "--spacing",
        "--endian",
    ] {
        assert!(message.contains(word), "{message}");
    }
}

#[test]
fn format_follows_the_first_bytes_before_the_name() {
    let dir = TempDir::new().unwrap();
    let t = ScalarType::U8;
    let v = values(t, 60);
    let text = nrrd_header(t, false, "raw", "\n");
    let path = write(
        dir.path(),
        "a.mha",
        &[text.as_bytes(), &payload(&v, t, false, Encoding::Raw)],
    );
    let header = read_header(&path, &ReadOptions::default()).unwrap();
    assert_eq!(header.format, Format::Nrrd);
}

#[test]
fn nan_and_infinite_voxels_and_concatenated_gzip_survive() {
    let dir = TempDir::new().unwrap();
    let t = ScalarType::F32;
    let mut v = values(t, 60);
    v[3] = f64::NAN;
    v[4] = f64::NEG_INFINITY;
    let raw = payload(&v, t, true, Encoding::Raw);
    for (encoding, name) in [(Encoding::Gzip, "gzip"), (Encoding::Bzip2, "bzip2")] {
        let text = nrrd_header(t, true, name, "\n");
        let (a, b) = raw.split_at(101);
        let (a, b) = (compress(a, encoding), compress(b, encoding));
        let path = write(dir.path(), "a.nrrd", &[text.as_bytes(), &a, &b, b"garbage"]);
        let volume = load_plain(&path);
        assert!(volume.value(3).is_nan());
        assert_eq!(volume.value(4), f64::NEG_INFINITY);
        assert_eq!(volume.value(59), v[59]);
    }
}

/// One oblique, anisotropic grid in RAS, written in every way the formats know.
#[test]
fn an_oblique_landmark_lies_at_one_place_in_all_formats() {
    let dir = TempDir::new().unwrap();
    let rotation = DQuat::from_euler(glam::EulerRot::ZYX, 0.4, -0.3, 0.7);
    let m = DMat3::from_quat(rotation);
    let spacing = DVec3::new(0.5, 0.75, 2.25);
    let origin = DVec3::new(-81.0, 12.5, 340.0);
    let columns = [
        m.x_axis * spacing.x,
        m.y_axis * spacing.y,
        m.z_axis * spacing.z,
    ];
    let landmark = UVec3::new(2, 1, 3);
    let world = origin + columns[0] * 2.0 + columns[1] + columns[2] * 3.0;
    let mut data = vec![0u8; 60];
    data[2 + 3 * (1 + 4 * 3)] = 200;

    let mut sform = Nifti::new(&[3, 4, 5], ScalarType::U8, false);
    sform.i16(254, 1);
    for row in 0..3 {
        let r = [
            columns[0][row],
            columns[1][row],
            columns[2][row],
            origin[row],
        ];
        sform.floats(280 + 16 * row, &r.map(|v| v as f32));
    }
    let mut qform = Nifti::new(&[3, 4, 5], ScalarType::U8, true);
    qform.i16(252, 1);
    qform.floats(76, &[1.0, 0.5, 0.75, 2.25]);
    let q = if rotation.w < 0.0 {
        -rotation
    } else {
        rotation
    };
    qform.floats(256, &[q.x, q.y, q.z].map(|v| v as f32));
    qform.floats(268, &origin.to_array().map(|v| v as f32));

    let nrrd = |space: &str, flip: DVec3| {
        let vector = |v: DVec3| format!("({},{},{})", v.x, v.y, v.z);
        let d = columns.map(|c| vector(c * flip)).join(" ");
        format!(
            "NRRD0005\ntype: uint8\ndimension: 3\nsizes: 3 4 5\nencoding: raw\nspace: {space}\n\
             space directions: {d}\nspace origin: {}\n\n",
            vector(origin * flip)
        )
    };
    let lps = DVec3::new(-1.0, -1.0, 1.0);
    let las = DVec3::new(-1.0, 1.0, 1.0);
    let numbers = |v: DVec3| format!("{} {} {}", v.x, v.y, v.z);
    let cosines = [m.x_axis, m.y_axis, m.z_axis].map(|c| numbers(c * lps));
    let meta = format!(
        "ObjectType = Image\nNDims = 3\nTransformMatrix = {}\nOffset = {}\n\
         AnatomicalOrientation = RAI\nElementSpacing = {}\nDimSize = 3 4 5\n\
         ElementType = MET_UCHAR\nElementDataFile = LOCAL\n",
        cosines.join(" "),
        numbers(origin * lps),
        numbers(spacing)
    );
    let files = [
        ("s.nii", sform.bytes),
        ("q.nii", qform.bytes),
        (
            "lps.nrrd",
            nrrd("left-posterior-superior", lps).into_bytes(),
        ),
        ("ras.nrrd", nrrd("RAS", DVec3::ONE).into_bytes()),
        ("las.nrrd", nrrd("left-anterior-superior", las).into_bytes()),
        ("m.mha", meta.into_bytes()),
    ];
    for (name, header) in files {
        let path = write(dir.path(), name, &[&header, &data]);
        let volume = load_plain(&path);
        let grid = &volume.grid;
        let found = grid.world_from_index.transform_point3(landmark.as_dvec3());
        assert!(
            found.distance(world) < 1e-4,
            "{name}: {found} is not {world}"
        );
        assert!(grid.spacing().distance(spacing) < 1e-6, "{name}");
        assert_eq!(grid.space, Space::PatientRas, "{name}");
        assert_eq!(volume.value(grid.linear_index(landmark)), 200.0, "{name}");
    }
}

#[test]
fn nifti_mirrors_by_qfac_and_takes_an_unset_pixdim_as_one() {
    let dir = TempDir::new().unwrap();
    let mut h = Nifti::new(&[1, 1, 1], ScalarType::U8, false);
    h.i16(252, 1);
    h.floats(76, &[-1.0, 2.0, 0.0, 4.0]);
    let path = write(dir.path(), "a.nii", &[&h.bytes, &[0]]);
    let m = load_plain(&path).grid.world_from_index.matrix3;
    assert_eq!(m, DMat3::from_diagonal(DVec3::new(2.0, 1.0, -4.0)));
}

#[test]
fn meta_image_without_orientation_keeps_its_axes() {
    let dir = TempDir::new().unwrap();
    for (orientation, space) in [("???", Space::Unspecified), ("LPI", Space::PatientRas)] {
        let fields = format!("AnatomicalOrientation = {orientation}");
        let text = meta_header(ScalarType::U8, &fields, "LOCAL");
        let path = write(dir.path(), "a.mha", &[text.as_bytes(), &[0; 60]]);
        assert_eq!(load_plain(&path).grid.space, space);
    }
}
