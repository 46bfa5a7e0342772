//! `tyndall compare` as a user runs it: numbers, limits, exit codes, messages.
#![allow(clippy::unwrap_used, clippy::panic)]

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;
use tempfile::TempDir;
use tyndall::output::png::PngOptions;
use tyndall::output::{Image, Metadata, Variance, exr, png};

const WIDTH: u32 = 32;
const HEIGHT: u32 = 20;

/// A smooth image; every channel of pixel (3, 2) is higher by `spike`.
fn image(spike: f32) -> Image {
    let positions = (0..HEIGHT).flat_map(|y| (0..WIDTH).map(move |x| (x, y)));
    let pixels = positions.map(|(x, y)| {
        let extra = if (x, y) == (3, 2) { spike } else { 0.0 };
        let level = (x + 1) as f32 / 32.0;
        [
            level + extra,
            0.5 + extra,
            y as f32 / 40.0 + 0.25 + extra,
            1.0,
        ]
    });
    Image {
        width: WIDTH,
        height: HEIGHT,
        pixels: pixels.collect(),
    }
}

fn variance(value: f32) -> Variance {
    Variance {
        pixels: vec![[value; 3]; (WIDTH * HEIGHT) as usize],
    }
}

/// A folder with `a` and `b`, differing by 0.1 in one pixel, as EXR, with variances and as PNG.
fn folder() -> TempDir {
    let folder = TempDir::new().unwrap();
    let at = |name: &str| folder.path().join(name);
    for (name, spike) in [("a", 0.1), ("b", 0.0)] {
        let (image, none) = (image(spike), Metadata::new());
        exr::write(&at(&format!("{name}.exr")), &image, &none).unwrap();
        let noisy = at(&format!("{name}_noisy.exr"));
        exr::write_with_variance(&noisy, &image, &variance(0.0002), &none).unwrap();
        let options = PngOptions::default();
        png::write(&at(&format!("{name}.png")), &image, &options, &none).unwrap();
    }
    folder
}

fn compare(folder: &Path, args: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_tyndall"));
    command.current_dir(folder).arg("compare").args(args);
    command.output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Runs and expects success; returns standard output.
fn done(folder: &Path, args: &[&str]) -> String {
    let output = compare(folder, args);
    let message = text(&output.stderr);
    assert!(output.status.success(), "{args:?}: {message}");
    text(&output.stdout)
}

/// Runs and expects a failure with `code` whose message holds every word; returns what it printed.
fn fails(folder: &Path, args: &[&str], code: i32, words: &[&str]) -> String {
    let output = compare(folder, args);
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{args:?}: {message}");
    for word in words {
        assert!(
            message.contains(word),
            "{args:?}: `{word}` is not in\n{message}"
        );
    }
    assert!(!message.contains("panicked"), "{message}");
    text(&output.stdout)
}

fn json(folder: &Path, args: &[&str]) -> Value {
    serde_json::from_str(&done(folder, &[args, &["--json"]].concat())).unwrap()
}

#[test]
fn two_exrs_are_measured_in_every_way() {
    let folder = folder();
    let report = json(folder.path(), &["a_noisy.exr", "b.exr"]);
    let c = &report["comparison"];
    let errors = &c["errors"];
    // One pixel of 640 is off by 0.1, as far as f32 can say.
    let near = |value: &Value, expected: f64| {
        let found = value.as_f64().unwrap();
        assert!((found - expected).abs() < 1e-6, "{found} {expected}");
    };
    near(&errors["rmse"], 0.1 / 640.0_f64.sqrt());
    near(&errors["bias"], 0.1 / 640.0);
    near(&errors["peak"], 1.0);
    near(&errors["largest"]["difference"], 0.1);
    assert_eq!(
        (&errors["largest"]["x"], &errors["largest"]["y"]),
        (&3.into(), &2.into())
    );
    let z = &c["z_score"];
    assert_eq!(z["channels"], 1920);
    let largest = z["largest"]["z"].as_f64().unwrap();
    assert!(
        (largest - 0.1 / 0.0002_f64.sqrt()).abs() < 1e-4,
        "{largest}"
    );
    assert!(c["shown"]["flip"]["mean"].as_f64().unwrap() > 0.0);
    assert!(c["hdr_flip"]["mean"].as_f64().unwrap() > 0.0);
    assert!(c["hdr_flip"]["exposures"]["count"].as_u64().unwrap() >= 2);

    let table = done(folder.path(), &["a_noisy.exr", "b.exr"]);
    for word in [
        "RMSE",
        "relative MSE",
        "bias",
        "PSNR",
        "SSIM",
        "LDR-FLIP",
        "HDR-FLIP",
        "column 3, row 2",
        "RMS z",
        "largest z",
    ] {
        assert!(table.contains(word), "`{word}` is not in\n{table}");
    }
}

#[test]
fn two_pngs_are_measured_as_shown() {
    let folder = folder();
    let report = json(folder.path(), &["a.png", "b.png"]);
    let c = &report["comparison"];
    assert!(c["hdr_flip"].is_null() && c["z_score"].is_null());
    assert!(c["errors"]["relative_mse"].is_null());
    assert_eq!(c["errors"]["rmse"], c["shown"]["rmse"]);
    let table = done(folder.path(), &["a.png", "b.png"]);
    assert!(
        table.contains("SSIM") && !table.contains("HDR-FLIP"),
        "{table}"
    );
}

#[test]
fn limits_make_the_exit_code() {
    let folder = folder();
    let pair = ["a_noisy.exr", "b_noisy.exr"];
    let with = |limits: &[&'static str]| [&pair[..], limits].concat();
    let kept = [
        "--max-rmse",
        "0.01",
        "--max-relative-mse",
        "0.01",
        "--max-bias",
        "0.001",
        "--max-relative-bias",
        "0.001",
        "--max-difference",
        "0.11",
        "--min-psnr",
        "40",
        "--min-ssim",
        "0.9",
        "--max-flip",
        "0.1",
        "--max-hdr-flip",
        "0.1",
        "--max-z",
        "6",
        "--max-mean-z",
        "1",
    ];
    done(folder.path(), &with(&kept));
    let exceeded = [
        ("--max-rmse", "0.003"),
        ("--max-relative-mse", "0.000001"),
        ("--max-bias", "0.0001"),
        ("--max-relative-bias", "0.0001"),
        ("--max-difference", "0.09"),
        ("--min-psnr", "60"),
        ("--min-ssim", "0.9999999"),
        ("--max-flip", "0"),
        ("--max-hdr-flip", "0"),
        ("--max-z", "4"),
        ("--max-mean-z", "0.1"),
    ];
    for (option, limit) in exceeded {
        let words = ["limit exceeded", option, limit, "found"];
        let printed = fails(folder.path(), &with(&[option, limit]), 6, &words);
        assert!(printed.contains("RMSE"), "the measures come first");
    }
    let both = with(&["--max-rmse", "0", "--max-difference", "0"]);
    fails(
        folder.path(),
        &both,
        6,
        &["--max-rmse 0", "--max-difference 0"],
    );
    // Equal images keep the strictest limits; infinite PSNR is above every limit.
    let equal = [
        "b.exr",
        "b.exr",
        "--max-rmse",
        "0",
        "--max-flip",
        "0",
        "--max-hdr-flip",
        "0",
        "--min-psnr",
        "1000",
        "--min-ssim",
        "1",
        "--max-difference",
        "0",
    ];
    done(folder.path(), &equal);
}

#[test]
fn limits_that_mean_nothing_are_wrong_usage() {
    let folder = folder();
    for limit in ["nan", "-1", "inf", "much"] {
        for option in ["--max-rmse", "--min-psnr"] {
            let args = ["a.exr", "b.exr", option, limit];
            fails(
                folder.path(),
                &args,
                2,
                &[option, "finite number of 0 or more"],
            );
        }
    }
    let pngs = |option| ["a.png", "b.png", option, "1"];
    fails(
        folder.path(),
        &pngs("--max-hdr-flip"),
        2,
        &["--max-hdr-flip", "two EXRs"],
    );
    fails(folder.path(), &pngs("--max-relative-mse"), 2, &["two EXRs"]);
    fails(
        folder.path(),
        &pngs("--max-z"),
        2,
        &["--max-z", "variance.R"],
    );
    fails(
        folder.path(),
        &pngs("--exposure"),
        2,
        &["--exposure", "two PNGs"],
    );
    let exrs = ["a.exr", "b.exr", "--max-z", "3"];
    fails(folder.path(), &exrs, 2, &["--max-z", "variance.R"]);
    let exposure = ["a.exr", "b.exr", "--exposure", "bright"];
    fails(folder.path(), &exposure, 2, &["number of stops or `auto`"]);
    done(
        folder.path(),
        &[
            "a.exr",
            "b.exr",
            "--exposure",
            "-1.5",
            "--tone-map",
            "filmic",
        ],
    );
}

#[test]
fn files_that_do_not_fit_are_named() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    fails(
        folder.path(),
        &["a.png", "b.exr"],
        2,
        &["a.png is a PNG", "b.exr is an EXR"],
    );
    fails(
        folder.path(),
        &["none.exr", "b.exr"],
        1,
        &["none.exr", "cannot open"],
    );
    fs::write(at("text.exr"), "no image").unwrap();
    fails(
        folder.path(),
        &["text.exr", "b.exr"],
        1,
        &["text.exr", "expected an EXR or a PNG"],
    );
    fs::write(at("empty.png"), "").unwrap();
    fails(folder.path(), &["b.png", "empty.png"], 1, &["empty.png"]);

    let mut broken = image(0.0);
    broken.pixels[70][2] = f32::NAN;
    broken.pixels[71][0] = f32::INFINITY;
    exr::write(&at("nan.exr"), &broken, &Metadata::new()).unwrap();
    let words = ["nan.exr", "2 of 640 pixels", "column 6, row 2"];
    fails(folder.path(), &["a.exr", "nan.exr"], 1, &words);

    let small = Image {
        width: 2,
        height: 1,
        pixels: vec![[0.5; 4]; 2],
    };
    exr::write(&at("small.exr"), &small, &Metadata::new()).unwrap();
    let words = ["small.exr", "b.exr", "2 x 1", "32 x 20"];
    fails(folder.path(), &["small.exr", "b.exr"], 1, &words);
    let args = ["small.exr", "small.exr", "--min-ssim", "0.5"];
    fails(folder.path(), &args, 2, &["--min-ssim", "11 pixels"]);

    let depth = at("depth.exr");
    let channel = ::exr::prelude::SpecificChannels::build()
        .with_channel::<f32>("Z")
        .with_pixel_fn(|_| (0.0_f32,));
    let file = ::exr::prelude::Image::from_channels((32, 20), channel);
    ::exr::prelude::WritableImage::write(&file)
        .to_file(&depth)
        .unwrap();
    let words = ["depth.exr", "found the channels Z", "expected R, G and B"];
    fails(folder.path(), &["depth.exr", "b.exr"], 1, &words);

    let negative = at("negative.exr");
    exr::write_with_variance(&negative, &image(0.0), &variance(-1.0), &Metadata::new()).unwrap();
    fails(
        folder.path(),
        &["negative.exr", "b.exr"],
        1,
        &["negative.exr", "variance", "-1.0"],
    );
}

#[test]
fn the_difference_picture_is_brightest_where_the_images_differ() {
    let folder = folder();
    let path = folder.path().join("flip.png");
    done(folder.path(), &["a.exr", "b.exr", "--diff", "flip.png"]);
    let picture = png::read(&path).unwrap();
    assert_eq!((picture.width, picture.height), (WIDTH, HEIGHT));
    let levels = picture.levels();
    let red = |x: usize, y: usize| levels[y * WIDTH as usize + x][0];
    // Blurring as the eye does spreads a pixel to its neighbours, not across the picture.
    let brightest = levels.iter().map(|l| l[0]).max().unwrap();
    assert_eq!(red(3, 2), brightest);
    assert!(brightest > 0);
    assert_eq!(red(31, 19), 0);

    let args = ["a.exr", "b.exr", "--diff", "flip.jpg"];
    fails(folder.path(), &args, 2, &["flip.jpg", ".png"]);
    let args = ["a.exr", "b.exr", "--diff", "none/flip.png"];
    fails(folder.path(), &args, 1, &["none"]);
    // It is written although a limit is exceeded: then it is wanted most.
    fs::remove_file(&path).unwrap();
    let args = ["a.exr", "b.exr", "--diff", "flip.png", "--max-rmse", "0"];
    fails(folder.path(), &args, 6, &["--max-rmse"]);
    assert!(path.exists());
}
