//! The slice files in which the paper's authors publish their table: one a `g`.
//!
//! Little endian: albedo (f32), g (f32), path samples, extinctions, angles (i32), least and largest
//! extinction, radius (f32), then radiance (f32), angle fastest. Angles span 0 to pi.

use std::fs::File;
use std::io::{Read, Write};
use std::path::{Path, PathBuf};

use super::TableError;
use super::entries::Table;
use super::grid::{Axis, Grid};
use crate::output::atomic;

/// Bytes before the radiance.
const HEADER: u64 = 32;
/// Extinctions or angles of a file, at most.
const MAX_COUNT: i32 = 4096;
/// Slices of a folder, at most.
const MAX_SLICES: usize = 256;

/// The file name of a slice: `AVSTable2D_a09_g-09.tab` has albedo 0.9 and g = -0.9, as the authors name
/// theirs. Values that are no tenths are written out, as in `AVSTable2D_a0.85_g0.25.tab`.
#[must_use]
pub fn file_name(albedo: f64, g: f64) -> String {
    let word = |value: f64| {
        let tenths = 10.0 * value;
        if (tenths - tenths.round()).abs() < 1e-5 {
            let sign = if tenths.round() < 0.0 { "-" } else { "" };
            format!("{sign}{:02}", tenths.round().abs())
        } else {
            format!("{}", (1e6 * value).round() / 1e6)
        }
    };
    format!("AVSTable2D_a{}_g{}.tab", word(albedo), word(g))
}

/// Writes a file for each `g` into a folder, which is made where it is missing; returns their paths.
///
/// # Errors
/// The operating system's refusal.
pub fn write(folder: &Path, table: &Table) -> Result<Vec<PathBuf>, TableError> {
    std::fs::create_dir_all(folder).map_err(|e| TableError::io(folder, "make the folder", e))?;
    let entries = table.grid.sigmas.count * table.grid.thetas.count;
    let mut paths = Vec::new();
    for (g, values) in table.grid.gs.nodes().zip(table.radiance.chunks(entries)) {
        let path = folder.join(file_name(table.albedo, g));
        let sigmas = table.grid.sigmas;
        let counts = [
            table.samples,
            sigmas.count as u32,
            table.grid.thetas.count as u32,
        ];
        atomic::write(&path, |file| {
            for value in [table.albedo as f32, g as f32] {
                file.write_all(&value.to_le_bytes())?;
            }
            for count in counts {
                file.write_all(&(count.min(i32::MAX as u32) as i32).to_le_bytes())?;
            }
            for value in [sigmas.min as f32, sigmas.max as f32, 1.0] {
                file.write_all(&value.to_le_bytes())?;
            }
            values
                .iter()
                .try_for_each(|v| file.write_all(&v.to_le_bytes()))
        })?;
        paths.push(path);
    }
    Ok(paths)
}

/// Reads one slice file, or all `AVSTable2D_*.tab` of a folder, by what their headers say.
///
/// # Errors
/// A file that cannot be read or is not as it should be, or files that do not belong together.
pub fn read(path: &Path) -> Result<Table, TableError> {
    let mut slices = Vec::new();
    for file in files(path)? {
        slices.push((read_slice(&file)?, file));
    }
    slices.sort_by(|a, b| a.0.grid.gs.min.total_cmp(&b.0.grid.gs.min));
    let mut slices = slices.into_iter();
    let Some((mut table, _)) = slices.next() else {
        let expected = "at least one AVSTable2D_*.tab";
        return Err(TableError::content(
            path,
            "the folder",
            "without tables",
            expected,
        ));
    };
    let mut gs = vec![table.grid.gs.min];
    for (slice, file) in slices {
        let same = (slice.albedo, slice.grid.sigmas, slice.grid.thetas)
            == (table.albedo, table.grid.sigmas, table.grid.thetas);
        if !same {
            let (found, expected) = (describe(&slice), describe(&table));
            return Err(TableError::content(&file, "the table", found, expected));
        }
        gs.push(slice.grid.gs.min);
        table.radiance.extend(slice.radiance);
    }
    table.grid.gs = even(path, &gs)?;
    Ok(table)
}

/// The files that a path stands for, in order.
fn files(path: &Path) -> Result<Vec<PathBuf>, TableError> {
    if !path.is_dir() {
        return Ok(vec![path.to_owned()]);
    }
    let failed = |e| TableError::io(path, "list", e);
    let mut files = Vec::new();
    for entry in std::fs::read_dir(path).map_err(failed)? {
        let file = entry.map_err(failed)?.path();
        let name = file.file_name().unwrap_or_default().to_string_lossy();
        if name.starts_with("AVSTable2D_") && name.ends_with(".tab") {
            files.push(file);
        }
    }
    files.sort();
    if files.len() > MAX_SLICES {
        let (found, expected) = (files.len().to_string(), format!("at most {MAX_SLICES}"));
        return Err(TableError::content(
            path,
            "the number of tables",
            found,
            expected,
        ));
    }
    Ok(files)
}

fn describe(table: &Table) -> String {
    let Axis { count, min, max } = table.grid.sigmas;
    format!(
        "of albedo {}, {count} extinctions from {min} to {max} and {} angles",
        table.albedo, table.grid.thetas.count
    )
}

/// The axis of evenly spaced, different values of `g`.
fn even(path: &Path, gs: &[f64]) -> Result<Axis, TableError> {
    let axis = Axis {
        count: gs.len(),
        min: gs[0],
        max: gs[gs.len() - 1],
    };
    let off = |(i, g): (usize, &f64)| (axis.node(i) - g).abs() > 1e-4;
    if gs.iter().enumerate().any(off) || (gs.len() > 1 && axis.step() < 1e-4) {
        let expected = "different values with equal steps";
        return Err(TableError::content(
            path,
            "g of the files",
            format!("{gs:?}"),
            expected,
        ));
    }
    Ok(axis)
}

/// Reads one file; memory is taken only for as many values as the file has bytes for.
fn read_slice(path: &Path) -> Result<Table, TableError> {
    let failed = |e| TableError::io(path, "read", e);
    let mut file = File::open(path).map_err(failed)?;
    let bytes = file.metadata().map_err(failed)?.len();
    if bytes < HEADER {
        let (found, expected) = (format!("{bytes} bytes"), format!("at least {HEADER}"));
        return Err(TableError::content(path, "the size", found, expected));
    }
    let mut header = [0; HEADER as usize];
    file.read_exact(&mut header).map_err(failed)?;
    let mut table = read_header(path, &header)?;
    let [sigmas, thetas] = [table.grid.sigmas.count, table.grid.thetas.count];
    let expected = HEADER + 4 * (sigmas * thetas) as u64;
    let refuse = |what, found: String, expected: String| {
        Err(TableError::content(path, what, found, expected))
    };
    if bytes != expected {
        let expected = format!("{expected} for {sigmas} x {thetas} values");
        return refuse("the size", format!("{bytes} bytes"), expected);
    }
    let mut body = Vec::new();
    file.take(expected).read_to_end(&mut body).map_err(failed)?;
    let values = body.as_chunks::<4>().0.iter();
    table.radiance = values.map(|b| f32::from_le_bytes(*b)).collect();
    let radiance = &table.radiance;
    if radiance.len() != sigmas * thetas {
        let expected = format!("{} as its size says", sigmas * thetas);
        return refuse("the number of values", radiance.len().to_string(), expected);
    }
    match radiance.iter().position(|v| !(v.is_finite() && *v >= 0.0)) {
        Some(i) => {
            let found = format!("{} at value {i}", radiance[i]);
            refuse("radiance", found, "0 or more, finite".to_owned())
        }
        None => Ok(table),
    }
}

/// A table without radiance, of what a header says.
fn read_header(path: &Path, header: &[u8; HEADER as usize]) -> Result<Table, TableError> {
    let words = header.as_chunks::<4>().0;
    let float = |i: usize| f64::from(f32::from_le_bytes(words[i]));
    let integer = |i: usize| i32::from_le_bytes(words[i]);
    let refuse =
        |what, found: String, expected: &str| Err(TableError::content(path, what, found, expected));
    if !(0.0..=1.0).contains(&float(0)) {
        return refuse("albedo", float(0).to_string(), "0 to 1");
    }
    if !(-0.999..=0.999).contains(&float(1)) {
        return refuse("g", float(1).to_string(), "-0.999 to 0.999");
    }
    if integer(2) < 0 {
        return refuse("path samples", integer(2).to_string(), "0 or more");
    }
    let counts = [
        (3, "the number of extinctions"),
        (4, "the number of angles"),
    ];
    for (i, what) in counts {
        if !(2..=MAX_COUNT).contains(&integer(i)) {
            return refuse(what, integer(i).to_string(), "2 to 4096");
        }
    }
    let (least, largest, radius) = (float(5), float(6), float(7));
    if !(least >= 0.0 && largest > least && largest.is_finite()) {
        let found = format!("{least} to {largest}");
        return refuse("extinction", found, "0 or more, rising");
    }
    if !(radius > 0.0 && radius.is_finite()) {
        return refuse("radius", radius.to_string(), "above 0");
    }
    let counts = [integer(3), integer(4)].map(|c| c.unsigned_abs() as usize);
    let exact = |value: f64| (1e6 * value).round() / 1e6;
    Ok(Table {
        albedo: exact(float(0)),
        samples: integer(2).unsigned_abs(),
        grid: grid(counts, [least * radius, largest * radius], exact(float(1))),
        radiance: Vec::new(),
        standard_error: Vec::new(),
    })
}

fn grid([sigmas, thetas]: [usize; 2], [min, max]: [f64; 2], g: f64) -> Grid {
    Grid {
        thetas: Axis {
            count: thetas,
            ..Grid::PAPER.thetas
        },
        sigmas: Axis {
            count: sigmas,
            min,
            max,
        },
        gs: Axis {
            count: 1,
            min: g,
            max: g,
        },
    }
}
