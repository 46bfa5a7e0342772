//! The variances of an image, in the same file.

use std::io::Seek;
use std::path::Path;

use ::exr::error::Error;
use ::exr::math::Vec2;
use ::exr::meta::MetaData;
use ::exr::meta::header::Header;
use ::exr::prelude::{ReadChannels, ReadLayers, SpecificChannels, WritableImage};

use super::{check_size, file, into_error, into_io, open, read_header};
use crate::output::{Image, Metadata, OutputError, Variance, atomic};

/// The layer of the variances; its channels are named `variance.R` and so on.
pub(super) const LAYER: &str = "variance";

/// As [`write()`](super::write()), with the variances of the image in the same file, bit for bit
/// as well.
///
/// # Errors
///
/// As [`write()`](super::write()), and when there is not one variance for each pixel.
pub fn write_with_variance(
    path: &Path,
    image: &Image,
    variance: &Variance,
    metadata: &Metadata,
) -> Result<(), OutputError> {
    image.check(path)?;
    variance.check(path, image)?;
    let width = image.width as usize;
    let name = |channel: &str| format!("{LAYER}.{channel}");
    // In the order of the file, which sorts channels by name.
    let channels = SpecificChannels::build()
        .with_channel::<f32>("A")
        .with_channel::<f32>("B")
        .with_channel::<f32>("G")
        .with_channel::<f32>("R")
        .with_channel::<f32>(name("B").as_str())
        .with_channel::<f32>(name("G").as_str())
        .with_channel::<f32>(name("R").as_str())
        .with_pixel_fn(|Vec2(x, y): Vec2<usize>| {
            let index = y * width + x;
            let ([r, g, b, a], [vr, vg, vb]) = (image.pixels[index], variance.pixels[index]);
            (a, b, g, r, vb, vg, vr)
        });
    let file = file(image, channels, metadata);
    atomic::write(path, |buffer| {
        file.write().to_buffered(buffer).map_err(into_io)
    })
}

/// Reads the variances that [`write_with_variance`] stored; `None` where the file has none.
///
/// The channels R, G and B of a part of its own named `variance` are taken too.
///
/// # Errors
///
/// As [`read()`](super::read()), and when a channel of the three is missing or has another size.
pub fn read_variance(path: &Path) -> Result<Option<Variance>, OutputError> {
    let mut file = open(path)?;
    let header = read_header(path, &mut file)?;
    check_size(path, &header)?;
    let Some((part, names)) = variance_channels(&header) else {
        return Ok(None);
    };
    file.rewind().map_err(|e| into_error(path, e.into()))?;
    let image = ::exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes()
        .from_buffered(file)
        .map_err(|e| into_error(path, e))?;
    let missing = |name: &str| {
        let reason = format!(
            "found a layer `{LAYER}` without a full-size channel {name}, expected all of R, G, B"
        );
        into_error(path, Error::Invalid(reason.into()))
    };
    let layer = image.layer_data.get(part);
    let layer = layer.ok_or_else(|| missing(&names[0]))?;
    let pixels = layer.size.area();
    let mut variance = vec![[0.0; 3]; pixels];
    for (i, name) in names.iter().enumerate() {
        let mut channels = layer.channel_data.list.iter();
        let found = channels.find(|c| c.name.eq(name.as_str()) && c.sample_data.len() == pixels);
        let samples = &found.ok_or_else(|| missing(name))?.sample_data;
        for (pixel, value) in variance.iter_mut().zip(samples.values_as_f32()) {
            pixel[i] = value;
        }
    }
    Ok(Some(Variance { pixels: variance }))
}

/// The part that holds the variances and the names of red, green and blue in it.
fn variance_channels(file: &MetaData) -> Option<(usize, [String; 3])> {
    let rgb = ["R", "G", "B"];
    let prefix = format!("{LAYER}.");
    file.headers.iter().enumerate().find_map(|(part, header)| {
        let names = || header.channels.list.iter().map(|c| c.name.to_string());
        if names().any(|n| n.starts_with(&prefix)) {
            return Some((part, rgb.map(|c| format!("{prefix}{c}"))));
        }
        is_part(header).then(|| (part, rgb.map(str::to_owned)))
    })
}

/// Whether this part is the layer, as other programs may write it.
pub(super) fn is_part(header: &Header) -> bool {
    let name = header.own_attributes.layer_name.as_ref();
    name.is_some_and(|name| name.eq(LAYER))
}
