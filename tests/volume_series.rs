//! Numbered series of files: which files, in which order, and what is refused.

#![allow(clippy::unwrap_used, clippy::panic)]

mod volume_files;

use std::path::Path;

use tempfile::TempDir;
use tyndall::volume::{RawLayout, ReadOptions, ScalarType, Series, read, read_header};
use volume_files::{Nifti, error_with, nrrd, write};

const STEP: fn(u32) -> ReadOptions = |time| ReadOptions { raw: None, time };

/// A volume of 2 x 1 x 1 voxels, the second one `value`.
fn step(folder: &Path, name: &str, value: u8) {
    let header = nrrd("type: uchar\ndimension: 3\nsizes: 2 1 1\nencoding: raw");
    write(folder, name, &[header.as_bytes(), &[0, value]]);
}

/// The message of the error that a pattern must give.
#[track_caller]
fn refused(folder: &Path, pattern: &str, time: u32, words: &[&str]) {
    let message = error_with(&folder.join(pattern), &STEP(time));
    for word in words {
        assert!(message.contains(word), "no {word:?} in: {message}");
    }
}

#[test]
fn steps_are_the_files_in_the_order_of_their_numbers() {
    let dir = TempDir::new().unwrap();
    // Widths differ, numbers are missing, and other files stand beside.
    for (name, value) in [
        ("t9.nrrd", 9),
        ("t010.nrrd", 10),
        ("t2.nrrd", 2),
        ("t100.nrrd", 100),
    ] {
        step(dir.path(), name, value);
    }
    for name in [
        "t.nrrd",
        "t1a.nrrd",
        "t-3.nrrd",
        "t5.nrrd.bak",
        "xt5.nrrd",
        "t 4.nrrd",
    ] {
        write(dir.path(), name, &[b"none of them"]);
    }
    let pattern = dir.path().join("t{}.nrrd");
    for (time, value) in (0..).zip([2.0, 9.0, 10.0, 100.0]) {
        let volume = read(&pattern, &STEP(time), &mut |_, _| {}).unwrap();
        assert_eq!(volume.value(1), value);
        assert_eq!(read_header(&pattern, &STEP(time)).unwrap().time_steps, 4);
    }
    let words = [
        "t{}.nrrd",
        "time step 4",
        "from 0 (t2.nrrd) to 3 (t100.nrrd)",
    ];
    refused(dir.path(), "t{}.nrrd", 4, &words);
}

#[test]
fn one_file_is_one_step_and_a_file_of_that_name_is_no_pattern() {
    let dir = TempDir::new().unwrap();
    step(dir.path(), "t7.nrrd", 7);
    let pattern = dir.path().join("t{}.nrrd");
    assert_eq!(read_header(&pattern, &STEP(0)).unwrap().time_steps, 1);
    refused(
        dir.path(),
        "t{}.nrrd",
        1,
        &["time step 1", "from 0 (t7.nrrd) to 0"],
    );
    step(dir.path(), "t{}.nrrd", 1);
    assert_eq!(Series::find(&pattern).unwrap(), None);
    assert_eq!(
        read(&pattern, &STEP(0), &mut |_, _| {}).unwrap().value(1),
        1.0
    );
}

#[test]
fn a_pattern_that_finds_nothing_says_where_it_looked() {
    let dir = TempDir::new().unwrap();
    step(dir.path(), "flow_b.nrrd", 1);
    let place = dir.path().display().to_string();
    let words = [
        "flow_{}.nrrd: series",
        "none among 1 names",
        &place,
        "such as flow_b.nrrd",
        "digits",
    ];
    refused(dir.path(), "flow_{}.nrrd", 0, &words);
    refused(dir.path(), "no/flow_{}.nrrd", 0, &["no: cannot list"]);
    let words = ["2 places for a number", "one {}, in the file's name"];
    refused(dir.path(), "flow_{}_{}.nrrd", 0, &words);
    refused(
        dir.path(),
        "run{}/flow.nrrd",
        0,
        &["1 places", "in the file's name"],
    );
}

#[test]
fn numbers_that_are_no_order_are_refused() {
    let dir = TempDir::new().unwrap();
    step(dir.path(), "t1.nrrd", 1);
    step(dir.path(), "t01.nrrd", 1);
    refused(
        dir.path(),
        "t{}.nrrd",
        0,
        &["t01.nrrd and", "t1.nrrd, which have the same number"],
    );
    step(dir.path(), "u99999999999999999999.nrrd", 1);
    refused(
        dir.path(),
        "u{}.nrrd",
        0,
        &["u99999999999999999999.nrrd", "below 2^64"],
    );
}

#[test]
fn steps_that_differ_name_both_files() {
    let dir = TempDir::new().unwrap();
    step(dir.path(), "a0.nrrd", 1);
    step(dir.path(), "a1.nrrd", 1);
    let wider = nrrd("type: uchar\ndimension: 3\nsizes: 3 1 1\nencoding: raw");
    write(dir.path(), "a2.nrrd", &[wider.as_bytes(), &[0; 3]]);
    let shorts = nrrd("type: short\ndimension: 3\nsizes: 2 1 1\nendian: little\nencoding: raw");
    write(dir.path(), "a3.nrrd", &[shorts.as_bytes(), &[0; 4]]);
    write(dir.path(), "a4.nrrd", &[b"no volume"]);
    read(&dir.path().join("a{}.nrrd"), &STEP(1), &mut |_, _| {}).unwrap();
    let words = [
        "a2.nrrd",
        "3 × 1 × 1 voxels of u8",
        "2 × 1 × 1 voxels of u8 as in",
        "a0.nrrd",
    ];
    refused(dir.path(), "a{}.nrrd", 2, &words);
    refused(
        dir.path(),
        "a{}.nrrd",
        3,
        &["a3.nrrd", "of i16", "of u8 as in", "a0.nrrd"],
    );
    refused(dir.path(), "a{}.nrrd", 4, &["a4.nrrd", "magic"]);
}

#[test]
fn a_series_of_4d_files_is_refused_and_one_of_headerless_files_read() {
    let dir = TempDir::new().unwrap();
    let four = Nifti::new(&[2, 1, 1, 3], ScalarType::U8, false);
    write(dir.path(), "n0.nii", &[&four.bytes, &[0; 6]]);
    refused(
        dir.path(),
        "n{}.nii",
        0,
        &["n0.nii", "3 time steps", "one time step each"],
    );
    for n in 3..6u8 {
        write(dir.path(), &format!("r_{n}.raw"), &[&[n, n]]);
    }
    let raw = Some(RawLayout {
        dims: [2, 1, 1],
        scalar_type: ScalarType::U8,
        spacing: [1.0; 3],
        big_endian: false,
        skip_bytes: 0,
    });
    let options = ReadOptions { raw, time: 2 };
    let volume = read(&dir.path().join("r_{}.raw"), &options, &mut |_, _| {}).unwrap();
    assert_eq!((volume.value(0), volume.name.as_str()), (5.0, "r_5.raw"));
}
