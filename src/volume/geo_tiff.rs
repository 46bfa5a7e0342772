//! Maps of heights from TIFF files, with the tags that surveyors write. The first row is that of largest y.

use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

use glam::{DVec2, UVec2};
use tiff::decoder::{Decoder, DecodingResult};
use tiff::tags::Tag;
use tiff::{ColorType, TiffError};

use super::picture::{name_of, upwards};
use super::source::open_regular;
use super::{HeightMap, Rescale, VolumeError, Voxels};

/// Whether a file begins as a TIFF does, in either byte order.
///
/// # Errors
/// It cannot be read.
pub(super) fn is_tiff(path: &Path) -> Result<bool, VolumeError> {
    let (file, _) = open_regular(path)?;
    let mut first = Vec::new();
    file.take(4)
        .read_to_end(&mut first)
        .map_err(|e| VolumeError::io(path, "read", e))?;
    let beginnings: [&[u8]; 4] = [b"II*\0", b"MM\0*", b"II+\0", b"MM\0+"];
    Ok(beginnings.contains(&&*first))
}

/// Grey values of any type but half floats and 64-bit integers; the first picture of the file. Values that the file
/// says stand for missing ones become NaN.
///
/// # Errors
/// It cannot be read, has colours, or takes more than 256 MiB.
pub(super) fn read_map(path: &Path) -> Result<HeightMap, VolumeError> {
    let broken = |e: TiffError| {
        let expected = "a TIFF that can be decoded, in no more than 256 MiB";
        VolumeError::field(path, "TIFF", e.to_string(), expected)
    };
    let (file, _) = open_regular(path)?;
    let mut decoder = Decoder::new(BufReader::new(file)).map_err(broken)?;
    let (width, height) = decoder.dimensions().map_err(broken)?;
    let color = decoder.colortype().map_err(broken)?;
    if !matches!(color, ColorType::Gray(_)) || width == 0 || height == 0 {
        let found = format!("{width} x {height} pixels of {color:?}");
        let expected = "a map of grey values";
        return Err(VolumeError::field(path, "pixels", found, expected));
    }
    let tags = (spacing(&mut decoder), missing(&mut decoder));
    let dims = UVec2::new(width, height);
    let values = decoder.read_image().map_err(broken)?;
    let Some(voxels) = voxels(&values, dims) else {
        let expected = "8, 16 or 32-bit integers, or 32 or 64-bit floats";
        return Err(VolumeError::field(path, "pixels", "another type", expected));
    };
    let voxels = match tags.1 {
        Some(missing) => without(voxels, missing),
        None => voxels,
    };
    Ok(HeightMap {
        name: name_of(path),
        dims,
        voxels,
        rescale: Rescale::IDENTITY,
        spacing: tags.0,
        spatial_unit: None,
    })
}

type Tiff = Decoder<BufReader<File>>;

/// World units between columns, where the file states them.
fn spacing(decoder: &mut Tiff) -> Option<DVec2> {
    let scale = decoder.get_tag_f64_vec(Tag::ModelPixelScaleTag).ok()?;
    let spacing = DVec2::new(*scale.first()?, *scale.get(1)?);
    (spacing.is_finite() && spacing.cmpgt(DVec2::ZERO).all()).then_some(spacing)
}

/// The value that stands for none.
fn missing(decoder: &mut Tiff) -> Option<f64> {
    let text = decoder.get_tag_ascii_string(Tag::GdalNodata).ok()?;
    text.trim_matches(['\0', ' ']).parse().ok()
}

fn voxels(values: &DecodingResult, dims: UVec2) -> Option<Voxels> {
    let voxels = match values {
        DecodingResult::U8(v) => Voxels::U8(upwards(v, dims)),
        DecodingResult::U16(v) => Voxels::U16(upwards(v, dims)),
        DecodingResult::U32(v) => Voxels::U32(upwards(v, dims)),
        DecodingResult::I8(v) => Voxels::I8(upwards(v, dims)),
        DecodingResult::I16(v) => Voxels::I16(upwards(v, dims)),
        DecodingResult::I32(v) => Voxels::I32(upwards(v, dims)),
        DecodingResult::F32(v) => Voxels::F32(upwards(v, dims)),
        DecodingResult::F64(v) => Voxels::F64(upwards(v, dims)),
        _ => return None,
    };
    // Fewer than 8 bits a value come packed.
    (voxels.len() as u64 == u64::from(dims.x) * u64::from(dims.y)).then_some(voxels)
}

/// NaN where a value is missing.
fn without(voxels: Voxels, missing: f64) -> Voxels {
    let is_missing = |i: usize| voxels.get(i) == missing;
    if !(0..voxels.len()).any(is_missing) {
        return voxels;
    }
    let value = |i: usize| {
        if is_missing(i) {
            f32::NAN
        } else {
            voxels.get(i) as f32
        }
    };
    Voxels::F32((0..voxels.len()).map(value).collect())
}
