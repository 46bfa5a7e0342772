//! Files that lie, stop short or are no volumes at all: one clear error each, at once.

#![allow(clippy::unwrap_used, clippy::panic)]

mod volume_files;

use std::time::Instant;

use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::{Rng, SeedableRng};
use tempfile::TempDir;
use tyndall::volume::{RawLayout, ReadOptions, ScalarType, read, read_header};
use volume_files::{
    Encoding, Nifti, Vti, WATCHDOG, compress, error_with, good_meta, nrrd, payload, refused,
    values, write,
};

const T: ScalarType = ScalarType::I16;

fn layout(dims: [u32; 3]) -> Option<RawLayout> {
    Some(RawLayout {
        dims,
        scalar_type: T,
        spacing: [1.0; 3],
        big_endian: false,
        skip_bytes: 0,
    })
}

fn good_nrrd(encoding: &str) -> String {
    nrrd(&format!(
        "# comment\ntype: short\ndimension: 3\nspace: LPS\nsizes: 3 4 5\nendian: little\n\
         space directions: (1,0,0) (0,1,0) (0,0,2.5)\nspace origin: (1,2,3)\nencoding: {encoding}"
    ))
}

/// A valid VTK image file.
fn vti(format: &'static str, zlib: Option<usize>) -> Vec<u8> {
    let vti = Vti {
        zlib,
        ..Vti::new(T, format)
    };
    vti.file("0 2 0 3 0 4", &vti.data(&values(T, 60)))
}

/// A valid file of every format and encoding, with the options it needs.
fn good_files() -> Vec<(&'static str, Vec<u8>, ReadOptions)> {
    let v = values(T, 60);
    let raw = payload(&v, T, false, Encoding::Raw);
    let data = |encoding| payload(&v, T, false, encoding);
    let attach = |header: String, encoding| [header.into_bytes(), data(encoding)].concat();
    let mut h = Nifti::new(&[3, 4, 5], T, false);
    h.i16(252, 1);
    h.i16(254, 1);
    h.floats(280, &[1., 0., 0., 5., 0., 1., 0., 6., 0., 0., 2., 7.]);
    let nii = [h.bytes.as_slice(), &raw].concat();
    let zlib = "CompressedData = True\nCompressedDataSize = 99";
    let plain = ReadOptions::default;
    let with_layout = || ReadOptions {
        raw: layout([3, 4, 5]),
        time: 0,
    };
    vec![
        ("r.nrrd", attach(good_nrrd("raw"), Encoding::Raw), plain()),
        ("g.nrrd", attach(good_nrrd("gzip"), Encoding::Gzip), plain()),
        (
            "b.nrrd",
            attach(good_nrrd("bzip2"), Encoding::Bzip2),
            plain(),
        ),
        ("t.nrrd", attach(good_nrrd("text"), Encoding::Text), plain()),
        (
            "r.mha",
            attach(good_meta("", "LOCAL"), Encoding::Raw),
            plain(),
        ),
        (
            "z.mha",
            attach(good_meta(zlib, "LOCAL"), Encoding::Zlib),
            plain(),
        ),
        ("r.nii", nii.clone(), plain()),
        ("g.nii.gz", compress(&nii, Encoding::Gzip), plain()),
        ("a.vti", vti("ascii", None), plain()),
        ("b.vti", vti("binary", Some(32)), plain()),
        ("r.vti", vti("raw", None), plain()),
        ("z.vti", vti("raw", Some(50)), plain()),
        ("e.vti", vti("base64", None), plain()),
        ("r.raw", raw.clone(), with_layout()),
        ("g.raw.gz", compress(&raw, Encoding::Gzip), with_layout()),
    ]
}

const WORDS: [&str; 16] = [
    "-1",
    "0",
    "nan",
    "inf",
    "1e308",
    "1e-320",
    "4294967295",
    "4294967296",
    "9223372036854775807",
    "18446744073709551616",
    "",
    "(",
    "none",
    "%d 1 2 3",
    "\u{fffd}",
    "10000 10000 10000",
];

/// One random damage: a byte, a run of bytes, a number, a line, the end.
fn damage(bytes: &mut Vec<u8>, rng: &mut Pcg64Mcg) {
    let mut below = |n: usize| (rng.next_u64() % n.max(1) as u64) as usize;
    if bytes.is_empty() {
        return;
    }
    let at = below(bytes.len());
    match below(6) {
        0 => bytes.truncate(at),
        1 => bytes[at] = below(256) as u8,
        2 => {
            let end = (at + below(8)).min(bytes.len());
            let value = [0, 0x7f, 0x80, 0xff][below(4)];
            bytes[at..end].fill(value);
        }
        3 => {
            // A run of digits becomes something else.
            let from = bytes.iter().skip(at).position(u8::is_ascii_digit);
            let from = from.map_or(at, |p| at + p);
            let digits = bytes[from..].iter().take_while(|b| b.is_ascii_digit());
            let to = from + digits.count();
            bytes.splice(from..to, WORDS[below(16)].bytes());
        }
        4 => {
            // A line goes, or comes twice.
            let ends = bytes.iter().enumerate().filter(|(_, b)| **b == b'\n');
            let ends: Vec<usize> = ends.map(|(i, _)| i + 1).collect();
            let n = below(ends.len().saturating_sub(1));
            if let (Some(from), Some(to)) = (ends.get(n), ends.get(n + 1)) {
                let line = bytes[*from..*to].to_vec();
                let twice = if below(2) == 0 {
                    vec![]
                } else {
                    line.repeat(2)
                };
                bytes.splice(*from..*to, twice);
            }
        }
        _ => {
            let noise: Vec<u8> = (0..below(40)).map(|_| below(256) as u8).collect();
            bytes.splice(at..at, noise);
        }
    }
}

#[test]
fn good_files_are_read() {
    let dir = TempDir::new().unwrap();
    for (name, bytes, options) in good_files() {
        let path = write(dir.path(), name, &[&bytes]);
        let volume = read(&path, &options, &mut |_, _| {});
        assert_eq!(volume.unwrap_or_else(|e| panic!("{e}")).voxels.len(), 60);
    }
}

#[test]
fn damaged_files_neither_panic_nor_hang() {
    let dir = TempDir::new().unwrap();
    let mut rng = Pcg64Mcg::seed_from_u64(7);
    let mut refused = 0;
    for round in 0..100 {
        for (name, mut bytes, options) in good_files() {
            for _ in 0..=round % 3 {
                damage(&mut bytes, &mut rng);
            }
            let path = write(dir.path(), name, &[&bytes]);
            let start = Instant::now();
            let header = read_header(&path, &options);
            let volume = read(&path, &options, &mut |_, _| {});
            assert!(start.elapsed() < WATCHDOG, "round {round} of {name}");
            let message = match volume {
                Ok(volume) => {
                    assert!(header.is_ok(), "round {round} of {name}");
                    let n = volume.grid.voxel_count();
                    assert_eq!(volume.voxels.len() as u64, n, "round {round} of {name}");
                    assert!(volume.grid.world_from_index.inverse().is_finite());
                    assert!(n < 1 << 24, "round {round} of {name}");
                    continue;
                }
                Err(e) => e.to_string(),
            };
            refused += 1;
            let place = dir.path().to_string_lossy();
            assert!(message.contains(&*place), "names no file: {message}");
            assert!(message.chars().count() < 800, "endless: {message}");
        }
    }
    assert!(
        refused > 300,
        "only {refused} of 1500 damaged files were refused"
    );
    #[cfg(target_os = "linux")]
    {
        let status = std::fs::read_to_string("/proc/self/status").unwrap();
        let line = status.lines().find(|l| l.starts_with("VmHWM")).unwrap();
        let kib: u64 = line.split_whitespace().nth(1).unwrap().parse().unwrap();
        assert!(kib < 400 << 10, "{line}");
    }
}

#[test]
fn every_shortening_of_every_file_is_refused() {
    let dir = TempDir::new().unwrap();
    for (name, bytes, options) in good_files() {
        // A number cut short is still a number, and text has no other end; nor are tags after appended
        // data read.
        let last = bytes.len()
            - match name {
                "t.nrrd" => 4,
                "r.vti" | "z.vti" | "e.vti" => "\n</AppendedData>\n</VTKFile>\n".len() + 1,
                _ => 1,
            };
        for len in (0..=last).rev().step_by(17) {
            let path = write(dir.path(), name, &[&bytes[..len]]);
            error_with(&path, &options);
        }
    }
}

#[test]
fn a_small_file_that_claims_a_million_million_voxels_fails_at_once() {
    let huge = "type: uchar\ndimension: 3\nsizes: 10000 10000 10000\nencoding:";
    for encoding in ["raw", "gzip", "bzip2", "text"] {
        let header = nrrd(&format!("{huge} {encoding}"));
        let words = [
            "voxel data",
            "1000000000000 bytes for 10000 × 10000 × 10000",
        ];
        refused("a.nrrd", &[header.as_bytes(), b"1f8b3 5 7"], &words);
    }
    for format in ["ascii", "binary", "raw", "base64"] {
        for zlib in [None, Some(1 << 15)] {
            let vti = Vti {
                zlib,
                ..Vti::new(ScalarType::U8, format)
            };
            // A header that agrees with the claim, and no data.
            let blocks = [30_517_579, 1 << 15, 0].map(|w| w as u32);
            let header: Vec<u8> = blocks.iter().flat_map(|w| w.to_le_bytes()).collect();
            let file = vti.file("0 9999 0 9999 0 9999", &header);
            let words = [
                "voxel data",
                "1000000000000 bytes for 10000 × 10000 × 10000",
            ];
            refused("a.vti", &[&file], &words);
        }
    }
    for more in ["", "CompressedData = True\n", "BinaryData = False\n"] {
        let header = format!(
            "NDims = 3\n{more}DimSize = 10000 10000 10000\nElementType = MET_UCHAR\n\
             ElementDataFile = LOCAL\n"
        );
        let words = ["voxel data", "1000000000000 bytes"];
        refused("a.mha", &[header.as_bytes(), b"12 34"], &words);
    }
    let h = Nifti::new(&[10000, 10000, 10000], ScalarType::U8, true);
    let words = ["voxel data", "1000000000000 bytes"];
    refused("a.nii", &[&h.bytes], &words);
    refused("a.nii.gz", &[&compress(&h.bytes, Encoding::Gzip)], &words);

    let dir = TempDir::new().unwrap();
    let options = ReadOptions {
        raw: layout([10000; 3]),
        time: 0,
    };
    for name in ["a.raw", "a.raw.gz"] {
        let bytes = compress(&[7; 100], Encoding::Gzip);
        let path = write(dir.path(), name, &[&bytes]);
        let message = error_with(&path, &options);
        assert!(message.contains("2000000000000 bytes"), "{message}");
    }
}

#[test]
fn truncated_compressed_data_says_so() {
    for (name, bytes, options) in good_files() {
        if !matches!(
            name,
            "g.nrrd" | "b.nrrd" | "z.mha" | "g.nii.gz" | "g.raw.gz"
        ) {
            continue;
        }
        let dir = TempDir::new().unwrap();
        // Without a part of the data, and without a part of the checksum only.
        for cut in [30, 3] {
            let path = write(dir.path(), name, &[&bytes[..bytes.len() - cut]]);
            let message = error_with(&path, &options);
            assert!(message.contains("truncated"), "{name}: {message}");
        }
    }
}

#[test]
fn a_wrong_checksum_is_corrupt() {
    let (name, mut bytes, _) = good_files().swap_remove(1);
    let n = bytes.len();
    bytes[n - 8] ^= 1;
    refused(name, &[&bytes], &["voxel data", "corrupt gzip"]);
}

#[test]
fn empty_files_and_wrong_magics_are_named() {
    refused("a.nrrd", &[], &["magic", "\"\"", "NRRD0001"]);
    refused("a.mha", &[], &["ElementDataFile", "no such field", "LOCAL"]);
    refused("a.nii", &[], &["header", "0 bytes", "348 bytes"]);
    refused("a.nii.gz", &[], &["header", "0 bytes", "348 bytes"]);
    refused(
        "a.nrrd",
        &[b"NRRD0009\n"],
        &["magic", "NRRD0009", "NRRD0006"],
    );
    refused("a.nhdr", &[b"P5 3 4\n"], &["magic", "P5 3 4"]);
    refused(
        "a.mha",
        &[b"\x00\x01 no text\n"],
        &["header line", "key = value"],
    );
    let mut h = Nifti::new(&[1, 1, 1], T, false);
    h.bytes[344..348].copy_from_slice(b"abc\0");
    refused("a.nii", &[&h.bytes], &["magic", "abc", "n+1"]);
    h.i32(0, 540);
    refused(
        "a.nii",
        &[&h.bytes],
        &["sizeof_hdr", "540 (NIfTI-2)", "348"],
    );
    refused(
        "a.xyz",
        &[b"abc"],
        &["unknown volume format", ".nrrd", "--dims"],
    );
    let dir = TempDir::new().unwrap();
    let message = error_with(dir.path(), &ReadOptions::default());
    assert!(message.contains("a folder"), "{message}");
    let message = error_with(&dir.path().join("absent.nii"), &ReadOptions::default());
    assert!(message.contains("absent.nii: cannot open"), "{message}");
}

#[test]
fn binary_noise_without_line_ends_is_no_header() {
    let noise = vec![b'x'; 2 << 20];
    refused("a.mha", &[b"ObjectType = ", &noise], &["header", "1 MiB"]);
    refused("a.nrrd", &[b"NRRD0004\n# ", &noise], &["header", "1 MiB"]);
}

#[test]
fn text_voxels_out_of_range_are_quoted() {
    let mut text = good_nrrd("text");
    text += &"7 ".repeat(59);
    refused(
        "a.nrrd",
        &[text.as_bytes(), b"40000"],
        &["voxel data", "\"40000\" as value 59", "type i16"],
    );
}

#[test]
fn a_zlib_block_gives_no_more_than_its_header_says() {
    let vti = Vti {
        zlib: Some(120),
        ..Vti::new(T, "raw")
    };
    // 64 MiB of zeros in 64 KiB, where the header promises 120 bytes.
    let bomb = compress(&vec![0; 64 << 20], Encoding::Zlib);
    let header = vti.words(&[1, 120, 0, bomb.len() as u64]);
    let file = vti.file("0 2 0 3 0 4", &[header, bomb.clone()].concat());
    refused("a.vti", &[&file], &["voxel data", "corrupt zlib"]);
    let words = |list: &[u64]| vti.file("0 2 0 3 0 4", &[vti.words(list), bomb.clone()].concat());
    let many = words(&[4_000_000_000, 0, 0]);
    refused("a.vti", &[&many], &["4000000000 blocks of 0 bytes", "120"]);
    let odd = words(&[1, 120, 121, 5]);
    refused(
        "a.vti",
        &[&odd],
        &["1 blocks of 120 bytes, the last of 121"],
    );
    let one_each = words(&[120, 1, 0, 4_000_000_000]);
    refused("a.vti", &[&one_each], &["voxel data"]);
}

#[test]
fn hostile_tags_are_refused() {
    let deep = "<a>".repeat(300_000);
    let attributes = format!("<VTKFile {}>", "a=\"\" ".repeat(150_000));
    let entities =
        "<!DOCTYPE x [<!ENTITY a \"aaaa\"><!ENTITY b \"&a;&a;&a;\">]><VTKFile type=\"&b;\"/>";
    for text in [
        deep.as_str(),
        &attributes,
        entities,
        "<VTKFile type=\"ImageData\">",
    ] {
        refused("a.vti", &[text.as_bytes()], &["XML"]);
    }
    let long = [b"<VTKFile a=\"".to_vec(), vec![b'x'; 2 << 20]].concat();
    refused("a.vti", &[&long], &["XML", "1 MiB"]);
    refused("a.vti", &[b"no tags"], &["XML", "'n'", "'<'"]);
    refused("a.vti", &[], &["XML"]);
}
