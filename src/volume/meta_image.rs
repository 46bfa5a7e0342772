//! MetaImage, header and voxels in one file (`.mha`) or two (`.mhd` with `.raw` or `.zraw`).
//!
//! Read: 3 dimensions, one channel, raw, zlib or text voxels in one file. The format has no rescale;
//! `ElementMin` and `ElementMax` only describe the data and are ignored.
//! As ITK's writer and reader do, each consecutive triple of `TransformMatrix` is the direction of
//! one index axis. A file that states its `AnatomicalOrientation` is a patient's and in ITK's world
//! (LPS), which is turned to RAS; without it the axes are kept as they are.

use std::io::BufReader;
use std::path::{Path, PathBuf};

use glam::DVec3;

use super::header_text::{Fields, HeaderLines, shown};
use super::payload::{Encoding, Payload, Start};
use super::source::{Source, affine_grid, check_dims, check_spacing, check_time, open_regular};
use super::{Format, Grid, Header, Rescale, ScalarType, Space, VolumeError};

const DATA_FILE: &str = "ElementDataFile";
const TYPES: &str = "MET_UCHAR, MET_CHAR, MET_USHORT, MET_SHORT, MET_UINT, MET_INT, MET_FLOAT or \
                     MET_DOUBLE";

/// Reads and checks the header of `path`; `time` can only be 0.
pub(super) fn open(path: &Path, time: u32) -> Result<Source, VolumeError> {
    let (fields, header_end) = parse(path)?;
    check_time(path, "NDims", time, 1)?;
    let scalar_type = scalar_type(&fields)?;
    let header = Header {
        grid: grid(&fields, scalar_type)?,
        scalar_type,
        rescale: Rescale::IDENTITY,
        format: Format::MetaImage,
        time_steps: 1,
        spatial_unit: fields
            .text("DistanceUnits")
            .filter(|u| !matches!(*u, "" | "?"))
            .map(str::to_owned),
    };
    let encoding = encoding(&fields)?;
    let (file, offset) = locate(&fields, header_end)?;
    let total = header.grid.voxel_count() * scalar_type.bytes() as u64;
    Ok(Source {
        payload: Payload {
            start: start(&fields, offset, encoding, total)?,
            path: file,
            encoding,
            skip_bytes: 0,
            skip_voxels: 0,
            dims: header.grid.dims,
            scalar_type,
            big_endian: big_endian(&fields)?,
        },
        header,
    })
}

/// Reads `key = value` lines up to `ElementDataFile`, which ends the header.
fn parse(path: &Path) -> Result<(Fields, u64), VolumeError> {
    let (file, _) = open_regular(path)?;
    let mut lines = HeaderLines::new(path, BufReader::new(file));
    let mut fields = Fields::new(path);
    while let Some(line) = lines.next_line()? {
        if line.trim().is_empty() {
            continue;
        }
        let Some((key, value)) = line.split_once('=').or_else(|| line.split_once(':')) else {
            return Err(VolumeError::field(
                path,
                "header line",
                shown(&line),
                "`key = value` lines up to ElementDataFile",
            ));
        };
        let key = key.trim();
        // Free text, of which there may be several.
        if key == "Comment" {
            continue;
        }
        fields.insert(key, value)?;
        if key == DATA_FILE {
            return Ok((fields, lines.position()));
        }
    }
    Err(fields.error(DATA_FILE, "LOCAL or a file name at the header's end"))
}

fn scalar_type(fields: &Fields) -> Result<ScalarType, VolumeError> {
    let expected = "1 channel (one value a voxel)";
    let channels = fields.parse::<u64>("ElementNumberOfChannels", expected)?;
    if channels.is_some_and(|n| n != 1) {
        return Err(fields.error("ElementNumberOfChannels", expected));
    }
    Ok(match fields.require("ElementType", TYPES)? {
        "MET_UCHAR" => ScalarType::U8,
        "MET_CHAR" => ScalarType::I8,
        "MET_USHORT" => ScalarType::U16,
        "MET_SHORT" => ScalarType::I16,
        // The format fixes a long at 4 bytes; 8 bytes are MET_LONG_LONG.
        "MET_UINT" | "MET_ULONG" => ScalarType::U32,
        "MET_INT" | "MET_LONG" => ScalarType::I32,
        "MET_FLOAT" => ScalarType::F32,
        "MET_DOUBLE" => ScalarType::F64,
        _ => return Err(fields.error("ElementType", TYPES)),
    })
}

fn grid(fields: &Fields, scalar_type: ScalarType) -> Result<Grid, VolumeError> {
    let path = fields.path();
    let kind = fields.text("ObjectType");
    if kind.is_some_and(|k| k != "Image") {
        return Err(fields.error("ObjectType", "Image"));
    }
    if fields.parse::<u32>("NDims", "3")? != Some(3) {
        return Err(fields.error("NDims", "3"));
    }
    let expected = "3 positive sizes";
    fields.require("DimSize", expected)?;
    let dims = fields.array("DimSize", expected)?.unwrap_or_default();
    let dims = check_dims(path, "DimSize", dims, 1, scalar_type)?;
    let numbers = "3 numbers";
    let spacing = match first(fields, &["ElementSpacing", "ElementSize"]) {
        Some(key) => {
            let given = fields.array(key, numbers)?.unwrap_or_default();
            check_spacing(path, key, given)?
        }
        None => DVec3::ONE,
    };
    let origin = match first(fields, &["Offset", "Position", "Origin"]) {
        Some(key) => {
            let given = fields.array(key, numbers)?.unwrap_or_default();
            let origin = DVec3::from_array(given);
            if !origin.is_finite() {
                return Err(fields.error(key, "3 finite numbers"));
            }
            origin
        }
        None => DVec3::ZERO,
    };
    let matrix_key = first(fields, &["TransformMatrix", "Rotation", "Orientation"]);
    let [x, y, z] = match matrix_key {
        Some(key) => {
            let m: [f64; 9] = fields.array(key, "9 numbers")?.unwrap_or_default();
            [0, 3, 6].map(|i| DVec3::new(m[i], m[i + 1], m[i + 2]))
        }
        None => DVec3::AXES,
    };
    let (flip, space) = match is_anatomical(fields.text("AnatomicalOrientation")) {
        true => (DVec3::new(-1.0, -1.0, 1.0), Space::PatientRas),
        false => (DVec3::ONE, Space::Unspecified),
    };
    let columns = [x * spacing.x, y * spacing.y, z * spacing.z].map(|c| c * flip);
    let blame = matrix_key.unwrap_or("ElementSpacing");
    affine_grid(path, blame, dims, columns, origin * flip, space)
}

/// The first of several names for one thing that the header uses.
fn first<'k>(fields: &Fields, keys: &[&'k str]) -> Option<&'k str> {
    keys.iter().copied().find(|k| fields.text(k).is_some())
}

/// Whether a value such as `RAI` names one end of each of the patient's three axes.
fn is_anatomical(orientation: Option<&str>) -> bool {
    let letters = orientation.unwrap_or_default().to_ascii_uppercase();
    let has_one_of = |ends: [char; 2]| letters.matches(ends).count() == 1;
    letters.len() == 3
        && [['R', 'L'], ['A', 'P'], ['S', 'I']]
            .into_iter()
            .all(has_one_of)
}

fn flag(fields: &Fields, key: &str) -> Result<Option<bool>, VolumeError> {
    let value = fields.text(key).map(str::to_ascii_lowercase);
    match value.as_deref() {
        None => Ok(None),
        Some("true" | "1" | "yes" | "t") => Ok(Some(true)),
        Some("false" | "0" | "no" | "f") => Ok(Some(false)),
        Some(_) => Err(fields.error(key, "True or False")),
    }
}

fn big_endian(fields: &Fields) -> Result<bool, VolumeError> {
    let main = flag(fields, "BinaryDataByteOrderMSB")?;
    let old = flag(fields, "ElementByteOrderMSB")?;
    Ok(main.or(old).unwrap_or(false))
}

fn encoding(fields: &Fields) -> Result<Encoding, VolumeError> {
    let binary = flag(fields, "BinaryData")?.unwrap_or(true);
    let compressed = flag(fields, "CompressedData")?.unwrap_or(false);
    Ok(match (binary, compressed) {
        (true, true) => Encoding::Zlib,
        (true, false) => Encoding::Raw,
        (false, _) => Encoding::Text,
    })
}

/// The file that holds the voxels, and where in it they begin by default.
fn locate(fields: &Fields, header_end: u64) -> Result<(PathBuf, u64), VolumeError> {
    let expected = "LOCAL or the name of one file (lists and numbered files are not read)";
    let name = fields.require(DATA_FILE, expected)?;
    if name.eq_ignore_ascii_case("local") {
        return Ok((fields.path().to_owned(), header_end));
    }
    if name.is_empty() || name.contains('%') || name.starts_with("LIST") {
        return Err(fields.error(DATA_FILE, expected));
    }
    let folder = fields.path().parent().unwrap_or(Path::new(""));
    Ok((folder.join(name), 0))
}

/// Applies `HeaderSize`: bytes from the start of the data's file, or -1 for data that ends it.
///
/// `CompressedDataSize` is not needed, since a zlib stream knows its end.
fn start(
    fields: &Fields,
    offset: u64,
    encoding: Encoding,
    total: u64,
) -> Result<Start, VolumeError> {
    let expected = "a number of bytes, or -1 for uncompressed data";
    Ok(match fields.parse::<i64>("HeaderSize", expected)? {
        None | Some(0) => Start::Offset(offset),
        Some(-1) if encoding == Encoding::Raw => Start::BeforeEnd(total),
        Some(n) => {
            let n = u64::try_from(n).map_err(|_| fields.error("HeaderSize", expected))?;
            Start::Offset(n)
        }
    })
}
