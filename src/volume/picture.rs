//! Maps from PNG pictures. A picture's upper edge is that of largest y.

use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

use glam::{UVec2, UVec3};
use image::codecs::png::PngDecoder;
use image::{DynamicImage, ImageDecoder};

use super::source::open_regular;
use super::{ColorVolume, HeightMap, Rescale, VolumeError, Voxels};
use crate::output::MAX_PIXELS;
use crate::scene::linear_from_srgb;

/// Whether a file begins as a PNG picture does.
///
/// # Errors
/// It cannot be read.
pub(super) fn is_png(path: &Path) -> Result<bool, VolumeError> {
    let (file, _) = open_regular(path)?;
    let mut first = Vec::new();
    file.take(8)
        .read_to_end(&mut first)
        .map_err(|e| VolumeError::io(path, "read", e))?;
    Ok(first == b"\x89PNG\r\n\x1a\n")
}

/// A grey picture of 8 or 16 bits; black is 0, white 1.
///
/// # Errors
/// It cannot be read, or has colours.
pub(super) fn read_grey(path: &Path) -> Result<HeightMap, VolumeError> {
    let picture = decode(path)?;
    let dims = UVec2::new(picture.width(), picture.height());
    let (voxels, white) = match picture {
        DynamicImage::ImageLuma8(p) => (Voxels::U8(upwards(&p, dims)), 255.0),
        DynamicImage::ImageLuma16(p) => (Voxels::U16(upwards(&p, dims)), 65535.0),
        other => {
            let found = format!("a picture of {:?}", other.color());
            let expected = "grey values of 8 or 16 bits without transparency";
            return Err(VolumeError::field(path, "pixels", found, expected));
        }
    };
    Ok(HeightMap {
        name: name_of(path),
        dims,
        voxels,
        rescale: Rescale {
            slope: 1.0 / white,
            intercept: 0.0,
        },
        spacing: None,
        spatial_unit: None,
    })
}

/// A picture's colours as linear ones over a plane.
///
/// # Errors
/// It cannot be read.
pub fn read_picture_colors(path: &Path) -> Result<ColorVolume, VolumeError> {
    let picture = decode(path)?.into_rgb32f();
    let dims = UVec2::new(picture.width(), picture.height());
    let linear: Vec<[f32; 3]> = picture
        .pixels()
        .map(|p| p.0.map(linear_from_srgb))
        .collect();
    let colors = upwards(&linear, dims);
    Ok(ColorVolume::new(
        &name_of(path),
        UVec3::new(dims.x, dims.y, 1),
        &colors,
    ))
}

pub(super) fn name_of(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default();
    name.to_string_lossy().into_owned()
}

fn decode(path: &Path) -> Result<DynamicImage, VolumeError> {
    let (file, _): (File, u64) = open_regular(path)?;
    let broken = |e: image::ImageError| {
        VolumeError::field(
            path,
            "picture",
            e.to_string(),
            "a PNG picture that can be decoded",
        )
    };
    let decoder = PngDecoder::new(BufReader::new(file)).map_err(broken)?;
    let (width, height) = decoder.dimensions();
    let size = u64::from(width) * u64::from(height);
    if !(1..=MAX_PIXELS).contains(&size) {
        let found = format!("{width} x {height} pixels");
        let expected = format!("1 to {MAX_PIXELS} in all");
        return Err(VolumeError::field(path, "picture", found, expected));
    }
    DynamicImage::from_decoder(decoder).map_err(broken)
}

/// The rows of a picture from its lower edge upwards.
pub(super) fn upwards<T: Copy>(pixels: &[T], dims: UVec2) -> Vec<T> {
    let rows = pixels.chunks_exact(dims.x as usize).rev();
    rows.flat_map(|row| row.iter().copied()).collect()
}
