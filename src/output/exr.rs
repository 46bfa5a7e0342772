//! OpenEXR: the radiance as rendered, 32-bit float RGBA, losslessly compressed.
//!
//! The colour keeps the background, `L + T L_b`, so over a black background it is the
//! premultiplied colour that OpenEXR asks for. Primaries are those of Rec.709. Attributes beyond
//! the standard ones are named `tyndall.KEY`. Their order in the header is not fixed, so two files
//! of the same image hold the same pixels but may differ in bytes.

use std::fs::File;
use std::io::{self, BufReader, Seek};
use std::path::Path;

use ::exr::error::Error;
use ::exr::math::Vec2;
use ::exr::meta::MetaData;
use ::exr::meta::attribute::{AttributeValue, Chromaticities, LineOrder, Text};
use ::exr::prelude::{
    Blocks, Compression, Encoding, Image as ExrImage, Layer, LayerAttributes, ReadChannels,
    ReadLayers, SpecificChannels, WritableImage,
};

use super::{Image, MAX_PIXELS, Metadata, OutputError, SOFTWARE, atomic};

/// Keeps our attributes apart from the standard ones, some of which have the same names.
const PREFIX: &str = "tyndall.";

/// What the numbers are, for whoever opens the file.
const COMMENT: &str = "Linear radiance, Rec.709 primaries, background included. \
     Alpha is 1 - transmittance of the volume. No exposure and no tone map are applied.";

/// Rec.709 primaries and D65.
const REC_709: Chromaticities = Chromaticities {
    red: Vec2(0.64, 0.33),
    green: Vec2(0.30, 0.60),
    blue: Vec2(0.15, 0.06),
    white: Vec2(0.3127, 0.3290),
};

/// Writes an image bit for bit, NaNs included, with `metadata` as text attributes.
///
/// # Errors
///
/// When the image is empty or incomplete, a key is too long, or [`atomic::write`] fails.
pub fn write(path: &Path, image: &Image, metadata: &Metadata) -> Result<(), OutputError> {
    image.check(path)?;
    let width = image.width as usize;
    let pixels = SpecificChannels::rgba(|Vec2(x, y): Vec2<usize>| {
        let [r, g, b, a] = image.pixels[y * width + x];
        (r, g, b, a)
    });
    let encoding = Encoding {
        compression: Compression::ZIP16,
        blocks: Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let size = (width, image.height as usize);
    let layer = Layer::new(size, attributes(metadata), encoding, pixels);
    let mut file = ExrImage::from_layer(layer);
    file.attributes.chromaticities = Some(REC_709);
    atomic::write(path, |buffer| {
        file.write().to_buffered(buffer).map_err(into_io)
    })
}

fn attributes(metadata: &Metadata) -> LayerAttributes {
    let mut attributes = LayerAttributes {
        software_name: Some(text(SOFTWARE)),
        comments: Some(text(COMMENT)),
        ..LayerAttributes::default()
    };
    for (key, value) in metadata {
        let name = text(&format!("{PREFIX}{key}"));
        let value = AttributeValue::Text(text(value));
        attributes.other.insert(name, value);
    }
    attributes
}

/// UTF-8 bytes as they are: what readers expect, and beyond what the crate's own constructor takes.
fn text(string: &str) -> Text {
    Text::from_bytes_unchecked(string.bytes().collect())
}

/// Reads the first layer that has R, G and B, of any sample type; alpha is 1 where there is none.
///
/// # Errors
///
/// When the file cannot be opened, is no OpenEXR file, is damaged, has no RGB layer or more than
/// [`MAX_PIXELS`].
pub fn read(path: &Path) -> Result<Image, OutputError> {
    let mut file = open(path)?;
    check_size(path, &read_header(path, &mut file)?)?;
    file.rewind().map_err(|e| into_error(path, e.into()))?;
    let image = ::exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .rgba_channels(
            |size, _| Image {
                width: size.width() as u32,
                height: size.height() as u32,
                pixels: vec![[0.0; 4]; size.area()],
            },
            |image: &mut Image, Vec2(x, y), (r, g, b, a): (f32, f32, f32, f32)| {
                image.pixels[y * image.width as usize + x] = [r, g, b, a];
            },
        )
        .first_valid_layer()
        .all_attributes()
        .from_buffered(file)
        .map_err(|e| into_error(path, e))?;
    Ok(image.layer_data.channel_data.pixels)
}

/// The attributes that [`write()`] made from its `metadata`.
///
/// # Errors
///
/// When the file cannot be opened or is no OpenEXR file.
pub fn read_metadata(path: &Path) -> Result<Metadata, OutputError> {
    let header = read_header(path, &mut open(path)?)?;
    let attributes = header.headers.iter().flat_map(|h| &h.own_attributes.other);
    let ours = attributes.filter_map(|(name, value)| {
        let name = String::from_utf8_lossy(name.bytes());
        let key = name.strip_prefix(PREFIX)?;
        match value {
            AttributeValue::Text(text) => {
                let value = String::from_utf8_lossy(text.bytes());
                Some((key.to_owned(), value.into_owned()))
            }
            _ => None,
        }
    });
    Ok(ours.collect())
}

fn open(path: &Path) -> Result<BufReader<File>, OutputError> {
    let file = File::open(path).map_err(|source| OutputError::Io {
        path: path.to_owned(),
        action: "open",
        source,
    })?;
    Ok(BufReader::new(file))
}

fn read_header(path: &Path, file: &mut BufReader<File>) -> Result<MetaData, OutputError> {
    MetaData::read_from_buffered(file, false).map_err(|e| into_error(path, e))
}

fn check_size(path: &Path, header: &MetaData) -> Result<(), OutputError> {
    for header in &header.headers {
        let Vec2(width, height) = header.layer_size;
        if width as u64 * height as u64 > MAX_PIXELS {
            let reason = format!("{width} x {height} pixels are too many").into();
            return Err(into_error(path, Error::Invalid(reason)));
        }
    }
    Ok(())
}

fn into_io(error: Error) -> io::Error {
    match error {
        Error::Io(error) => error,
        other => io::Error::other(other),
    }
}

fn into_error(path: &Path, error: Error) -> OutputError {
    OutputError::Content {
        path: path.to_owned(),
        format: "OpenEXR",
        reason: error.to_string(),
    }
}
