//! Loading takes at most twice the decoded size in memory. Alone in its binary: it reads the
//! process' own high-water mark.

#![allow(clippy::unwrap_used)]
#![cfg(target_os = "linux")]

mod volume_files;

use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};

use tyndall::volume::{RawLayout, ReadOptions, ScalarType, read};
use volume_files::{Encoding, compress, write};

/// The most memory this process has had resident, in bytes.
fn peak() -> usize {
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find(|l| l.starts_with("VmHWM")).unwrap();
    let kib: usize = line.split_whitespace().nth(1).unwrap().parse().unwrap();
    kib * 1024
}

/// Writes `piece` `n` times, without holding the whole in memory.
fn append(path: &Path, piece: &[u8], n: usize) -> PathBuf {
    let mut file = File::create(path).unwrap();
    for _ in 0..n {
        file.write_all(piece).unwrap();
    }
    path.to_owned()
}

#[test]
fn loading_takes_at_most_twice_the_decoded_size() {
    let dir = tempfile::TempDir::new().unwrap();
    // Small enough to be written quickly, large enough to stand out from the process itself.
    let decoded = 96 << 20;
    let options = ReadOptions {
        raw: Some(RawLayout {
            dims: [1 << 12, 1 << 11, 6],
            scalar_type: ScalarType::I16,
            spacing: [1.0; 3],
            big_endian: true,
            skip_bytes: 0,
        }),
        time: 0,
    };
    let piece = vec![1u8; 16 << 20];
    let packed = compress(&piece, Encoding::Gzip);
    let files = [
        write(dir.path(), "a.raw.gz", &[packed.as_slice(); 6]),
        append(&dir.path().join("a.raw"), &piece, 6),
    ];
    for path in files {
        let volume = read(&path, &options, &mut |_, _| {}).unwrap();
        assert_eq!(volume.voxels.len() * 2, decoded);
        drop(volume);
        // The process itself, and the piece above, take less than 48 MiB.
        assert!(peak() <= 2 * decoded + (48 << 20), "{} bytes", peak());
    }
}
