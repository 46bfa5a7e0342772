//! NIfTI-1: `.nii`, `.nii.gz`, or a pair of `.hdr` and `.img` (either may be gzip).
//!
//! Read: 3D grids and one step of 4D ones. World axes are RAS, as the format defines them.
//! `scl_slope` and `scl_inter` are the rescale; a slope of 0 or NaN means none, as the format
//! (and, for NaN, a common writer) has it. The stored type follows from `datatype` alone; `bitpix`
//! repeats it and is ignored. The format is described at <https://nifti.nimh.nih.gov/nifti-1>.

mod world;

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use super::payload::{Beginning, Encoding, Payload, Start, first_bytes};
use super::source::{Source, check_dims, check_time};
use super::{Format, Header, Rescale, ScalarType, VolumeError};

/// Size of a NIfTI-1 header.
const HEADER_BYTES: usize = 348;

/// The header's bytes with their byte order.
struct Fields<'a> {
    path: &'a Path,
    bytes: [u8; HEADER_BYTES],
    big_endian: bool,
}

impl Fields<'_> {
    fn i16(&self, at: usize) -> i16 {
        let b = [self.bytes[at], self.bytes[at + 1]];
        if self.big_endian {
            i16::from_be_bytes(b)
        } else {
            i16::from_le_bytes(b)
        }
    }

    fn f32(&self, at: usize) -> f32 {
        let b: [u8; 4] = std::array::from_fn(|i| self.bytes[at + i]);
        if self.big_endian {
            f32::from_be_bytes(b)
        } else {
            f32::from_le_bytes(b)
        }
    }

    fn error(
        &self,
        field: impl Into<String>,
        found: impl Into<String>,
        expected: impl Into<String>,
    ) -> VolumeError {
        VolumeError::field(self.path, field, found, expected)
    }
}

/// Whether these first bytes of a (decoded) file are a NIfTI-1 header.
pub(super) fn is_header(bytes: &[u8]) -> bool {
    byte_order(bytes).is_some() && matches!(bytes.get(344..348), Some(b"n+1\0" | b"ni1\0"))
}

/// The byte order that makes the first word the header's size; true for big-endian.
fn byte_order(bytes: &[u8]) -> Option<bool> {
    let size: [u8; 4] = bytes.get(..4)?.try_into().ok()?;
    let expected = HEADER_BYTES as u32;
    if u32::from_le_bytes(size) == expected {
        return Some(false);
    }
    (u32::from_be_bytes(size) == expected).then_some(true)
}

/// Reads and checks the header of `path`; `time` is the wanted step.
pub(super) fn open(path: &Path, time: u32) -> Result<Source, VolumeError> {
    let start = first_bytes(path, HEADER_BYTES as u64)?;
    let fields = fields(path, &start)?;
    let scalar_type = scalar_type(&fields)?;
    let (sizes, time_steps) = sizes(&fields)?;
    let dims = check_dims(path, "dim[1..3]", sizes, time_steps, scalar_type)?;
    check_time(path, "dim[4]", time, time_steps)?;
    let header = Header {
        grid: world::grid(&fields, dims)?,
        scalar_type,
        rescale: rescale(&fields)?,
        format: Format::Nifti,
        time_steps,
        spatial_unit: world::unit(&fields),
    };
    let single = fields.bytes[344..348] == *b"n+1\0";
    let offset = data_offset(&fields, single)?;
    let (file, gzip) = match single {
        true => (path.to_owned(), start.gzip),
        false => image_file(path)?,
    };
    let (encoding, start, skip_bytes) = match gzip {
        true => (Encoding::Gzip, Start::Offset(0), offset),
        false => (Encoding::Raw, Start::Offset(offset), 0),
    };
    Ok(Source {
        payload: Payload {
            path: file,
            encoding,
            start,
            skip_bytes,
            skip_voxels: u64::from(time) * header.grid.voxel_count(),
            dims,
            scalar_type,
            big_endian: fields.big_endian,
        },
        header,
    })
}

/// Checks length, byte order and magic.
fn fields<'a>(path: &'a Path, start: &Beginning) -> Result<Fields<'a>, VolumeError> {
    let bytes = start.bytes.as_slice();
    let fail = |field: &str, found: String, expected: &str| {
        Err(VolumeError::field(path, field, found, expected))
    };
    let Ok(whole) = <[u8; HEADER_BYTES]>::try_from(bytes) else {
        let n = bytes.len();
        let found = match (start.gzip, start.damage) {
            (true, damage) => format!(
                "{} gzip data of {n} decoded bytes",
                damage.unwrap_or("short")
            ),
            (false, _) => format!("a file of {n} bytes"),
        };
        return fail("header", found, "348 bytes");
    };
    let Some(big_endian) = byte_order(bytes) else {
        let size = [bytes[0], bytes[1], bytes[2], bytes[3]];
        let size = i32::from_le_bytes(size);
        let note = match size == 540 || size.swap_bytes() == 540 {
            true => " (NIfTI-2)",
            false => "",
        };
        let expected = "348 (NIfTI-1) in either byte order";
        return fail("sizeof_hdr", format!("{size}{note}"), expected);
    };
    if !is_header(bytes) {
        let found = format!("\"{}\"", bytes[344..348].escape_ascii());
        return fail("magic", found, "\"n+1\" or \"ni1\"");
    }
    Ok(Fields {
        path,
        bytes: whole,
        big_endian,
    })
}

fn scalar_type(fields: &Fields<'_>) -> Result<ScalarType, VolumeError> {
    let name = match fields.i16(70) {
        2 => return Ok(ScalarType::U8),
        4 => return Ok(ScalarType::I16),
        8 => return Ok(ScalarType::I32),
        16 => return Ok(ScalarType::F32),
        64 => return Ok(ScalarType::F64),
        256 => return Ok(ScalarType::I8),
        512 => return Ok(ScalarType::U16),
        768 => return Ok(ScalarType::U32),
        1 => "1 (binary)".to_owned(),
        32 => "32 (complex64)".to_owned(),
        128 => "128 (RGB24)".to_owned(),
        1024 => "1024 (int64)".to_owned(),
        1280 => "1280 (uint64)".to_owned(),
        2304 => "2304 (RGBA32)".to_owned(),
        other => other.to_string(),
    };
    let expected = "2 (u8), 4 (i16), 8 (i32), 16 (f32), 64 (f64), 256 (i8), 512 (u16) or 768 (u32)";
    Err(fields.error("datatype", name, expected))
}

/// Sizes along x, y and z (1 where the header has fewer axes), and the number of time steps.
fn sizes(fields: &Fields<'_>) -> Result<([i64; 3], u32), VolumeError> {
    let count = fields.i16(40);
    if !(1..=7).contains(&count) {
        return Err(fields.error("dim[0]", count.to_string(), "1 to 7 dimensions"));
    }
    let size = |axis: i16| match axis <= count {
        true => i64::from(fields.i16(40 + 2 * axis as usize)),
        false => 1,
    };
    // Unused axes are 1 by the format, and 0 in the files of careless writers.
    let steps = match size(4) {
        0 => 1,
        n => u32::try_from(n).map_err(|_| {
            fields.error("dim[4]", n.to_string(), "a positive number of time steps")
        })?,
    };
    for axis in 5..=7 {
        if !(0..=1).contains(&size(axis)) {
            let found = size(axis).to_string();
            let expected = "1 (one value a voxel and time step)";
            return Err(fields.error(format!("dim[{axis}]"), found, expected));
        }
    }
    Ok(([size(1), size(2), size(3)], steps))
}

fn rescale(fields: &Fields<'_>) -> Result<Rescale, VolumeError> {
    let slope = f64::from(fields.f32(112));
    let intercept = f64::from(fields.f32(116));
    if slope == 0.0 || slope.is_nan() {
        return Ok(Rescale::IDENTITY);
    }
    for (field, value) in [("scl_slope", slope), ("scl_inter", intercept)] {
        if !value.is_finite() {
            return Err(fields.error(field, value.to_string(), "a finite number"));
        }
    }
    Ok(Rescale { slope, intercept })
}

/// `vox_offset`, where the voxels begin; 0 in a single file means right after the header.
fn data_offset(fields: &Fields<'_>, single: bool) -> Result<u64, VolumeError> {
    let offset = fields.f32(108);
    let least = if single { HEADER_BYTES as f32 } else { 0.0 };
    if offset == 0.0 && single {
        return Ok(352);
    }
    if offset.is_finite() && offset >= least && offset.fract() == 0.0 && offset < 2f32.powi(62) {
        return Ok(offset as u64);
    }
    let expected = format!("a whole number of bytes, at least {least}");
    Err(fields.error("vox_offset", offset.to_string(), expected))
}

/// The voxels' file of a pair: `x.img` or `x.img.gz` beside `x.hdr` or `x.hdr.gz`.
fn image_file(path: &Path) -> Result<(PathBuf, bool), VolumeError> {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let lower = name.to_lowercase();
    let stem = [".hdr", ".hdr.gz"]
        .iter()
        .find_map(|end| lower.strip_suffix(end))
        .and_then(|stem| name.get(..stem.len()));
    let Some(stem) = stem else {
        let expected = "a name that ends in .hdr, beside the .img file that a header of this kind \
                        (magic \"ni1\") needs";
        return Err(VolumeError::field(path, "file name", name, expected));
    };
    let sibling = |end: &str| path.with_file_name(OsString::from(format!("{stem}{end}")));
    let plain = sibling(".img");
    let packed = sibling(".img.gz");
    let file = match !plain.exists() && packed.exists() {
        true => packed,
        false => plain,
    };
    let gzip = first_bytes(&file, 2)?.gzip;
    // Raw voxels may begin with gzip's two bytes by chance: the name decides.
    let named = file.extension().is_some_and(|e| e == "gz");
    Ok((file, gzip && named))
}
