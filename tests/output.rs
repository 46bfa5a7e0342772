//! Result files: what goes in comes back, and nothing is ever half there.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use std::fs;
use std::io::{self, Write};
use std::path::Path;

use glam::Vec3;
use rand::{RngExt, SeedableRng};
use tempfile::TempDir;
use tyndall::output::difference::{self, Difference};
use tyndall::output::png::{BitDepth, PngOptions};
use tyndall::output::tone_map::{self, Alpha, ToneMapping};
use tyndall::output::{Display, Image, Metadata, OutputError, SOFTWARE, atomic, exr, json, png};
use tyndall::scene::{Exposure, ToneMap};

const OPERATORS: [ToneMap; 3] = [ToneMap::Clamp, ToneMap::Reinhard, ToneMap::Filmic];

/// 1 x 1, one row, one column, odd, and more rows than one block of the EXR's compression.
const SIZES: [(u32, u32); 5] = [(1, 1), (257, 1), (1, 257), (33, 17), (641, 479)];

fn noise(width: u32, height: u32) -> Image {
    let mut random = rand_pcg::Pcg64::seed_from_u64(u64::from(width) << 32 | u64::from(height));
    let mut pixel = || {
        let alpha: f32 = random.random();
        let scale = 4.0 * alpha;
        [
            scale * random.random::<f32>(),
            scale * random.random::<f32>(),
            scale * random.random::<f32>(),
            alpha,
        ]
    };
    let pixels = (0..width * height).map(|_| pixel()).collect();
    Image {
        width,
        height,
        pixels,
    }
}

fn one(pixel: [f32; 4]) -> Image {
    Image {
        width: 1,
        height: 1,
        pixels: vec![pixel],
    }
}

fn metadata() -> Metadata {
    let scene = "# Größe: ½ \"voxel\"\n[medium]\ndensity_scale = 2.0\n".repeat(100);
    [
        ("scene", scene.as_str()),
        ("device", "llvmpipe (LLVM 19.1.7, 256 bits)"),
        ("driver", "Mesa 25.0.7"),
        ("technique", "ray_march"),
    ]
    .map(|(key, value)| (key.to_owned(), value.to_owned()))
    .into()
}

fn bits(image: &Image) -> Vec<[u32; 4]> {
    image.pixels.iter().map(|p| p.map(f32::to_bits)).collect()
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<_> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

// --- EXR ---

#[test]
fn exr_keeps_every_bit() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("image.exr");
    for (width, height) in SIZES {
        let image = noise(width, height);
        exr::write(&path, &image, &metadata()).unwrap();
        assert_eq!(exr::read(&path).unwrap(), image, "{width} x {height}");
    }
    let nan = f32::from_bits(0x7fc0_1234);
    let extremes = one([nan, f32::NEG_INFINITY, -0.0, f32::from_bits(1)]);
    exr::write(&path, &extremes, &Metadata::new()).unwrap();
    assert_eq!(bits(&exr::read(&path).unwrap()), bits(&extremes));
    assert_eq!(names(folder.path()), ["image.exr"]);
}

#[test]
fn exr_keeps_metadata() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("image.exr");
    let mut metadata = metadata();
    // Names of standard attributes must not collide, long keys must not be cut.
    metadata.insert("compression".to_owned(), "none".to_owned());
    metadata.insert("k".repeat(60), String::new());
    exr::write(&path, &noise(3, 2), &metadata).unwrap();
    assert_eq!(exr::read_metadata(&path).unwrap(), metadata);

    let bytes = fs::read(&path).unwrap();
    for word in [SOFTWARE, "chromaticities", "Linear radiance"] {
        let found = bytes.windows(word.len()).any(|w| w == word.as_bytes());
        assert!(found, "{word} is not in the header");
    }
}

#[test]
fn exr_refuses_what_it_cannot_store() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("image.exr");
    let too_long = Metadata::from([("k".repeat(300), String::new())]);
    let error = exr::write(&path, &noise(2, 2), &too_long).unwrap_err();
    assert!(matches!(error, OutputError::Io { .. }), "{error}");
    assert!(names(folder.path()).is_empty());
}

#[test]
fn damaged_files_are_errors_that_name_the_file() {
    let folder = TempDir::new().unwrap();
    let exr_path = folder.path().join("cut.exr");
    exr::write(&exr_path, &noise(33, 17), &Metadata::new()).unwrap();
    let png_path = folder.path().join("cut.png");
    png::write(
        &png_path,
        &noise(33, 17),
        &PngOptions::default(),
        &Metadata::new(),
    )
    .unwrap();
    for path in [&exr_path, &png_path] {
        let bytes = fs::read(path).unwrap();
        fs::write(path, &bytes[..bytes.len() / 2]).unwrap();
    }
    for error in [
        exr::read(&exr_path).unwrap_err(),
        png::read(&png_path).unwrap_err(),
        exr::read(&png_path).unwrap_err(),
        png::read(&exr_path).unwrap_err(),
        png::read_metadata(&exr_path).unwrap_err(),
        exr::read_metadata(&png_path).unwrap_err(),
    ] {
        assert!(matches!(error, OutputError::Content { .. }), "{error}");
        assert!(error.to_string().contains("cut."), "{error}");
    }
    let absent = folder.path().join("absent");
    for error in [
        exr::read(&absent).unwrap_err(),
        png::read(&absent).unwrap_err(),
    ] {
        assert!(
            matches!(error, OutputError::Io { action: "open", .. }),
            "{error}"
        );
    }
}

// --- PNG ---

fn assert_near(found: &Display, expected: &Display, levels: f32, channels: usize) {
    let size = (expected.width, expected.height);
    assert_eq!((found.width, found.height), size);
    for (a, b) in found.pixels.iter().zip(&expected.pixels) {
        for channel in 0..channels {
            let distance = (a[channel] - b[channel]).abs();
            // Half a level, and what 32-bit floats lose on the way there and back.
            assert!(distance <= 0.5 / levels + 2e-7, "{a:?} {b:?}");
        }
    }
}

#[test]
fn png_is_within_half_a_level() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("image.png");
    for (bit_depth, levels) in [(BitDepth::Eight, 255.0), (BitDepth::Sixteen, 65535.0)] {
        for operator in OPERATORS {
            for (width, height) in SIZES {
                let image = noise(width, height);
                let tone_mapping = ToneMapping {
                    stops: -1.5,
                    operator,
                };
                let options = PngOptions {
                    bit_depth,
                    tone_mapping,
                    alpha: Alpha::Opaque,
                };
                png::write(&path, &image, &options, &Metadata::new()).unwrap();
                let expected = tone_map::to_display(&image, &tone_mapping, Alpha::Opaque);
                let found = png::read(&path).unwrap();
                assert_near(&found, &expected, levels, 4);
            }
        }
    }
    assert_eq!(names(folder.path()), ["image.png"]);
}

#[test]
fn png_keeps_straight_alpha() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("image.png");
    let image = noise(33, 17);
    let alpha = Alpha::Straight {
        background: Vec3::ZERO,
    };
    for (bit_depth, levels) in [(BitDepth::Eight, 255.0), (BitDepth::Sixteen, 65535.0)] {
        let options = PngOptions {
            bit_depth,
            alpha,
            ..PngOptions::default()
        };
        png::write(&path, &image, &options, &Metadata::new()).unwrap();
        let mut expected = tone_map::to_display(&image, &ToneMapping::default(), alpha);
        for pixel in &mut expected.pixels {
            if pixel[3] < 0.5 / levels {
                *pixel = [0.0; 4];
            }
        }
        assert_near(&png::read(&path).unwrap(), &expected, levels, 4);
    }
}

#[test]
fn png_states_how_it_was_made() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("image.png");
    let options = PngOptions {
        tone_mapping: ToneMapping {
            stops: 1.25,
            operator: ToneMap::Filmic,
        },
        ..PngOptions::default()
    };
    png::write(&path, &noise(3, 2), &options, &metadata()).unwrap();
    let found = png::read_metadata(&path).unwrap();
    assert_eq!(found["Software"], SOFTWARE);
    assert_eq!(found["Exposure"], "+1.25 stops");
    assert_eq!(found["Tone map"], "filmic");
    for (key, value) in metadata() {
        assert_eq!(found[&key], value);
    }
    let bytes = fs::read(&path).unwrap();
    assert!(bytes.windows(4).any(|w| w == b"sRGB"));
}

#[test]
fn png_is_the_same_every_time() {
    let folder = TempDir::new().unwrap();
    let [a, b] = ["a.png", "b.png"].map(|name| folder.path().join(name));
    for path in [&a, &b] {
        png::write(path, &noise(64, 64), &PngOptions::default(), &metadata()).unwrap();
    }
    assert_eq!(fs::read(a).unwrap(), fs::read(b).unwrap());
}

#[test]
fn pictures_without_pixels_for_every_position_are_refused() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("image");
    let missing = Image {
        pixels: Vec::new(),
        ..noise(2, 2)
    };
    for image in [Image::default(), missing] {
        for error in [
            exr::write(&path, &image, &Metadata::new()).unwrap_err(),
            png::write(&path, &image, &PngOptions::default(), &Metadata::new()).unwrap_err(),
        ] {
            assert!(matches!(error, OutputError::Size { .. }), "{error}");
        }
    }
    assert!(names(folder.path()).is_empty());
}

// --- Tone mapping ---

#[test]
fn operators_give_values_computed_by_hand() {
    let grey = |operator, x| tone_map::apply(operator, Vec3::splat(x)).x;
    for (operator, x, expected) in [
        (ToneMap::Clamp, 0.25, 0.25),
        (ToneMap::Clamp, 3.0, 1.0),
        (ToneMap::Reinhard, 1.0, 0.5),
        (ToneMap::Reinhard, 3.0, 0.75),
        // 0.5 (1.255 + 0.03) / (0.5 (1.215 + 0.59) + 0.14)
        (ToneMap::Filmic, 0.5, 0.6425 / 1.0425),
        // 2.54 / 3.16
        (ToneMap::Filmic, 1.0, 0.803_797_5),
        (ToneMap::Filmic, 1e30, 1.0),
        (ToneMap::Filmic, 0.0, 0.0),
    ] {
        let found = grey(operator, x);
        assert!((found - expected).abs() < 1e-6, "{operator:?} {x}: {found}");
    }
    // Luminance 0.2126 * 2; the hue stays.
    let red = tone_map::apply(ToneMap::Reinhard, Vec3::new(2.0, 0.0, 0.0));
    assert!(
        red.abs_diff_eq(Vec3::X, 1e-6),
        "2 / 1.4252 is cut to 1: {red}"
    );
    let brown = tone_map::apply(ToneMap::Reinhard, Vec3::new(0.4, 0.2, 0.1));
    let y = 0.2126 * 0.4 + 0.7152 * 0.2 + 0.0722 * 0.1;
    assert!(brown.abs_diff_eq(Vec3::new(0.4, 0.2, 0.1) / (1.0 + y), 1e-6));
}

#[test]
fn display_values_computed_by_hand() {
    let mapping = ToneMapping {
        stops: 1.0,
        operator: ToneMap::Clamp,
    };
    let display = tone_map::to_display(&one([0.09, 0.25, 0.001, 0.5]), &mapping, Alpha::Opaque);
    // sRGB of 0.18, 0.5 and, in the linear part, 0.002 * 12.92.
    let expected = [0.461_356, 0.735_357, 0.025_84, 1.0];
    for (a, b) in display.pixels[0].iter().zip(expected) {
        assert!((a - b).abs() < 1e-5, "{:?}", display.pixels[0]);
    }
    assert_eq!(display.levels(), [[118, 188, 7, 255]]);
}

#[test]
fn straight_alpha_takes_the_background_out() {
    let background = Vec3::new(0.5, 0.25, 2.0);
    let colour = Vec3::new(0.8, 0.1, 0.4);
    let alpha = 0.25;
    let pixel = alpha * colour + (1.0 - alpha) * background;
    let display = tone_map::to_display(
        &one([pixel.x, pixel.y, pixel.z, alpha]),
        &ToneMapping::default(),
        Alpha::Straight { background },
    );
    let expected = colour.to_array().map(tyndall::scene::srgb_from_linear);
    for (a, b) in display.pixels[0].iter().zip(expected) {
        assert!((a - b).abs() < 1e-5, "{:?}", display.pixels[0]);
    }
    assert_eq!(display.pixels[0][3], alpha);

    let empty = one([0.5, 0.25, 2.0, 0.0]);
    let shown = tone_map::to_display(
        &empty,
        &ToneMapping::default(),
        Alpha::Straight { background },
    );
    assert_eq!(shown.pixels, [[0.0; 4]]);
}

#[test]
fn operators_rise_and_stay_in_range() {
    for operator in OPERATORS {
        let mut last = 0.0_f32;
        for step in -400..400 {
            let x = (step as f32 * 0.05).exp2();
            let y = tone_map::apply(operator, Vec3::splat(x)).x;
            // One rounding error of slack where the curve is flat.
            assert!(
                (last - 1e-7..=1.0).contains(&y),
                "{operator:?} of {x}: {y} after {last}"
            );
            last = last.max(y);
        }
        for odd in [-1.0, f32::MIN, f32::MAX, f32::MIN_POSITIVE, -0.0] {
            let y = tone_map::apply(operator, Vec3::splat(odd)).x;
            assert!((0.0..=1.0).contains(&y), "{operator:?} of {odd}: {y}");
        }
    }
}

#[test]
fn pixels_that_are_not_finite_become_black() {
    let image = Image {
        width: 3,
        height: 1,
        pixels: vec![
            [f32::NAN, 1.0, 1.0, 1.0],
            [1.0, f32::INFINITY, 1.0, 1.0],
            [1.0, 1.0, 1.0, f32::NAN],
        ],
    };
    assert_eq!(image.non_finite(), 3);
    for alpha in [
        Alpha::Opaque,
        Alpha::Straight {
            background: Vec3::ONE,
        },
    ] {
        let display = tone_map::to_display(&image, &ToneMapping::default(), alpha);
        assert_eq!(display.pixels, [[0.0; 4]; 3]);
    }
    assert_eq!(tone_map::expose(&image, Exposure::Auto), 0.0);
}

// --- Exposure ---

#[test]
fn automatic_exposure_takes_the_99th_percentile_of_what_is_covered() {
    // Of 200 covered pixels the 198th is at the percentile: two brighter ones do not count.
    let mut pixels: Vec<_> = (0..197).map(|_| [0.01, 0.01, 0.01, 1.0]).collect();
    pixels.push([0.2, 0.2, 0.2, 0.5]);
    pixels.extend([[1000.0, 1000.0, 1000.0, 1.0]; 2]);
    pixels.extend([[50.0, 50.0, 50.0, 0.0]; 500]);
    pixels.push([f32::NAN, 1.0, 1.0, 1.0]);
    let image = Image {
        width: pixels.len() as u32,
        height: 1,
        pixels,
    };
    let stops = tone_map::expose(&image, Exposure::Auto);
    assert!((stops - 2.0).abs() < 1e-5, "0.2 * 4 = 0.8, found {stops}");
}

#[test]
fn exposure_of_odd_images() {
    let auto = |pixel| tone_map::expose(&one(pixel), Exposure::Auto);
    assert_eq!(tone_map::expose(&Image::default(), Exposure::Auto), 0.0);
    assert_eq!(auto([0.0, 0.0, 0.0, 1.0]), 0.0);
    assert_eq!(auto([1.0, 1.0, 1.0, 0.0]), 0.0);
    assert_eq!(auto([-1.0, -1.0, -1.0, 1.0]), 0.0);
    assert_eq!(auto([f32::MIN_POSITIVE; 4]), tone_map::MAX_AUTO_STOPS);
    assert_eq!(auto([1e30, 1e30, 1e30, 1.0]), -tone_map::MAX_AUTO_STOPS);
    // Green alone has 0.7152 of the luminance.
    let green = auto([0.0, 1.0, 0.0, 1.0]);
    assert!((green - (0.8_f32 / 0.7152).log2()).abs() < 1e-6);

    let given = |stops| tone_map::expose(&Image::default(), Exposure::Stops(stops));
    assert_eq!(given(-3.5), -3.5);
    assert_eq!(given(f32::NAN), 0.0);
    assert!(given(1e9).exp2().is_finite());
}

// --- JSON and atomic writing ---

#[test]
fn json_is_pretty_and_ends_with_a_newline() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("report.json");
    let value = serde_json::json!({ "device": "Größe", "bytes": u64::MAX, "times": [0.5] });
    json::write(&path, &value).unwrap();
    let text = fs::read_to_string(&path).unwrap();
    assert!(
        text.starts_with("{\n  \"") && text.ends_with("}\n"),
        "{text}"
    );
    assert_eq!(
        serde_json::from_str::<serde_json::Value>(&text).unwrap(),
        value
    );
}

#[test]
fn a_failed_write_leaves_nothing_new_and_everything_old() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("result");
    let fail = || {
        atomic::write(&path, |file| {
            file.write_all(&[0; 100_000])?;
            Err(io::Error::other("interrupted"))
        })
    };
    let panic = || {
        std::panic::catch_unwind(|| {
            atomic::write(&path, |file| {
                file.write_all(&[0; 100_000])?;
                panic!("interrupted")
            })
        })
    };
    let error = fail().unwrap_err();
    assert!(error.to_string().contains("result"), "{error}");
    assert!(error.to_string().contains("interrupted"), "{error}");
    panic().unwrap_err();
    assert!(names(folder.path()).is_empty());

    fs::write(&path, "old").unwrap();
    fail().unwrap_err();
    panic().unwrap_err();
    assert_eq!(fs::read_to_string(&path).unwrap(), "old");
    assert_eq!(names(folder.path()), ["result"]);

    atomic::write(&path, |file| file.write_all(b"new")).unwrap();
    assert_eq!(fs::read_to_string(&path).unwrap(), "new");
    assert_eq!(names(folder.path()), ["result"]);
}

#[test]
fn the_name_appears_only_when_all_is_written() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("result");
    atomic::write(&path, |file| {
        file.write_all(b"half")?;
        assert!(!path.exists());
        let temporary = &names(folder.path())[0];
        assert!(temporary.starts_with(".result.") && temporary.ends_with(".tmp"));
        Ok(())
    })
    .unwrap();
}

#[test]
fn writers_of_the_same_name_do_not_mix() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("result");
    std::thread::scope(|scope| {
        for letter in b'a'..b'i' {
            let path = &path;
            scope.spawn(move || atomic::write(path, |file| file.write_all(&[letter; 50_000])));
        }
    });
    let bytes = fs::read(&path).unwrap();
    assert_eq!(bytes, vec![bytes[0]; 50_000]);
    assert_eq!(names(folder.path()), ["result"]);
}

#[test]
fn places_that_cannot_be_written_are_named() {
    let folder = TempDir::new().unwrap();
    let write = |path: &Path| atomic::write(path, |_| Ok(())).unwrap_err();

    let lost = folder.path().join("no_such_folder").join("image.png");
    let error = write(&lost);
    assert!(
        matches!(error, OutputError::MissingFolder { .. }),
        "{error}"
    );
    assert!(
        error.to_string().contains("no_such_folder does not exist"),
        "{error}"
    );

    let error = write(folder.path());
    assert!(
        matches!(
            error,
            OutputError::NotReplaceable {
                found: "a folder",
                ..
            }
        ),
        "{error}"
    );

    let kept = folder.path().join("kept");
    fs::write(&kept, "old").unwrap();
    let mut permissions = fs::metadata(&kept).unwrap().permissions();
    permissions.set_readonly(true);
    fs::set_permissions(&kept, permissions).unwrap();
    let error = write(&kept);
    assert!(error.to_string().contains("a read-only file"), "{error}");
    assert_eq!(fs::read_to_string(&kept).unwrap(), "old");
}

#[cfg(unix)]
#[test]
fn links_devices_and_permissions_survive() {
    use std::os::unix::fs::{PermissionsExt, symlink};
    let error = atomic::write(Path::new("/dev/null"), |_| Ok(())).unwrap_err();
    assert!(
        matches!(error, OutputError::NotReplaceable { .. }),
        "{error}"
    );

    let folder = TempDir::new().unwrap();
    let (target, link) = (folder.path().join("target"), folder.path().join("link"));
    fs::write(&target, "old").unwrap();
    fs::set_permissions(&target, fs::Permissions::from_mode(0o600)).unwrap();
    symlink(&target, &link).unwrap();
    atomic::write(&link, |file| file.write_all(b"new")).unwrap();
    assert_eq!(fs::read_to_string(&target).unwrap(), "new");
    assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
    assert_eq!(
        fs::metadata(&target).unwrap().permissions().mode() & 0o777,
        0o600
    );
    assert_eq!(names(folder.path()), ["link", "target"]);
}

// --- Differences ---

fn display(levels: &[[u8; 4]]) -> Display {
    Display {
        width: levels.len() as u32,
        height: 1,
        pixels: levels
            .iter()
            .map(|p| p.map(|v| f32::from(v) / 255.0))
            .collect(),
    }
}

#[test]
fn differences_computed_by_hand() {
    let a = display(&[
        [10, 20, 30, 255],
        [0, 0, 0, 0],
        [255, 0, 0, 255],
        [7, 7, 7, 7],
    ]);
    let b = display(&[
        [12, 20, 30, 255],
        [0, 0, 0, 3],
        [0, 0, 0, 255],
        [7, 7, 7, 7],
    ]);
    let found = difference::compare(&a, &b, 2).unwrap();
    let rmse = ((4.0 + 9.0 + 255.0 * 255.0) / 16.0_f64).sqrt();
    assert_eq!(
        found,
        Difference {
            max_level: 255,
            pixels_beyond: 2,
            rmse
        }
    );
    assert_eq!(
        difference::compare(&a, &a, 0).unwrap(),
        Difference::default()
    );

    let picture = difference::picture(&a, &b, 10.0).unwrap();
    let expected = [
        [20, 0, 0, 255],
        [30, 30, 30, 255],
        [255, 0, 0, 255],
        [0, 0, 0, 255],
    ];
    assert_eq!(picture.levels(), expected);
}

#[test]
fn a_png_does_not_differ_from_what_was_written() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("golden.png");
    let shown = tone_map::to_display(&noise(33, 17), &ToneMapping::default(), Alpha::Opaque);
    png::write_display(&path, &shown, BitDepth::Eight, true, &Metadata::new()).unwrap();
    let golden = png::read(&path).unwrap();
    assert_eq!(
        difference::compare(&shown, &golden, 0).unwrap(),
        Difference::default()
    );
}

#[test]
fn pictures_of_different_size_are_not_compared() {
    let (a, b) = (display(&[[0; 4]; 2]), display(&[[0; 4]; 3]));
    let error = difference::compare(&a, &b, 0).unwrap_err();
    assert_eq!(
        error.to_string(),
        "found a picture of 2 x 1, expected 3 x 1"
    );
    difference::picture(&a, &b, 1.0).unwrap_err();
}
