//! `path_trace`, `single_scatter`, `ambient_scattering` and `half_angle` beside Mitsuba 3: `tests/cases/README.md` says where the images come from.
#![allow(clippy::unwrap_used, clippy::expect_used)]

mod common;
mod estimates;

use std::path::PathBuf;

use common::{device, render};
use estimates::{estimate, traced};
use tyndall::gpu::Device;
use tyndall::output::metrics::{CompareOptions, compare_images, probability_among};
use tyndall::output::{Image, exr};
use tyndall::scene::file::SceneFile;
use tyndall::scene::{
    AmbientScatteringParams, HalfAngleParams, LightCache, Lighting, Scene, SingleScatterParams,
    TechniqueParams,
};

const CASES: [&str; 5] = [
    "c01_homog_side",
    "c03_homog_bwd_front",
    "c04_gauss_point",
    "c06_thin",
    "c09_two_lights",
];

/// A correct renderer fails a comparison with this probability.
const CHANCE: f64 = 1e-4;

/// Pixels fainter than this share of the brightest have so few scattering events that their stated errors
/// mean little; they are compared by tiles.
const FAINT: f32 = 0.01;

/// Pixels along the edge of a tile.
const TILE: u32 = 8;

fn path(case: &str, file: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/cases");
    folder.join(case).join(file)
}

fn scene(case: &str) -> Scene {
    let file = SceneFile::load(&path(case, "scene.toml"), &[]).unwrap();
    file.resolve(&mut |_, _, _| {}).unwrap()
}

/// An image and its squared standard errors.
type Estimate = (Image, Vec<[f32; 3]>);

fn reference(case: &str, max_scatter: Option<u32>) -> Estimate {
    let name = if max_scatter.is_some() {
        "single.exr"
    } else {
        "full.exr"
    };
    let file = path(case, name);
    let variance = exr::read_variance(&file).unwrap().unwrap();
    (exr::read(&file).unwrap(), variance.pixels)
}

/// Sums of differences and of variances.
#[derive(Clone, Copy, Default)]
struct Difference {
    sum: f64,
    variance: f64,
}

impl Difference {
    fn add(&mut self, difference: f64, variance: f64) {
        self.sum += difference;
        self.variance += variance;
    }

    fn z(self) -> f64 {
        if self.variance > 0.0 {
            self.sum / self.variance.sqrt()
        } else {
            0.0
        }
    }
}

/// What one channel of two estimates differs by.
struct Comparison {
    ratio: f64,
    // Of the image's mean.
    z_mean: f64,
    // Of the farthest pixel or tile, and how many of them there are.
    z_largest: f64,
    tests: u64,
    rms: f64,
}

fn compare(found: &Estimate, expected: &Estimate, channel: usize) -> Comparison {
    let (width, height) = (expected.0.width, expected.0.height);
    let brightest = expected
        .0
        .pixels
        .iter()
        .map(|p| p[channel])
        .fold(0.0, f32::max);
    let mut tiles = vec![Difference::default(); (width * height / TILE / TILE) as usize];
    let (mut all, mut z) = (Difference::default(), Vec::new());
    for (i, (a, b)) in found.0.pixels.iter().zip(&expected.0.pixels).enumerate() {
        let difference = f64::from(a[channel]) - f64::from(b[channel]);
        let variance = f64::from(found.1[i][channel]) + f64::from(expected.1[i][channel]);
        all.add(difference, variance);
        if b[channel] > FAINT * brightest {
            z.push(difference / variance.sqrt());
        } else {
            let (x, y) = (i as u32 % width, i as u32 / width);
            tiles[(y / TILE * (width / TILE) + x / TILE) as usize].add(difference, variance);
        }
    }
    z.extend(tiles.iter().filter(|t| t.variance > 0.0).map(|t| t.z()));
    let sum = |image: &Image| {
        image
            .pixels
            .iter()
            .map(|p| f64::from(p[channel]))
            .sum::<f64>()
    };
    Comparison {
        ratio: sum(&found.0) / sum(&expected.0),
        z_mean: all.z(),
        z_largest: z.iter().fold(0.0, |most, z| z.abs().max(most)),
        tests: z.len() as u64,
        rms: (z.iter().map(|z| z * z).sum::<f64>() / z.len() as f64).sqrt(),
    }
}

impl Comparison {
    /// Agreement of the image means within 0.5 % or 3 standard errors, and of each pixel within what chance
    /// explains among as many.
    fn agrees(&self) -> bool {
        let mean = (self.ratio - 1.0).abs() < 0.005 || self.z_mean.abs() < 3.0;
        mean && probability_among(self.z_largest, self.tests) > CHANCE
    }
}

fn rendered(device: &Device, scene: Scene, max_scatter: Option<u32>) -> Estimate {
    estimate(device, &traced(scene, 2048, max_scatter))
}

#[test]
fn images_agree_with_those_of_mitsuba() {
    let device = device();
    println!("| case | orders | channel | mean ratio | z of the mean | rms z | largest z | of |");
    println!("|---|---|---|---|---|---|---|---|");
    let mut apart = Vec::new();
    for case in CASES {
        for (orders, max_scatter) in [("all", None), ("1", Some(1))] {
            let found = rendered(&device, scene(case), max_scatter);
            let expected = reference(case, max_scatter);
            let colored = case == "c09_two_lights";
            for channel in 0..if colored { 3 } else { 1 } {
                let c = compare(&found, &expected, channel);
                println!(
                    "| {case} | {orders} | {} | {:.4} | {:.1} | {:.2} | {:.1} | {} |",
                    ["R", "G", "B"][channel],
                    c.ratio,
                    c.z_mean,
                    c.rms,
                    c.z_largest,
                    c.tests
                );
                if !c.agrees() {
                    apart.push(format!("{case}, {orders}, {channel}"));
                }
            }
            // Transmittance was integrated by quadrature; path_trace counts paths that meet the medium.
            let alpha = |image: &Image| image.pixels.iter().map(|p| f64::from(p[3])).sum::<f64>();
            let ratio = alpha(&found.0) / alpha(&expected.0);
            assert!((ratio - 1.0).abs() < 2e-3, "{case}: alpha {ratio}");
        }
    }
    assert!(apart.is_empty(), "{apart:?}");
}

/// Sum of all channels, and its standard error where there is one.
fn sum((image, variance): &Estimate) -> (f64, f64) {
    let sum = |p: &[f32]| p[..3].iter().copied().map(f64::from).sum::<f64>();
    let squares: f64 = variance.iter().map(|v| sum(v)).sum();
    (image.pixels.iter().map(|p| sum(p)).sum(), squares.sqrt())
}

#[test]
fn single_scatter_is_within_two_percent_at_default_settings() {
    let device = device();
    println!("| case | half (default) | full | none | standard error |");
    println!("|---|---|---|---|---|");
    for case in CASES {
        let expected = sum(&reference(case, Some(1)));
        let bias = |cache| {
            let mut s = scene(case);
            s.technique = TechniqueParams::SingleScatter(SingleScatterParams {
                cache,
                ..SingleScatterParams::default()
            });
            // The reference averages over pixels.
            s.image.samples_per_axis = 4;
            let found = sum(&(render(&device, &s), Vec::new()));
            100.0 * (found.0 / expected.0 - 1.0)
        };
        let [half, full, none] = [LightCache::Half, LightCache::Full, LightCache::None].map(bias);
        let error = 100.0 * expected.1 / expected.0;
        println!("| {case} | {half:.2} % | {full:.2} % | {none:.2} % | {error:.2} % |");
        assert!(half.abs() < 2.0, "{case}: {half} %");
    }
}

#[test]
fn direct_light_of_half_angle_is_within_two_percent_at_default_settings() {
    let device = device();
    println!(
        "| case | direct (default slices) | half the spacing | standard error | with indirect, all orders |"
    );
    println!("|---|---|---|---|---|");
    for case in CASES {
        let of = |lighting| {
            let mut s = scene(case);
            s.technique = TechniqueParams::HalfAngle(HalfAngleParams {
                lighting,
                ..HalfAngleParams::default()
            });
            // The reference averages over pixels.
            s.image.samples_per_axis = 4;
            sum(&(render(&device, &s), Vec::new())).0
        };
        let expected = sum(&reference(case, Some(1)));
        let all = sum(&reference(case, None)).0;
        let direct = 100.0 * (of(Lighting::Direct) / expected.0 - 1.0);
        let indirect = 100.0 * (of(Lighting::Indirect) / all - 1.0);
        let once = 100.0 * (expected.0 / all - 1.0);
        let error = 100.0 * expected.1 / expected.0;
        println!("| {case} | {direct:.2} % | {error:.2} % | {indirect:.1} % | {once:.1} % |");
        assert!(direct.abs() < 2.0, "{case}: {direct} %");
        assert!(
            indirect.abs() < once.abs(),
            "{case}: {indirect} %, {once} %"
        );
    }
}

/// Relative bias and FLIP, as shown.
fn distance(found: &Image, expected: &Image) -> [f64; 2] {
    let comparison = compare_images(found, expected, &CompareOptions::default()).unwrap();
    let bias = comparison.errors.relative_bias.unwrap();
    [bias, comparison.shown.flip.mean]
}

#[test]
fn ambient_scattering_is_nearer_to_all_light_than_single_scatter() {
    let device = device();
    println!("| case | single_scatter: bias / FLIP | ambient_scattering |");
    println!("|---|---|---|");
    for case in CASES {
        let expected = reference(case, None).0;
        let of = |technique| {
            let mut s = scene(case);
            s.technique = technique;
            // The reference averages over pixels.
            s.image.samples_per_axis = 4;
            distance(&render(&device, &s), &expected)
        };
        let once = of(TechniqueParams::SingleScatter(
            SingleScatterParams::default(),
        ));
        let ours = of(TechniqueParams::AmbientScattering(
            AmbientScatteringParams::default(),
        ));
        let shown = |[bias, flip]: [f64; 2]| format!("{:.1} % / {flip:.3}", 100.0 * bias);
        println!("| {case} | {} | {} |", shown(once), shown(ours));
        assert!(ours[0].abs() < once[0].abs(), "{case}: bias");
        assert!(ours[1] < once[1], "{case}: FLIP");
    }
}

#[test]
fn images_of_other_scenes_do_not_agree() {
    let device = device();
    let agrees = |case: &str, change: fn(&mut Scene)| {
        let mut s = scene(case);
        change(&mut s);
        let found = rendered(&device, s, Some(1));
        compare(&found, &reference(case, Some(1)), 0).agrees()
    };
    let denser = |s: &mut Scene| s.medium.density_scale = 1.02;
    assert!(!agrees("c06_thin", denser), "2 % more extinction");
    let evener = |s: &mut Scene| s.medium.phase_g *= 0.97;
    assert!(
        !agrees("c03_homog_bwd_front", evener),
        "another phase function"
    );
    let turned = |s: &mut Scene| s.camera.up = -s.camera.up;
    assert!(!agrees("c01_homog_side", turned), "upside down");
}
