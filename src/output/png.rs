//! PNG: what a display shows, 8 or 16 bits, sRGB, with the settings that made it as text.

use std::fs::File;
use std::io::{self, BufReader, BufWriter};
use std::path::Path;

use png::{ColorType, Decoder, Encoder, Info, Reader, SrgbRenderingIntent, Transformations};

use super::image::{level_8, level_16};
use super::tone_map::{Alpha, ToneMapping, to_display};
use super::{Display, Image, MAX_PIXELS, Metadata, OutputError, SOFTWARE, atomic};
use crate::scene::ToneMap;

/// Bits a channel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BitDepth {
    /// 256 levels.
    #[default]
    Eight,
    /// 65536 levels.
    Sixteen,
}

/// How an image becomes a PNG.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PngOptions {
    /// Bits a channel.
    pub bit_depth: BitDepth,
    /// Whether the background stays in or alpha is stored.
    pub alpha: Alpha,
    /// Exposure and curve.
    pub tone_mapping: ToneMapping,
}

/// Tone-maps an image and writes it, RGB or, with [`Alpha::Straight`], RGBA.
///
/// The text chunks are `Software`, `Exposure`, `Tone map` and `metadata`.
///
/// # Errors
///
/// When the image is empty or incomplete, a key of `metadata` is no PNG keyword, or
/// [`atomic::write`] fails.
pub fn write(
    path: &Path,
    image: &Image,
    options: &PngOptions,
    metadata: &Metadata,
) -> Result<(), OutputError> {
    image.check(path)?;
    let mapping = options.tone_mapping;
    let mut texts = metadata.clone();
    texts.insert("Software".to_owned(), SOFTWARE.to_owned());
    texts.insert("Exposure".to_owned(), format!("{:+} stops", mapping.stops));
    texts.insert(
        "Tone map".to_owned(),
        operator_name(mapping.operator).to_owned(),
    );
    let display = to_display(image, &mapping, options.alpha);
    let has_alpha = options.alpha != Alpha::Opaque;
    write_display(path, &display, options.bit_depth, has_alpha, &texts)
}

/// Writes display values as they are, each rounded to the nearest level.
///
/// # Errors
///
/// As [`write()`].
pub fn write_display(
    path: &Path,
    display: &Display,
    bit_depth: BitDepth,
    has_alpha: bool,
    texts: &Metadata,
) -> Result<(), OutputError> {
    display.check(path)?;
    let bytes = encode_samples(&display.pixels, bit_depth, has_alpha);
    atomic::write(path, |file| {
        let mut encoder = Encoder::new(file, display.width, display.height);
        encoder.set_color(if has_alpha {
            ColorType::Rgba
        } else {
            ColorType::Rgb
        });
        encoder.set_depth(match bit_depth {
            BitDepth::Eight => png::BitDepth::Eight,
            BitDepth::Sixteen => png::BitDepth::Sixteen,
        });
        encoder.set_source_srgb(SrgbRenderingIntent::RelativeColorimetric);
        add_texts(&mut encoder, texts)?;
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&bytes)?;
        writer.finish()?;
        Ok(())
    })
}

/// Plain ASCII goes into `tEXt`, which everything reads; the rest needs the UTF-8 of `iTXt`.
fn add_texts(encoder: &mut Encoder<&mut BufWriter<File>>, texts: &Metadata) -> io::Result<()> {
    for (keyword, text) in texts {
        let (keyword, text) = (keyword.clone(), text.clone());
        if text.is_ascii() {
            encoder.add_text_chunk(keyword, text)?;
        } else {
            encoder.add_itxt_chunk(keyword, text)?;
        }
    }
    Ok(())
}

/// Samples in the order and byte order of the file.
fn encode_samples(pixels: &[[f32; 4]], bit_depth: BitDepth, has_alpha: bool) -> Vec<u8> {
    let channels = if has_alpha { 4 } else { 3 };
    let mut bytes = Vec::with_capacity(pixels.len() * channels * 2);
    for pixel in pixels {
        match bit_depth {
            BitDepth::Eight => {
                let levels = hide_invisible(pixel.map(level_8), has_alpha);
                bytes.extend_from_slice(&levels[..channels]);
            }
            BitDepth::Sixteen => {
                let levels = hide_invisible(pixel.map(level_16), has_alpha);
                let big_endian = levels[..channels].iter().flat_map(|v| v.to_be_bytes());
                bytes.extend(big_endian);
            }
        }
    }
    bytes
}

/// Black where alpha rounds to 0: dividing by such an alpha leaves only noise in the colour.
fn hide_invisible<T: Default + Copy + PartialEq>(levels: [T; 4], has_alpha: bool) -> [T; 4] {
    if has_alpha && levels[3] == T::default() {
        return [T::default(); 4];
    }
    levels
}

fn operator_name(operator: ToneMap) -> &'static str {
    match operator {
        ToneMap::Clamp => "clamp",
        ToneMap::Reinhard => "reinhard",
        ToneMap::Filmic => "filmic",
    }
}

/// Reads any PNG (grey, palette, RGB; 1 to 16 bits) as display values with straight alpha.
///
/// Values are taken as sRGB; colour profiles in the file are not applied.
///
/// # Errors
///
/// When the file cannot be opened, is no PNG, is damaged, or has more than [`MAX_PIXELS`].
pub fn read(path: &Path) -> Result<Display, OutputError> {
    let mut reader = open(path)?;
    let (width, height) = (reader.info().width, reader.info().height);
    let size = reader
        .output_buffer_size()
        .filter(|_| u64::from(width) * u64::from(height) <= MAX_PIXELS)
        .ok_or_else(|| content(path, format!("{width} x {height} pixels are too many")))?;
    let mut bytes = vec![0; size];
    let frame = reader
        .next_frame(&mut bytes)
        .map_err(|e| content(path, e.to_string()))?;
    let samples: Vec<f32> = match frame.bit_depth {
        png::BitDepth::Sixteen => bytes
            .chunks_exact(2)
            .map(|v| f32::from(u16::from_be_bytes([v[0], v[1]])) / 65535.0)
            .collect(),
        _ => bytes.iter().map(|&v| f32::from(v) / 255.0).collect(),
    };
    let pixels = samples
        .chunks_exact(frame.color_type.samples())
        .map(rgba)
        .collect();
    Ok(Display {
        width,
        height,
        pixels,
    })
}

/// One pixel from the 1 to 4 samples that a colour type stores.
fn rgba(samples: &[f32]) -> [f32; 4] {
    match *samples {
        [y] => [y, y, y, 1.0],
        [y, a] => [y, y, y, a],
        [r, g, b] => [r, g, b, 1.0],
        [r, g, b, a, ..] => [r, g, b, a],
        [] => [0.0; 4],
    }
}

/// The texts of a PNG that stand before its pixels, as [`write()`] puts them.
///
/// # Errors
///
/// When the file cannot be opened or is no PNG.
pub fn read_metadata(path: &Path) -> Result<Metadata, OutputError> {
    let reader = open(path)?;
    texts(reader.info()).map_err(|e| content(path, e.to_string()))
}

fn texts(info: &Info) -> Result<Metadata, png::DecodingError> {
    let mut texts = Metadata::new();
    for chunk in &info.uncompressed_latin1_text {
        texts.insert(chunk.keyword.clone(), chunk.text.clone());
    }
    for chunk in &info.compressed_latin1_text {
        texts.insert(chunk.keyword.clone(), chunk.get_text()?);
    }
    for chunk in &info.utf8_text {
        texts.insert(chunk.keyword.clone(), chunk.get_text()?);
    }
    Ok(texts)
}

fn open(path: &Path) -> Result<Reader<BufReader<File>>, OutputError> {
    let file = File::open(path).map_err(|source| OutputError::Io {
        path: path.to_owned(),
        action: "open",
        source,
    })?;
    let mut decoder = Decoder::new(BufReader::new(file));
    decoder.set_transformations(Transformations::EXPAND);
    decoder
        .read_info()
        .map_err(|e| content(path, e.to_string()))
}

fn content(path: &Path, reason: String) -> OutputError {
    OutputError::Content {
        path: path.to_owned(),
        format: "PNG",
        reason,
    }
}
