//! The variance layer of an EXR: what goes in comes back, beside the colour.
#![allow(clippy::unwrap_used, clippy::panic)]

use tempfile::TempDir;
use tyndall::output::{Image, Metadata, OutputError, Variance, exr};

fn image() -> Image {
    let pixel = |i: u32| [i as f32 * 0.1, 1.0 / (i + 1) as f32, -0.0, 0.5];
    Image {
        width: 33,
        height: 17,
        pixels: (0..33 * 17).map(pixel).collect(),
    }
}

#[test]
fn an_exr_keeps_every_bit_of_colour_and_variance() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("noisy.exr");
    let image = image();
    let odd = |i: usize| {
        [
            i as f32 * 1e-9,
            f32::from_bits(i as u32),
            1e30 / (i + 1) as f32,
        ]
    };
    let variance = Variance {
        pixels: (0..image.pixels.len()).map(odd).collect(),
    };
    let metadata = Metadata::from([("technique".to_owned(), "path_trace".to_owned())]);
    exr::write_with_variance(&path, &image, &variance, &metadata).unwrap();
    assert_eq!(exr::read(&path).unwrap(), image);
    let found = exr::read_variance(&path).unwrap().unwrap();
    let bits = |v: &Variance| -> Vec<_> { v.pixels.iter().map(|p| p.map(f32::to_bits)).collect() };
    assert_eq!(bits(&found), bits(&variance));
    assert_eq!(exr::read_metadata(&path).unwrap(), metadata);

    exr::write(&path, &image, &metadata).unwrap();
    assert_eq!(exr::read_variance(&path).unwrap(), None);
}

#[test]
fn variances_of_another_size_are_not_written() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("noisy.exr");
    let short = Variance {
        pixels: vec![[1.0; 3]; 5],
    };
    let error = exr::write_with_variance(&path, &image(), &short, &Metadata::new()).unwrap_err();
    assert!(matches!(error, OutputError::Size { .. }), "{error}");
    assert!(!path.exists());
    assert!(exr::read_variance(&path).is_err());
}

/// Files by other programs: a part of its own for the variance, or a channel left out.
#[test]
fn variances_are_found_in_a_part_of_their_own() {
    use ::exr::prelude::*;
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("parts.exr");
    let layer = |name: &str, channels: &[&str], value: f32| {
        let channel = |c: &&str| AnyChannel::new(*c, FlatSamples::F32(vec![value; 6]));
        Layer::new(
            (3, 2),
            LayerAttributes::named(name),
            Encoding::FAST_LOSSLESS,
            AnyChannels::sort(channels.iter().map(channel).collect()),
        )
    };
    let write = |layers: [Layer<AnyChannels<FlatSamples>>; 2]| {
        let attributes = ImageAttributes::new(IntegerBounds::from_dimensions((3, 2)));
        let image = ::exr::image::Image::from_layers(attributes, layers.to_vec());
        image.write().to_file(&path).unwrap();
    };
    let colour = || layer("colour", &["R", "G", "B"], 0.5);
    write([colour(), layer("variance", &["R", "G", "B"], 0.25)]);
    assert_eq!(exr::read(&path).unwrap().pixels, [[0.5, 0.5, 0.5, 1.0]; 6]);
    let found = exr::read_variance(&path).unwrap().unwrap();
    assert_eq!(found.pixels, [[0.25; 3]; 6]);

    write([layer("variance", &["R", "G", "B"], 0.25), colour()]);
    let error = exr::read(&path).unwrap_err().to_string();
    assert!(error.contains("part `variance` first"), "{error}");

    write([colour(), layer("variance", &["R", "G"], 0.25)]);
    let error = exr::read_variance(&path).unwrap_err().to_string();
    assert!(
        error.contains("parts.exr") && error.contains("channel B"),
        "{error}"
    );
}
