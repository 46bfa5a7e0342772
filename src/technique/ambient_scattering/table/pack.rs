//! Tables packed into one small file: what the program ships.
//!
//! `TYNPACK2`, then one zlib stream of i16, little endian, low bytes before high ones: `log2(C / p)` of the
//! paper's grid at [`MAIN_ALBEDO`], then for each of [`OTHER_ALBEDOS`] the same on all angles and every
//! [`COARSE`]-th extinction, in steps of 1/512, so rounded by at most 0.07 %; then `log2` of the relative
//! standard errors of `C`, on every `COARSE`-th angle as well, of `MAIN_ALBEDO` and of the others, to a
//! quarter. All are differences along the angle.

use std::io::{Read, Write};
use std::path::Path;

use flate2::Compression;
use flate2::read::ZlibDecoder;
use flate2::write::ZlibEncoder;

use super::TableError;
use super::collided::Collided;
use super::grid::Grid;

/// The albedo of the table itself, the paper's.
pub const MAIN_ALBEDO: f64 = 0.9;
/// Albedos that are kept beside it, on a coarser grid.
pub const OTHER_ALBEDOS: [f64; 7] = [1.0, 0.98, 0.95, 0.8, 0.6, 0.3, 0.0];
/// Every how many extinctions other albedos are kept, and every how many angles errors are.
pub const COARSE: usize = 5;

const MAGIC: &[u8; 8] = b"TYNPACK2";
/// Steps of an octave.
const STEPS: f64 = 512.0;

/// What a packed file holds, logarithms to the base e.
#[derive(Clone, Debug, PartialEq)]
pub struct Packed {
    /// The paper's grid at [`MAIN_ALBEDO`].
    pub main: Collided,
    /// [`other_grid`] at each of [`OTHER_ALBEDOS`].
    pub others: Vec<Collided>,
    /// Relative standard errors of `C` on the coarser grid, of `MAIN_ALBEDO` and then of the others.
    pub errors: Vec<Vec<f32>>,
}

/// All angles, every [`COARSE`]-th extinction.
#[must_use]
pub fn other_grid() -> Grid {
    Grid {
        thetas: Grid::PAPER.thetas,
        ..Grid::PAPER.coarser(COARSE)
    }
}

/// Packs tables.
///
/// # Errors
/// None that memory would not give; they are those of a writer.
pub fn pack(packed: &Packed) -> std::io::Result<Vec<u8>> {
    let grid = packed.main.grid;
    let row = grid.coarser(COARSE).thetas.count;
    let mut levels = encode(&packed.main.log_ratio, grid.thetas.count, 1.0);
    for other in &packed.others {
        levels.extend(encode(&other.log_ratio, grid.thetas.count, 1.0));
    }
    for errors in &packed.errors {
        levels.extend(encode(errors, row, STEPS / 4.0));
    }
    let mut encoder = ZlibEncoder::new(MAGIC.to_vec(), Compression::best());
    let low: Vec<u8> = levels.iter().map(|l| l.to_le_bytes()[0]).collect();
    let high: Vec<u8> = levels.iter().map(|l| l.to_le_bytes()[1]).collect();
    encoder.write_all(&low)?;
    encoder.write_all(&high)?;
    encoder.finish()
}

/// Unpacks them.
///
/// # Errors
/// Bytes that [`pack`] has not made; `path` names them.
pub fn unpack(path: &Path, bytes: &[u8]) -> Result<Packed, TableError> {
    let Some(stream) = bytes.strip_prefix(MAGIC) else {
        return Err(TableError::content(
            path,
            "the magic word",
            "another",
            "TYNPACK2",
        ));
    };
    let grid = Grid::PAPER;
    let coarse = grid.coarser(COARSE);
    let other = other_grid().len();
    let albedos = OTHER_ALBEDOS.len();
    let entries = grid.len() + albedos * other + (albedos + 1) * coarse.len();
    let mut planes = Vec::new();
    // One byte more than there may be, so that too many are noticed and no more are read.
    let mut decoder = ZlibDecoder::new(stream).take(2 * entries as u64 + 1);
    decoder
        .read_to_end(&mut planes)
        .map_err(|e| TableError::io(path, "unpack", e))?;
    if planes.len() != 2 * entries {
        let (found, expected) = (planes.len().to_string(), (2 * entries).to_string());
        return Err(TableError::content(
            path,
            "the unpacked size",
            found,
            expected,
        ));
    }
    let (low, high) = planes.split_at(entries);
    let pairs = low.iter().zip(high);
    let levels: Vec<i16> = pairs.map(|(l, h)| i16::from_le_bytes([*l, *h])).collect();
    let (main, rest) = levels.split_at(grid.len());
    let (others, errors) = rest.split_at(albedos * other);
    let collided = |grid: Grid, levels: &[i16]| Collided {
        grid,
        log_ratio: decode(levels, grid.thetas.count),
    };
    let others = others.chunks(other).map(|l| collided(other_grid(), l));
    let errors = errors.chunks(coarse.len());
    Ok(Packed {
        main: collided(grid, main),
        others: others.collect(),
        errors: errors.map(|l| decode(l, coarse.thetas.count)).collect(),
    })
}

/// Rounded to every `coarse`-th step.
fn encode(logarithms: &[f32], row: usize, coarse: f64) -> Vec<i16> {
    let mut levels = Vec::with_capacity(logarithms.len());
    for row in logarithms.chunks(row) {
        let mut before = 0_i16;
        for value in row {
            let level = f64::from(*value) * std::f64::consts::LOG2_E * STEPS;
            let level = coarse * (level / coarse).round();
            let level = level.clamp(f64::from(i16::MIN), f64::from(i16::MAX)) as i16;
            levels.push(level.wrapping_sub(before));
            before = level;
        }
    }
    levels
}

fn decode(levels: &[i16], row: usize) -> Vec<f32> {
    let mut logarithms = Vec::with_capacity(levels.len());
    for row in levels.chunks(row) {
        let mut level = 0_i16;
        for difference in row {
            level = level.wrapping_add(*difference);
            logarithms.push((f64::from(level) / STEPS * std::f64::consts::LN_2) as f32);
        }
    }
    logarithms
}
