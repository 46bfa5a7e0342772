//! Maps of heights from TIFF files, with the tags that surveyors write. The first row is that of largest y.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use glam::{DVec2, UVec2};
use tiff::decoder::{Decoder, DecodingResult, Limits};
use tiff::tags::Tag;
use tiff::{ColorType, TiffError};

use super::picture::{name_of, upwards};
use super::source::open_regular;
use super::{HeightMap, Rescale, ScalarType, VolumeError, Voxels};
use crate::output::MAX_PIXELS;

/// Of latitude, on a sphere with the earth's mean radius of 6371 km.
const METRES_A_DEGREE: f64 = 111_195.0;

/// Whether a file of these first bytes is a TIFF, in either byte order.
pub(super) fn is_tiff(first: &[u8]) -> bool {
    let beginnings: [&[u8]; 4] = [b"II*\0", b"MM\0*", b"II+\0", b"MM\0+"];
    beginnings.iter().any(|b| first.starts_with(b))
}

/// Grey values of any type but half floats and 64-bit integers; the first picture of the file. Values that the file
/// says stand for missing ones become NaN. Where it states no spacing, unsigned integers count from 0 to 1 in full.
///
/// # Errors
/// It cannot be read, has colours, or is too large.
pub(super) fn read_map(path: &Path) -> Result<HeightMap, VolumeError> {
    let broken = |e: TiffError| {
        let expected = "a TIFF that can be decoded";
        VolumeError::field(path, "TIFF", e.to_string(), expected)
    };
    let (file, _) = open_regular(path)?;
    let mut limits = Limits::default();
    limits.decoding_buffer_size = 4 * MAX_PIXELS as usize;
    let decoder = Decoder::new(BufReader::new(file)).map_err(broken)?;
    let mut decoder = decoder.with_limits(limits);
    let (width, height) = decoder.dimensions().map_err(broken)?;
    let color = decoder.colortype().map_err(broken)?;
    let whole = matches!(color, ColorType::Gray(8 | 16 | 32 | 64));
    let size = u64::from(width) * u64::from(height);
    if !whole || !(1..=MAX_PIXELS).contains(&size) {
        let found = format!("{width} x {height} pixels of {color:?}");
        let expected = format!(
            "grey values of 8, 16, 32 or 64 bits, at most {MAX_PIXELS}: crop or resample the map"
        );
        return Err(VolumeError::field(path, "pixels", found, expected));
    }
    let (spacing, missing) = (spacing(path, &mut decoder)?, missing(&mut decoder));
    let dims = UVec2::new(width, height);
    let values = decoder.read_image().map_err(broken)?;
    let Some(voxels) = voxels(&values, dims) else {
        let expected = "8, 16 or 32-bit integers, or 32 or 64-bit floats";
        return Err(VolumeError::field(path, "pixels", "another type", expected));
    };
    let white = match voxels.scalar_type() {
        ScalarType::U8 => f64::from(u8::MAX),
        ScalarType::U16 => f64::from(u16::MAX),
        ScalarType::U32 => f64::from(u32::MAX),
        _ => 1.0,
    };
    Ok(HeightMap {
        name: name_of(path),
        dims,
        voxels: match missing {
            Some(missing) => without(voxels, missing),
            None => voxels,
        },
        rescale: Rescale {
            slope: if spacing.is_some() { 1.0 } else { 1.0 / white },
            intercept: 0.0,
        },
        spacing,
        spatial_unit: None,
    })
}

type Tiff = Decoder<BufReader<File>>;

/// World units between columns, where the file states them; degrees of longitude and latitude become metres at the
/// map's middle.
fn spacing(path: &Path, decoder: &mut Tiff) -> Result<Option<DVec2>, VolumeError> {
    let numbers = |decoder: &mut Tiff, tag| decoder.get_tag_f64_vec(tag).unwrap_or_default();
    let scale = numbers(decoder, Tag::ModelPixelScaleTag);
    let map = numbers(decoder, Tag::ModelTransformationTag);
    let (spacing, corner) = match (&scale[..], &map[..]) {
        ([x, y, ..], _) => {
            let tie = numbers(decoder, Tag::ModelTiepointTag);
            (DVec2::new(*x, *y), tie.get(4).copied())
        }
        // Rows of four: only a map that is not turned has a spacing.
        (_, [x, 0.0, _, _, 0.0, y, _, corner, ..]) => (DVec2::new(*x, *y), Some(*corner)),
        _ => return Ok(None),
    };
    let spacing = spacing.abs();
    if !(spacing.is_finite() && spacing.min_element() > 0.0) {
        return Ok(None);
    }
    if !is_in_degrees(decoder) {
        return Ok(Some(spacing));
    }
    let rows = decoder
        .dimensions()
        .map_or(0.0, |(_, rows)| f64::from(rows));
    let middle = corner.map(|north| north - 0.5 * rows * spacing.y);
    let Some(latitude) = middle.filter(|l| l.abs() < 90.0) else {
        let expected = "a latitude (ModelTiepointTag) for columns that are degrees apart: project the map to metres";
        return Err(VolumeError::field(
            path,
            "TIFF",
            format!("{middle:?}"),
            expected,
        ));
    };
    Ok(Some(
        METRES_A_DEGREE * spacing * DVec2::new(latitude.to_radians().cos(), 1.0),
    ))
}

/// Whether the map's coordinates are longitude and latitude: GTModelTypeGeoKey is 2.
fn is_in_degrees(decoder: &mut Tiff) -> bool {
    let keys = decoder
        .get_tag_u16_vec(Tag::GeoKeyDirectoryTag)
        .unwrap_or_default();
    keys.chunks_exact(4)
        .skip(1)
        .any(|key| *key == [1024, 0, 1, 2])
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
    // The text is often shorter than the number that it stands for.
    let is_missing = |v: f64| v == missing || v as f32 == missing as f32;
    if !(0..voxels.len()).any(|i| is_missing(voxels.get(i))) {
        return voxels;
    }
    let value = |i: usize| {
        Some(voxels.get(i))
            .filter(|v| !is_missing(*v))
            .unwrap_or(f64::NAN)
    };
    voxels.scalar_type().floats((0..voxels.len()).map(value))
}
