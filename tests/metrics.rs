//! The measures of difference, against numbers computed by hand or by their authors' programs.
#![allow(clippy::unwrap_used, clippy::panic)]

use rand::{RngExt, SeedableRng};
use tyndall::output::metrics::flip::{self, ErrorMap, PIXELS_PER_DEGREE, hdr_flip, ldr_flip};
use tyndall::output::metrics::{
    CompareError, CompareOptions, Estimate, RELATIVE_EPSILON, Side, Values, compare_displays,
    compare_images, errors, probability_among, ssim, z_score,
};
use tyndall::output::{Display, Image, Variance};
use tyndall::scene::Exposure;

/// Size of the images whose errors other programs computed.
const SIZE: (u32, u32) = (24, 16);

fn pixels<T>(pixel: impl Fn(u32, u32) -> T) -> Vec<T> {
    let positions = (0..SIZE.1).flat_map(|y| (0..SIZE.0).map(move |x| (x, y)));
    positions.map(|(x, y)| pixel(x, y)).collect()
}

/// A picture of 8-bit levels.
fn display(levels: impl Fn(u32, u32) -> [u32; 3]) -> Display {
    Display {
        width: SIZE.0,
        height: SIZE.1,
        pixels: pixels(|x, y| {
            let [r, g, b] = levels(x, y).map(|v| v as f32 / 255.0);
            [r, g, b, 1.0]
        }),
    }
}

fn radiance(values: impl Fn(u32, u32) -> [f32; 3]) -> Image {
    Image {
        width: SIZE.0,
        height: SIZE.1,
        pixels: pixels(|x, y| {
            let [r, g, b] = values(x, y);
            [r, g, b, 1.0]
        }),
    }
}

fn close(found: f64, expected: f64, tolerance: f64, what: &str) {
    assert!(
        (found - expected).abs() <= tolerance,
        "{what}: found {found}, expected {expected} +- {tolerance}"
    );
}

// --- The pairs of pictures, found and reference ---

fn smooth() -> (Display, Display) {
    let found = display(|x, y| [x * 10 + 12, y * 15, 128 + (x * 7 + y * 3) % 40]);
    (found, display(|x, y| [x * 10, y * 16, 128]))
}

fn hard() -> (Display, Display) {
    let found = display(|x, y| {
        let red = (x * 37 + y * 11 + 40) % 256;
        [red, (x * 5 + y * 71) % 256, (x * y * 13 + x) % 256]
    });
    let reference = display(|x, y| {
        let red = (x * 37 + y * 11) % 256;
        [red, (x * 5 + y * 71) % 256, (x * y * 13) % 256]
    });
    (found, reference)
}

fn edge() -> (Display, Display) {
    let step = |at: u32| {
        move |x: u32, _: u32| {
            if x < at {
                [200, 180, 40]
            } else {
                [20, 60, 160]
            }
        }
    };
    (display(step(13)), display(step(12)))
}

fn bright() -> (Image, Image) {
    let pixel = |x: u32, y: u32, shift: u32| {
        let scale = (((x * 5 + y * 3) % 13) as f32 - 6.0).exp2();
        [0, 1, 2].map(|i| scale * (1.0 + ((x * y + i * 3 + shift) % 7) as f32 / 8.0))
    };
    let found = radiance(|x, y| pixel(x, y, y));
    (found, radiance(|x, y| pixel(x, y, 0)))
}

fn ramp() -> (Image, Image) {
    let found = radiance(|x, y| {
        let spike = if (x, y) == (5, 4) { 2.0 } else { 1.0 };
        let blue = (x + y) as f32 / 2.0 * spike;
        [(x + 2) as f32 / 8.0, (y + 1) as f32 / 4.0, blue]
    });
    let reference = radiance(|x, y| {
        let blue = (x + y) as f32 / 2.0;
        [(x + 1) as f32 / 8.0, (y + 1) as f32 / 4.0, blue]
    });
    (found, reference)
}

/// A lit disc before black, as most volumes are seen: the median of the reference is 0.
fn night() -> (Image, Image) {
    let inside = |x: u32, y: u32| x.abs_diff(12).pow(2) + y.abs_diff(8).pow(2) < 25;
    let pixel = move |x: u32, y: u32, shift: u32, blue: f32| {
        if inside(x, y) {
            [(x + shift) as f32 / 8.0, y as f32 / 8.0, blue]
        } else {
            [0.0; 3]
        }
    };
    let found = radiance(|x, y| pixel(x, y, 1, if y > 8 { 0.75 } else { 0.5 }));
    (found, radiance(|x, y| pixel(x, y, 0, 0.5)))
}

// --- FLIP ---

/// Columns and rows of the pixels that are compared one by one.
const PLACES: [(usize, usize); 4] = [(0, 0), (5, 4), (12, 8), (23, 15)];

/// Mean, and the errors at [`PLACES`], computed by the authors' own program (flip-evaluator 1.7,
/// `evaluate(reference, found, ...)` with its default 67.02 pixels per degree) on these pairs.
///
/// Both programs compute in single precision, and FLIP takes roots of differences near 0, which
/// enlarge rounding: 1e-7 of light is 3e-4 of a feature, though it seldom decides a pixel. The
/// largest deviation found was 2e-5; 1e-4 leaves room for other processors.
const FLIP_TOLERANCE: f64 = 1e-4;

fn check_flip(map: &ErrorMap, mean: f64, places: [f64; 4], what: &str) {
    close(map.mean(), mean, FLIP_TOLERANCE, what);
    for ((x, y), expected) in PLACES.into_iter().zip(places) {
        let found = f64::from(map.values[y * SIZE.0 as usize + x]);
        close(found, expected, FLIP_TOLERANCE, &format!("{what} {x},{y}"));
    }
}

#[test]
fn ldr_flip_agrees_with_its_authors() {
    type Row = (&'static str, (Display, Display), f64, [f64; 4]);
    let rows: [Row; 3] = [
        (
            "smooth",
            smooth(),
            0.376_783_4,
            [0.123_530_5, 0.229_295_2, 0.373_330_6, 0.508_200_8],
        ),
        (
            "hard",
            hard(),
            0.300_299_3,
            [0.242_800_3, 0.432_673_3, 0.334_510_1, 0.691_364_6],
        ),
        (
            "edge",
            edge(),
            0.174_400_8,
            [0.0, 0.092_613_1, 0.542_680_7, 0.0],
        ),
    ];
    for (name, (found, reference), mean, places) in rows {
        let map = ldr_flip(&found, &reference, PIXELS_PER_DEGREE).unwrap();
        check_flip(&map, mean, places, name);
    }
}

#[test]
fn hdr_flip_agrees_with_its_authors() {
    let (found, reference) = bright();
    let (map, exposures) = hdr_flip(&found, &reference, PIXELS_PER_DEGREE).unwrap();
    // Stops that the authors' program states, in single precision.
    close(exposures.start, -5.625_265_1, 1e-5, "start");
    close(exposures.stop, 0.680_193_1, 1e-5, "stop");
    assert_eq!(exposures.count, 7);
    let places = [0.100_537_9, 0.166_190_6, 0.132_750_5, 0.083_314_8];
    check_flip(&map, 0.132_459_1, places, "bright");

    let (found, reference) = ramp();
    let (map, exposures) = hdr_flip(&found, &reference, PIXELS_PER_DEGREE).unwrap();
    close(exposures.start, -1.200_743_1, 1e-5, "start");
    close(exposures.stop, -0.262_893_9, 1e-5, "stop");
    assert_eq!(exposures.count, 2);
    let places = [0.278_246_5, 0.141_996_0, 0.075_845_1, 0.038_224_2];
    check_flip(&map, 0.101_695_5, places, "ramp");

    let (found, reference) = night();
    let (map, exposures) = hdr_flip(&found, &reference, PIXELS_PER_DEGREE).unwrap();
    close(exposures.start, 0.516_774_2, 1e-5, "start");
    close(exposures.stop, 24.083_297_7, 1e-5, "stop");
    assert_eq!(exposures.count, 24);
    let places = [0.000_026_6, 0.011_415_1, 0.143_195_8, 0.002_501_6];
    check_flip(&map, 0.052_470_6, places, "night");
}

/// CIELAB of 8-bit sRGB with the Hunt effect, in f64 and with the rounded matrix of the standard.
fn hunt_lab(levels: [u32; 3]) -> [f64; 3] {
    let [r, g, b] = levels.map(|v| {
        let v = f64::from(v) / 255.0;
        if v <= 0.04045 {
            v / 12.92
        } else {
            ((v + 0.055) / 1.055).powf(2.4)
        }
    });
    let curve = |t: f64| {
        if t > 216.0 / 24389.0 {
            t.cbrt()
        } else {
            t * 841.0 / 108.0 + 4.0 / 29.0
        }
    };
    let x = curve((0.4124 * r + 0.3576 * g + 0.1805 * b) / 0.9505);
    let y = curve(0.2126 * r + 0.7152 * g + 0.0722 * b);
    let z = curve((0.0193 * r + 0.1192 * g + 0.9505 * b) / 1.089);
    let light = 116.0 * y - 16.0;
    [light, 5.0 * light * (x - y), 2.0 * light * (y - z)]
}

/// FLIP of two even pictures: no edges, and blurring changes nothing, so only colour is left.
fn even_flip(a: [u32; 3], b: [u32; 3]) -> f64 {
    let distance = |a, b| {
        let (a, b) = (hunt_lab(a), hunt_lab(b));
        let light = (a[0] - b[0]).abs();
        (light + (a[1] - b[1]).hypot(a[2] - b[2])).powf(0.7)
    };
    let share = distance(a, b) / distance([0, 255, 0], [0, 0, 255]);
    if share < 0.4 {
        share / 0.4 * 0.95
    } else {
        0.95 + (share - 0.4) / 0.6 * 0.05
    }
}

#[test]
fn flip_of_even_pictures_is_the_distance_of_their_colours() {
    let (black, white) = ([0; 3], [255; 3]);
    // The authors' program gives 0.967386 for black and white, 0.281413 for the last pair.
    close(even_flip(black, white), 0.967_386, 1e-4, "by hand");
    close(
        even_flip([120, 60, 30], [100, 80, 30]),
        0.281_413,
        1e-4,
        "by hand",
    );
    let pairs = [
        (black, white),
        (white, black),
        ([0, 255, 0], [0, 0, 255]),
        ([120, 60, 30], [100, 80, 30]),
        ([128; 3], [129; 3]),
    ];
    for (a, b) in pairs {
        let map = ldr_flip(&display(|_, _| a), &display(|_, _| b), PIXELS_PER_DEGREE).unwrap();
        // The standard's matrix has four digits.
        close(map.mean(), even_flip(a, b), 2e-4, &format!("{a:?} {b:?}"));
        // Even pictures have even maps, up to the borders.
        close(map.largest(), map.mean(), 1e-5, "even");
    }
}

/// Large pictures are worked on in bands of rows, which must not show.
#[test]
fn flip_of_a_tall_picture_is_that_of_its_middle() {
    let tall = |rows: std::ops::Range<u32>, shift: u32| Display {
        width: 20,
        height: rows.len() as u32,
        pixels: rows
            .flat_map(|y| (0..20).map(move |x| (x * 37 + y * y * 11 + shift * x * y) % 256))
            .map(|level| [level as f32 / 255.0, 0.5, 0.25, 1.0])
            .collect(),
    };
    let flip = |rows: std::ops::Range<u32>| {
        let (found, reference) = (tall(rows.clone(), 1), tall(rows, 0));
        ldr_flip(&found, &reference, PIXELS_PER_DEGREE)
            .unwrap()
            .values
    };
    // Borders of the bands lie in other rows; the filters reach no further than eleven rows.
    let (whole, part) = (flip(0..300), flip(37..250));
    for y in 50..230 {
        let (a, b) = (20 * y, 20 * (y - 37));
        assert_eq!(whole[a..a + 20], part[b..b + 20], "row {y}");
    }
}

#[test]
fn flip_of_equal_images_is_exactly_0() {
    let (_, reference) = hard();
    let map = ldr_flip(&reference, &reference, PIXELS_PER_DEGREE).unwrap();
    assert!(map.values.iter().all(|&v| v == 0.0));
    for image in [bright().1, radiance(|_, _| [0.0; 3])] {
        let (map, _) = hdr_flip(&image, &image, PIXELS_PER_DEGREE).unwrap();
        assert!(map.values.iter().all(|&v| v == 0.0));
    }
}

#[test]
fn flip_stays_in_its_range_whatever_it_is_given() {
    let (found, reference) = ramp();
    let huge = radiance(|x, y| [f32::MAX, -(x as f32), 1e-40 * y as f32]);
    for (a, b) in [(&huge, &reference), (&found, &huge)] {
        for ppd in [PIXELS_PER_DEGREE, 0.0, f64::NAN] {
            let (map, _) = hdr_flip(a, b, ppd).unwrap();
            assert!(map.values.iter().all(|v| (0.0..=1.0).contains(v)));
        }
    }
    let picture = flip::picture(&hdr_flip(&huge, &found, 67.0).unwrap().0);
    assert_eq!((picture.width, picture.height), SIZE);
}

#[test]
fn a_picture_of_errors_runs_from_black_to_pale_yellow() {
    let map = ErrorMap {
        width: 3,
        height: 1,
        values: vec![0.0, 0.5, 1.0],
    };
    let expected = [[0, 0, 4, 255], [181, 54, 122, 255], [252, 253, 191, 255]];
    assert_eq!(flip::picture(&map).levels(), expected);
}

// --- SSIM ---

/// Computed by scikit-image 0.26.0: `structural_similarity(gaussian_weights=True, sigma=1.5,
/// use_sample_covariance=False, data_range=1)` on the Rec.709 sum of the encoded channels. The
/// samples are single precision, sums and products double: 1e-7.
#[test]
fn ssim_agrees_with_scikit_image() {
    let rows = [
        ("smooth", smooth(), 0.997_089_650),
        ("hard", hard(), 0.937_988_047),
        ("edge", edge(), 0.629_020_572),
    ];
    for (name, (found, reference), expected) in rows {
        close(ssim(&found, &reference).unwrap(), expected, 1e-7, name);
    }
}

#[test]
fn ssim_by_hand() {
    let (_, reference) = hard();
    assert_eq!(ssim(&reference, &reference), Some(1.0));
    // Without contrast only the means are left: (2 a b + C1) / (a^2 + b^2 + C1).
    let found = ssim(&display(|_, _| [51; 3]), &display(|_, _| [204; 3])).unwrap();
    let expected = (2.0 * 0.2 * 0.8 + 1e-4) / (0.04 + 0.64 + 1e-4);
    close(found, expected, 1e-6, "even");
    let narrow = Display {
        width: 10,
        height: 100,
        pixels: vec![[0.5; 4]; 1000],
    };
    assert_eq!(ssim(&narrow, &narrow), None);
}

// --- Errors of the values ---

const RADIANCE: Values = Values::Radiance {
    relative_epsilon: RELATIVE_EPSILON,
};

#[test]
fn errors_by_hand() {
    let found = [[1.0, 2.0, 3.0, 1.0], [0.0, 0.5, 4.0, 0.5]];
    let reference = [[1.0, 1.0, 3.0, 1.0], [0.0, 1.0, 2.0, 1.0]];
    let e = errors(1, &found, &reference, RADIANCE);
    // Differences: 0 1 0 and 0 -1/2 2.
    close(e.rmse, (5.25_f64 / 6.0).sqrt(), 1e-15, "rmse");
    let relative = (1.0 / 1.01 + 0.25 / 1.01 + 4.0 / 4.01) / 6.0;
    close(e.relative_mse.unwrap(), relative, 1e-15, "relative MSE");
    close(e.bias, 2.5 / 6.0, 1e-15, "bias");
    assert_eq!(e.channel_bias, [0.0, 0.25, 1.0]);
    close(e.relative_bias.unwrap(), 2.5 / 8.0, 1e-15, "relative bias");
    let relative_bias = [Some(0.0), Some(0.25), Some(0.4)];
    assert_eq!(e.relative_channel_bias, relative_bias);
    assert_eq!(e.peak, 3.0);
    let psnr = 10.0 * (9.0 * 6.0 / 5.25_f64).log10();
    close(e.psnr, psnr, 1e-12, "PSNR");
    close(e.alpha_rmse, (0.125_f64).sqrt(), 1e-15, "alpha");
    let l = &e.largest;
    assert_eq!((l.difference, l.x, l.y, l.channel), (2.0, 0, 1, 'B'));
    assert_eq!((l.found, l.reference), (4.0, 2.0));
}

#[test]
fn errors_of_equal_and_of_black_images() {
    let black = [[0.0; 4]; 6];
    let e = errors(3, &black, &black, RADIANCE);
    assert_eq!((e.rmse, e.relative_mse, e.bias), (0.0, Some(0.0), 0.0));
    assert_eq!((e.relative_bias, e.psnr), (None, f64::INFINITY));
    let e = errors(3, &[[1.0; 4]; 6], &black, Values::Display);
    assert_eq!((e.relative_mse, e.peak, e.psnr), (None, 1.0, 0.0));
    let l = &e.largest;
    assert_eq!((l.difference, l.x, l.y, l.channel), (1.0, 0, 0, 'R'));
}

// --- z-scores ---

#[test]
fn z_scores_by_hand() {
    let found = [[3.0, 1.0, 0.0, 1.0], [1.0, 5.0, 0.0, 1.0]];
    let reference = [[1.0, 1.0, 0.0, 1.0], [2.0, 1.0, 0.5, 1.0]];
    let a = [[2.0, 0.0, 0.0], [0.25, 1.0, 0.0]];
    let b = [[2.0, 0.0, 0.0], [0.0, 0.0, 0.0]];
    let z = z_score(2, &found, &reference, Some(&a), Some(&b));
    // Red: 2 / 2 and -1 / 0.5; green: 4 / 1.
    assert_eq!(z.channels, 3);
    close(
        z.rms.unwrap(),
        ((1.0 + 4.0 + 16.0) / 3.0_f64).sqrt(),
        1e-12,
        "rms",
    );
    close(z.share_beyond_3.unwrap(), 1.0 / 3.0, 1e-12, "share");
    let largest = z.largest.unwrap();
    assert_eq!((largest.z, largest.x, largest.y), (4.0, 1, 0));
    assert_eq!(largest.channel, 'G');
    // 1 - (1 - 6.334248e-5)^3.
    close(largest.probability, 1.900_154e-4, 1e-9, "probability");
    let mean = [Some(1.0 / 4.25_f64.sqrt()), Some(4.0), None];
    assert_eq!(z.mean, mean);
    let exact = &z.exact;
    assert_eq!((exact.equal, exact.unequal), (2, 1));
    assert_eq!(exact.largest_difference, 0.5);
}

#[test]
fn probabilities_keep_their_digits_from_one_to_the_smallest() {
    // Two-sided tails of the normal distribution as tables have them.
    close(probability_among(1.959_963_985, 1), 0.05, 1e-9, "5 %");
    close(probability_among(-3.0, 1), 2.699_796e-3, 1e-9, "3 sigma");
    let ten = probability_among(10.0, 1_000_000);
    close(ten / 1.523_970_6e-17, 1.0, 1e-6, "10 sigma, a million");
    assert_eq!(probability_among(0.0, 5), 1.0);
    assert_eq!(probability_among(100.0, 5), 0.0);
    assert_eq!(probability_among(3.0, 1_000_000_000), 1.0);
}

/// Two estimates of the same radiance from uniform noise, whose variance is known.
#[test]
fn noise_alone_scores_as_noise() {
    let mut random = rand_pcg::Pcg64::seed_from_u64(7);
    const SAMPLES: u32 = 16;
    let mut mean = || -> f32 {
        let sum: f32 = (0..SAMPLES).map(|_| random.random::<f32>()).sum();
        sum / SAMPLES as f32
    };
    let mut estimate = || radiance_from((0..100 * 100 * 3).map(|_| mean()).collect());
    let (a, b) = (estimate(), estimate());
    let variance = Variance {
        pixels: vec![[1.0 / 12.0 / SAMPLES as f32; 3]; 100 * 100],
    };
    let with = |image| Estimate {
        image,
        variance: Some(&variance),
    };
    let options = CompareOptions::default();
    let z = compare_images(with(&a), with(&b), &options)
        .unwrap()
        .z_score
        .unwrap();
    // The mean of 30 000 squares spreads by sqrt(2 / 30 000) = 0.008: five of these, halved by
    // the root.
    close(z.rms.unwrap(), 1.0, 0.02, "rms");
    close(z.share_beyond_3.unwrap(), 0.0027, 0.0015, "beyond 3");
    assert!(z.largest.unwrap().probability > 1e-4);
    assert!(z.mean_probability.unwrap() > 1e-4);

    // A bias of a tenth of one pixel's spread is invisible in it and plain in the mean.
    let mut shifted = a.clone();
    for p in &mut shifted.pixels {
        p[0] += 0.1 * (1.0_f32 / 12.0 / SAMPLES as f32).sqrt();
    }
    let z = compare_images(with(&shifted), with(&b), &options)
        .unwrap()
        .z_score
        .unwrap();
    assert!(z.rms.unwrap() < 1.02);
    assert!(z.mean_probability.unwrap() < 1e-6);
}

fn radiance_from(values: Vec<f32>) -> Image {
    Image {
        width: 100,
        height: 100,
        pixels: values
            .chunks_exact(3)
            .map(|v| [v[0], v[1], v[2], 1.0])
            .collect(),
    }
}

// --- All at once ---

#[test]
fn both_images_are_shown_with_the_exposure_of_the_reference() {
    let reference = radiance(|_, _| [0.2; 3]);
    let found = radiance(|_, _| [0.1; 3]);
    let c = compare_images(&found, &reference, &CompareOptions::default()).unwrap();
    // 0.2 * 4 = 0.8 is what automatic exposure aims at.
    close(f64::from(c.shown.stops.unwrap()), 2.0, 1e-5, "stops");
    assert!(c.shown.rmse > 0.1 && c.z_score.is_none());
    let options = CompareOptions {
        exposure: Exposure::Stops(10.0),
        ..CompareOptions::default()
    };
    // Both white.
    let c = compare_images(&found, &reference, &options).unwrap();
    assert_eq!((c.shown.rmse, c.shown.flip.mean), (0.0, 0.0));
    assert!(c.errors.rmse > 0.0 && c.hdr_flip.unwrap().error.mean > 0.1);
}

#[test]
fn images_that_cannot_be_compared_say_why() {
    let (found, mut bad) = (bright().0, bright().1);
    let options = CompareOptions::default();
    bad.pixels[26][1] = f32::NAN;
    bad.pixels[100][3] = f32::INFINITY;
    let error = compare_images(&found, &bad, &options).unwrap_err();
    assert_eq!(error.side(), Some(Side::Reference));
    let text = error.to_string();
    assert!(text.contains("2 of 384 pixels"), "{text}");
    assert!(text.contains("column 2, row 1"), "{text}");

    let small = Image {
        width: 1,
        height: 1,
        pixels: vec![[0.0; 4]],
    };
    let error = compare_images(&found, &small, &options).unwrap_err();
    assert!(matches!(error, CompareError::Size(_)), "{error}");
    let text = error.to_string();
    assert!(text.contains("24 x 16, expected 1 x 1"), "{text}");

    let empty = Display::default();
    let error = compare_displays(&empty, &empty, &options).unwrap_err();
    assert!(error.to_string().contains("0 x 0"), "{error}");
    let lying = Image {
        width: 2,
        ..small.clone()
    };
    let error = compare_images(&small, &lying, &options).unwrap_err();
    assert_eq!(error.side(), Some(Side::Reference));
    assert!(
        error.to_string().contains("2 x 1 picture with 1 pixels"),
        "{error}"
    );

    for pixels in [vec![[-1.0; 3]], vec![[f32::NAN; 3]], Vec::new()] {
        let estimate = Estimate {
            image: &small,
            variance: Some(&Variance { pixels }),
        };
        let error = compare_images(estimate, &small, &options).unwrap_err();
        assert!(matches!(error, CompareError::Variance { .. }), "{error}");
        assert_eq!(error.side(), Some(Side::Found));
    }
}
