//! Maps from PNG pictures. A picture's upper edge is that of largest y.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use glam::UVec2;
use image::codecs::png::PngDecoder;
use image::{DynamicImage, ImageDecoder};

use super::source::open_regular;
use super::{ColorVolume, HeightMap, Rescale, VolumeError, Voxels};
use crate::output::MAX_PIXELS;
use crate::scene::linear_from_srgb;

/// Whether a file of these first eight bytes is a PNG picture.
pub(super) fn is_png(first: &[u8]) -> bool {
    first == b"\x89PNG\r\n\x1a\n"
}

/// A grey picture of 8 or 16 bits; black is 0, white 1.
///
/// # Errors
/// It cannot be read, or has colours.
pub(super) fn read_grey(path: &Path) -> Result<HeightMap, VolumeError> {
    let picture = decode(path, None)?;
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

/// A picture's colours as linear ones over a plane of `dims` columns.
///
/// # Errors
/// It cannot be read, or has other dimensions: told before it is decoded.
pub fn read_picture_colors(path: &Path, dims: UVec2) -> Result<ColorVolume, VolumeError> {
    let picture = decode(path, Some(dims))?.into_rgb32f();
    let rows = picture.as_raw().chunks_exact(3 * dims.x as usize).rev();
    let colors: Vec<[f32; 3]> = rows
        .flat_map(|row| row.chunks_exact(3))
        .map(|c| [c[0], c[1], c[2]].map(linear_from_srgb))
        .collect();
    Ok(ColorVolume::new(&name_of(path), dims.extend(1), &colors))
}

pub(super) fn name_of(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default();
    name.to_string_lossy().into_owned()
}

fn decode(path: &Path, wanted: Option<UVec2>) -> Result<DynamicImage, VolumeError> {
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
    if let Some(d) = wanted.filter(|d| *d != UVec2::new(width, height)) {
        let found = format!("{width} x {height} pixels");
        let expected = format!("the {} x {} of the map that it colours", d.x, d.y);
        return Err(VolumeError::field(path, "picture", found, expected));
    }
    DynamicImage::from_decoder(decoder).map_err(broken)
}

/// The rows of a picture from its lower edge upwards.
pub(super) fn upwards<T: Copy>(pixels: &[T], dims: UVec2) -> Vec<T> {
    let rows = pixels.chunks_exact(dims.x as usize).rev();
    rows.flat_map(|row| row.iter().copied()).collect()
}
