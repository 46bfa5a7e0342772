//! NRRD ("nearly raw raster data"), attached (`.nrrd`) and detached (`.nhdr`) headers.
//!
//! Read: 3 dimensions, or 4 where the slowest axis counts time steps; encodings raw, text, gzip and
//! bzip2; one scalar a voxel. The format has no rescale: data values are the stored values.
//! The format is described at <https://teem.sourceforge.net/nrrd/format.html>.

mod axes;
mod world;

use std::io::{BufRead, BufReader, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use super::header_text::{Fields, HeaderLines, shown};
use super::payload::{Encoding, Payload, Start};
use super::source::{Source, check_time, open_regular};
use super::{Format, Header, Rescale, ScalarType, VolumeError};
use axes::{Axes, Holds};

const TYPES: &str = "int8, uint8, int16, uint16, int32, uint32, float or double";

/// Reads and checks the header of `path`; `time` is the wanted step.
pub(super) fn open(path: &Path, time: u32) -> Result<Source, VolumeError> {
    open_as(path, time, Holds::Scalars)
}

/// The same of a file whose first axis holds three colours; the payload's `dims` are to count them.
pub(super) fn open_color(path: &Path) -> Result<Source, VolumeError> {
    open_as(path, 0, Holds::Colors)
}

fn open_as(path: &Path, time: u32, holds: Holds) -> Result<Source, VolumeError> {
    let (fields, header_end) = parse(path)?;
    let scalar_type = scalar_type(&fields)?;
    let axes = Axes::parse(&fields, scalar_type, holds)?;
    check_time(path, "sizes", time, axes.steps)?;
    let encoding = encoding(&fields)?;
    let header = Header {
        grid: world::grid(&fields, &axes)?,
        scalar_type,
        rescale: Rescale::IDENTITY,
        format: Format::Nrrd,
        time_steps: axes.steps,
        spatial_unit: world::unit(&fields, &axes)?,
    };
    let voxels = header.grid.voxel_count();
    let total = voxels * u64::from(axes.steps) * scalar_type.bytes() as u64;
    let (file, offset) = locate(&fields, header_end)?;
    let offset = skip_lines(&fields, &file, offset)?;
    let (start, skip_bytes) = match fields.parse::<i64>("byte skip", "a number of bytes or -1")? {
        None => (Start::Offset(offset), 0),
        Some(-1) if encoding == Encoding::Raw => (Start::BeforeEnd(total), 0),
        Some(n) => {
            let n = u64::try_from(n).map_err(|_| {
                fields.error("byte skip", "a number of bytes, or -1 with raw encoding")
            })?;
            (Start::Offset(offset), n)
        }
    };
    Ok(Source {
        payload: Payload {
            path: file,
            encoding,
            start,
            skip_bytes,
            skip_voxels: u64::from(time) * voxels,
            dims: header.grid.dims,
            scalar_type,
            big_endian: big_endian(&fields, scalar_type, encoding)?,
        },
        header,
    })
}

/// Reads the header's lines; gives the fields and, if a blank line ended them, where that was.
fn parse(path: &Path) -> Result<(Fields, Option<u64>), VolumeError> {
    let (file, _) = open_regular(path)?;
    let mut lines = HeaderLines::new(path, BufReader::new(file));
    let magic = lines.next_line()?.unwrap_or_default();
    if !matches!(
        magic.trim_end().strip_prefix("NRRD000"),
        Some("1" | "2" | "3" | "4" | "5" | "6")
    ) {
        return Err(VolumeError::field(
            path,
            "magic",
            shown(&magic),
            "NRRD0001 to NRRD0006",
        ));
    }
    let mut fields = Fields::new(path);
    while let Some(line) = lines.next_line()? {
        if line.is_empty() {
            return Ok((fields, Some(lines.position())));
        }
        // `key:=value` pairs are the user's own; only `field: value` is the format's.
        if line.starts_with('#')
            || line
                .split_once(':')
                .is_some_and(|(_, v)| v.starts_with('='))
        {
            continue;
        }
        let Some((key, value)) = line.split_once(": ").or_else(|| line.split_once(':')) else {
            return Err(VolumeError::field(
                path,
                "header line",
                shown(&line),
                "`field: value`, `key:=value` or `# comment`",
            ));
        };
        fields.insert(canonical(&key.trim().to_lowercase()), value)?;
    }
    Ok((fields, None))
}

/// The one name of a field that may be spelt in several ways.
fn canonical(key: &str) -> &str {
    match key {
        "datafile" => "data file",
        "lineskip" => "line skip",
        "byteskip" => "byte skip",
        "axismins" => "axis mins",
        "axismaxs" => "axis maxs",
        "centers" => "centerings",
        other => other,
    }
}

fn scalar_type(fields: &Fields) -> Result<ScalarType, VolumeError> {
    let name = fields.require("type", TYPES)?.to_lowercase();
    Ok(match name.as_str() {
        "signed char" | "int8" | "int8_t" => ScalarType::I8,
        "uchar" | "unsigned char" | "uint8" | "uint8_t" => ScalarType::U8,
        "short" | "short int" | "signed short" | "signed short int" | "int16" | "int16_t" => {
            ScalarType::I16
        }
        "ushort" | "unsigned short" | "unsigned short int" | "uint16" | "uint16_t" => {
            ScalarType::U16
        }
        "int" | "signed int" | "int32" | "int32_t" => ScalarType::I32,
        "uint" | "unsigned int" | "uint32" | "uint32_t" => ScalarType::U32,
        "float" => ScalarType::F32,
        "double" => ScalarType::F64,
        _ => return Err(fields.error("type", TYPES)),
    })
}

fn encoding(fields: &Fields) -> Result<Encoding, VolumeError> {
    let expected = "raw, text, gzip or bzip2";
    let name = fields.require("encoding", expected)?.to_lowercase();
    Ok(match name.as_str() {
        "raw" => Encoding::Raw,
        "txt" | "text" | "ascii" => Encoding::Text,
        "gz" | "gzip" => Encoding::Gzip,
        "bz2" | "bzip2" => Encoding::Bzip2,
        _ => return Err(fields.error("encoding", expected)),
    })
}

/// The byte order, which a header may leave out where it does not matter.
fn big_endian(
    fields: &Fields,
    scalar_type: ScalarType,
    encoding: Encoding,
) -> Result<bool, VolumeError> {
    let expected = "little or big";
    match fields.text("endian").map(str::to_lowercase).as_deref() {
        Some("little") => Ok(false),
        Some("big") => Ok(true),
        None if scalar_type.bytes() == 1 || encoding == Encoding::Text => Ok(false),
        _ => Err(fields.error("endian", expected)),
    }
}

/// The file that holds the voxels, and where in it the header ends.
fn locate(fields: &Fields, header_end: Option<u64>) -> Result<(PathBuf, u64), VolumeError> {
    let path = fields.path();
    let Some(name) = fields.text("data file") else {
        let end = header_end.ok_or_else(|| {
            let found = "the end of the file";
            let expected = "a blank line before the voxels, or a `data file` field";
            VolumeError::field(path, "header", found, expected)
        })?;
        return Ok((path.to_owned(), end));
    };
    let mut words = name.split_whitespace();
    let numbers = name
        .split_whitespace()
        .skip(1)
        .filter(|w| w.parse::<i64>().is_ok())
        .count();
    let is_pattern = name.contains('%') && numbers >= 3;
    if name.is_empty() || words.next() == Some("LIST") || is_pattern {
        return Err(fields.error(
            "data file",
            "the name of one file (lists and numbered files are not read)",
        ));
    }
    Ok((path.parent().unwrap_or(Path::new("")).join(name), 0))
}

/// Passes over the lines that `line skip` names.
fn skip_lines(fields: &Fields, file: &Path, offset: u64) -> Result<u64, VolumeError> {
    let lines: u64 = fields
        .parse("line skip", "a number of lines")?
        .unwrap_or_default();
    if lines == 0 {
        return Ok(offset);
    }
    let io = |e| VolumeError::io(file, "read", e);
    let mut reader = BufReader::new(open_regular(file)?.0);
    reader.seek(SeekFrom::Start(offset)).map_err(io)?;
    let mut position = offset;
    for _ in 0..lines {
        // Every line takes at least one byte, so that the end of the file bounds this loop.
        let n = reader.skip_until(b'\n').map_err(io)?;
        if n == 0 {
            return Err(fields.error("line skip", "at most the lines of the data file"));
        }
        position += n as u64;
    }
    Ok(position)
}
