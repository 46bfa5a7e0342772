//! OpenEXR: the radiance as rendered, 32-bit float RGBA, losslessly compressed.
//!
//! The colour keeps the background, `L + T L_b`, so over a black background it is the
//! premultiplied colour that OpenEXR asks for. Primaries are those of Rec.709. Attributes beyond
//! the standard ones are named `tyndall.KEY`. Their order in the header is not fixed, so two files
//! of the same image hold the same pixels but may differ in bytes.
//!
//! Beside R, G, B and A a file can hold `variance.R`, `variance.G` and `variance.B`: the variance
//! of each pixel's mean, 32-bit float ([`write_with_variance`], [`read_variance`]).

mod variance;

use std::fs::File;
use std::io::{self, BufReader, Seek};
use std::path::Path;

use ::exr::error::Error;
use ::exr::image::write::channels::WritableChannels;
use ::exr::math::Vec2;
use ::exr::meta::MetaData;
use ::exr::meta::attribute::{AttributeValue, Chromaticities, LineOrder, Text};
use ::exr::meta::header::Header;
use ::exr::prelude::{
    Blocks, Compression, Encoding, Image as ExrImage, Layer, LayerAttributes, ReadChannels,
    ReadLayers, SpecificChannels, WritableImage,
};

use self::variance::LAYER;
use super::{Image, MAX_PIXELS, Metadata, OutputError, SOFTWARE, atomic};

pub use self::variance::{read_variance, write_with_variance};

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
    let channels = SpecificChannels::rgba(|Vec2(x, y): Vec2<usize>| {
        let [r, g, b, a] = image.pixels[y * width + x];
        (r, g, b, a)
    });
    let file = file(image, channels, metadata);
    atomic::write(path, |buffer| {
        file.write().to_buffered(buffer).map_err(into_io)
    })
}

/// All but the pixels: encoding, attributes, primaries.
fn file<'c, C: WritableChannels<'c> + 'c>(
    image: &Image,
    channels: C,
    metadata: &Metadata,
) -> ExrImage<Layer<C>> {
    let encoding = Encoding {
        compression: Compression::ZIP16,
        blocks: Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let size = (image.width as usize, image.height as usize);
    let layer = Layer::new(size, attributes(metadata), encoding, channels);
    let mut file = ExrImage::from_layer(layer);
    file.attributes.chromaticities = Some(REC_709);
    file
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
    let header = read_header(path, &mut file)?;
    check_size(path, &header)?;
    check_colour(path, &header)?;
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

/// An error that lists the channels there are, unless the first part with R, G and B is colour.
fn check_colour(path: &Path, file: &MetaData) -> Result<(), OutputError> {
    let has = |h: &Header, name| h.channels.list.iter().any(|c| c.name.eq(name));
    let is_rgb = |h: &&Header| ["R", "G", "B"].iter().all(|name| has(h, name));
    let reason = match file.headers.iter().find(is_rgb) {
        Some(h) if variance::is_part(h) => {
            format!("found the part `{LAYER}` first, expected that with the colour before it")
        }
        Some(_) => return Ok(()),
        None => {
            let channels = file.headers.iter().flat_map(|h| &h.channels.list);
            let names: Vec<_> = channels.map(|c| c.name.to_string()).collect();
            format!(
                "found the channels {}, expected R, G and B",
                names.join(", ")
            )
        }
    };
    Err(into_error(path, Error::Invalid(reason.into())))
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
