//! The sums of an interrupted build, on disk.
//!
//! A magic word, the SHA-256 of all that decides the result, batches and goals of each column (u32), sums
//! and sums of squares (f64), little endian.

use std::io::Write;
use std::path::Path;

use sha2::{Digest, Sha256};

use super::TableError;
use super::layout::{LAYOUTS, PATHS};
use super::sums::{Request, Sums};
use crate::output::atomic;

const MAGIC: &[u8; 8] = b"TYNSUMS1";

/// Writes the sums, whole or not at all.
///
/// # Errors
/// The operating system's refusal.
pub fn save(path: &Path, sums: &Sums) -> Result<(), TableError> {
    atomic::write(path, |file| {
        file.write_all(MAGIC)?;
        file.write_all(&hash(&sums.request))?;
        for list in [&sums.batches, &sums.goals] {
            list.iter()
                .try_for_each(|v| file.write_all(&v.to_le_bytes()))?;
        }
        for list in [&sums.totals, &sums.squares] {
            list.iter()
                .try_for_each(|v| file.write_all(&v.to_le_bytes()))?;
        }
        Ok(())
    })?;
    Ok(())
}

/// Reads the sums of a request.
///
/// # Errors
/// No such file, another size than the request's, or a state of another request.
pub fn load(path: &Path, request: &Request) -> Result<Sums, TableError> {
    let mut sums = Sums::new(request.clone());
    let (columns, values) = (sums.batches.len(), sums.totals.len());
    let expected = (MAGIC.len() + 32 + 8 * columns + 16 * values) as u64;
    let found = std::fs::metadata(path).map_err(|e| TableError::io(path, "read", e))?;
    if found.len() != expected {
        let (found, expected) = (format!("{} bytes", found.len()), format!("{expected}"));
        return Err(TableError::content(
            path,
            "the state's size",
            found,
            expected,
        ));
    }
    let bytes = std::fs::read(path).map_err(|e| TableError::io(path, "read", e))?;
    let (head, rest) = bytes.split_at_checked(40).unwrap_or((&bytes, &[]));
    if head != [MAGIC.as_slice(), &hash(request)].concat() {
        let expected = "that of these parameters and this shader; remove the file to begin anew";
        return Err(TableError::content(
            path,
            "the state's hash",
            "another",
            expected,
        ));
    }
    let (counts, values_bytes) = rest.split_at_checked(8 * columns).unwrap_or((rest, &[]));
    let counts = counts.as_chunks().0.iter().map(|b| u32::from_le_bytes(*b));
    for (to, from) in sums.batches.iter_mut().chain(&mut sums.goals).zip(counts) {
        *to = from;
    }
    let read = values_bytes
        .as_chunks()
        .0
        .iter()
        .map(|b| f64::from_le_bytes(*b));
    for (to, from) in sums.totals.iter_mut().chain(&mut sums.squares).zip(read) {
        *to = from;
    }
    Ok(sums)
}

/// Of everything that decides what a batch holds; errors and numbers of batches only decide how many there
/// are, so a build may go on to a smaller error.
fn hash(request: &Request) -> [u8; 32] {
    let mut hash = Sha256::new();
    hash.update(LAYOUTS[0].shader.spirv);
    let Request {
        albedos,
        grid,
        seed,
        ..
    } = request;
    hash.update(format!("{albedos:?} {grid:?} {seed} {PATHS}"));
    hash.finalize().into()
}
