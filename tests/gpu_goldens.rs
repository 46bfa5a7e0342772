//! Small images against the ones that were looked at and blessed: `tests/goldens/<technique>/<scene>/`.
//!
//! Exposure is fixed, so that an image's brightness is compared too. A failure writes the current
//! image and the difference beside the build; `TYNDALL_BLESS=1 cargo test --test gpu_goldens` accepts.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use std::fs;
use std::path::{Path, PathBuf};

use common::{device, render};
use tyndall::output::difference::{Difference, compare, picture};
use tyndall::output::png::{self, BitDepth};
use tyndall::output::tone_map::{Alpha, ToneMapping, expose, to_display};
use tyndall::output::{Display, Metadata};
use tyndall::scene::file::{Override, SceneFile};

/// Software drivers differ between processors by a level or two (order of f32 operations, no fused
/// multiply-add); nothing else may.
const LEVELS: u8 = 2;

/// Image, scene file, its overrides: small, and from several corners of the technique.
type Case = (&'static str, &'static str, &'static [&'static str]);

/// Another processor may round a path apart; then its pixel keeps only its mean. These have so many
/// samples that a standard error is about half a level.
const PATH_TRACE: [Case; 2] = [
    (
        "cloud",
        "cloud",
        &[
            "technique.name=path_trace",
            "technique.path_trace.samples=4096",
            "volume.procedural.resolution=32",
            "image.width=24",
            "image.height=18",
        ],
    ),
    (
        "mechanical_part",
        "mechanical_part",
        &[
            "technique.name=path_trace",
            "technique.path_trace.samples=2048",
            "volume.procedural.resolution=32",
            "image.width=32",
            "image.height=24",
        ],
    ),
];

const SINGLE_SCATTER: [Case; 3] = [
    (
        "cloud",
        "cloud",
        &[
            "technique.name=single_scatter",
            "volume.procedural.resolution=48",
        ],
    ),
    (
        "mechanical_part",
        "mechanical_part",
        &[
            "technique.name=single_scatter",
            "volume.procedural.resolution=64",
            "image.exposure=1.5",
        ],
    ),
    (
        "mechanical_part_uncached",
        "mechanical_part",
        &[
            "technique.name=single_scatter",
            "technique.single_scatter.cache=none",
            "volume.procedural.resolution=48",
            "lights=[{point={position=[1.2,-1.5,1.4],intensity=80}}]",
            "image.width=48",
            "image.height=36",
        ],
    ),
];

const AMBIENT_SCATTERING: [Case; 3] = [
    (
        "cloud",
        "cloud",
        &[
            "technique.name=ambient_scattering",
            "volume.procedural.resolution=48",
        ],
    ),
    (
        "mechanical_part",
        "mechanical_part",
        &[
            "technique.name=ambient_scattering",
            "technique.ambient_scattering.specular=0.3",
            "volume.procedural.resolution=64",
        ],
    ),
    (
        "supernova_literal",
        "default",
        &[
            "technique.name=ambient_scattering",
            "technique.ambient_scattering.gather=literal",
            "technique.ambient_scattering.radius=3",
            "lights=[{point={position=[0,0,0],intensity=2}}]",
            "volume.procedural.resolution=48",
        ],
    ),
];

const HALF_ANGLE: [Case; 5] = [
    (
        "cumulus_field",
        "cumulus_field",
        &[
            "technique.name=half_angle",
            "volume.height_field.procedural.resolution=96",
        ],
    ),
    (
        "cloud",
        "cloud",
        &[
            "technique.name=half_angle",
            "technique.half_angle.transport_color=[0.7,0.85,0.98]",
            "volume.procedural.resolution=48",
        ],
    ),
    (
        "mechanical_part",
        "mechanical_part",
        &[
            "technique.name=half_angle",
            "technique.half_angle.surface=gradient",
            "volume.procedural.resolution=64",
            "image.exposure=1.5",
        ],
    ),
    (
        "cloud_from_behind",
        "cloud",
        &[
            "technique.name=half_angle",
            "technique.half_angle.blur_samples=16",
            "volume.procedural.resolution=48",
            "medium.phase.g=0.6",
            "lights=[{directional={direction=[-0.3,-1.0,-0.6],irradiance=6.0}}]",
        ],
    ),
    (
        "supernova_point",
        "default",
        &[
            "technique.name=half_angle",
            "lights=[{point={position=[0,0,0],intensity=2}}]",
            "volume.procedural.resolution=48",
        ],
    ),
];

const AMBIENT_OCCLUSION: [Case; 2] = [
    (
        "cloud",
        "cloud",
        &[
            "technique.name=ambient_occlusion",
            "volume.procedural.resolution=48",
            "image.background=[0.0,0.0,0.0]",
            "image.exposure=2.0",
        ],
    ),
    (
        "mechanical_part",
        "mechanical_part",
        &[
            "technique.name=ambient_occlusion",
            "technique.ambient_occlusion.radius=6",
            "volume.procedural.resolution=64",
            "image.exposure=3.0",
        ],
    ),
];

const RAY_MARCH: [Case; 8] = [
    (
        "terrain",
        "terrain",
        &[
            "volume.height_field.procedural.resolution=128",
            "image.exposure=-1.5",
        ],
    ),
    ("supernova", "default", &["volume.procedural.resolution=48"]),
    (
        "shepp_logan",
        "shepp_logan",
        &["volume.procedural.resolution=40"],
    ),
    (
        "mechanical_part",
        "mechanical_part",
        &["volume.procedural.resolution=48"],
    ),
    (
        "mechanical_part_orthographic",
        "mechanical_part",
        &[
            "volume.procedural.resolution=40",
            "camera.orthographic_height=2.4",
            "technique.ray_march.step=0.25",
        ],
    ),
    (
        "cloud",
        "cloud",
        &[
            "volume.procedural.resolution=32",
            "image.samples_per_axis=2",
        ],
    ),
    (
        "marschner_lobb_cut",
        "marschner_lobb",
        &[
            "volume.procedural.resolution=32",
            "clip.box={min=[-1.0,-0.3,-1.0],max=[1.0,1.0,1.0]}",
        ],
    ),
    (
        "inside",
        "default",
        &[
            "volume.procedural.resolution=40",
            "camera.eye=[0.2,-0.3,0.1]",
            "camera.vfov_deg=80.0",
            "technique.ray_march.empty_space_skipping=false",
        ],
    ),
];

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

fn rendered(scene: &str, overrides: &[&str]) -> Display {
    let fixed = ["image.width=96", "image.height=72", "image.exposure=0.0"];
    let overrides: Vec<_> = fixed
        .iter()
        .chain(overrides)
        .map(|o| Override::parse(o).unwrap())
        .collect();
    let path = root().join(format!("assets/scenes/{scene}.toml"));
    let scene = SceneFile::load(&path, &overrides)
        .unwrap()
        .resolve(&mut |_, _, _| {})
        .unwrap();
    let (operator, exposure) = (scene.image.tone_map, scene.image.exposure);
    let image = render(&device(), &scene);
    assert_eq!(image.non_finite(), 0);
    to_display(
        &image,
        &ToneMapping {
            stops: expose(&image, exposure),
            operator,
        },
        Alpha::Opaque,
    )
}

fn write(path: &Path, display: &Display) {
    fs::create_dir_all(path.parent().unwrap()).unwrap();
    png::write_display(path, display, BitDepth::Eight, false, &Metadata::new()).unwrap();
}

fn golden(technique: &str, name: &str) -> PathBuf {
    root().join(format!("tests/goldens/{technique}/{name}/golden.png"))
}

#[test]
fn ray_march_images_are_the_blessed_ones() {
    assert_blessed("ray_march", &RAY_MARCH);
}

#[test]
fn single_scatter_images_are_the_blessed_ones() {
    assert_blessed("single_scatter", &SINGLE_SCATTER);
}

#[test]
fn ambient_scattering_images_are_the_blessed_ones() {
    assert_blessed("ambient_scattering", &AMBIENT_SCATTERING);
}

#[test]
fn half_angle_images_are_the_blessed_ones() {
    assert_blessed("half_angle", &HALF_ANGLE);
}

#[test]
fn ambient_occlusion_images_are_the_blessed_ones() {
    assert_blessed("ambient_occlusion", &AMBIENT_OCCLUSION);
}

#[test]
fn path_trace_images_are_the_blessed_ones() {
    assert_blessed("path_trace", &PATH_TRACE);
}

fn assert_blessed(technique: &str, cases: &[Case]) {
    let mut failures = Vec::new();
    for &(name, scene, overrides) in cases {
        let golden = golden(technique, name);
        let found = rendered(scene, overrides);
        if std::env::var_os("TYNDALL_BLESS").is_some() {
            write(&golden, &found);
        }
        let expected =
            png::read(&golden).unwrap_or_else(|e| panic!("{e}; bless it with TYNDALL_BLESS=1"));
        let difference = compare(&found, &expected, LEVELS).unwrap();
        if difference.pixels_beyond > 0 {
            let folder = root().join(format!("target/goldens/{technique}/{name}"));
            write(&folder.join("current.png"), &found);
            write(
                &folder.join("difference.png"),
                &picture(&found, &expected, 16.0).unwrap(),
            );
            failures.push(format!("{name}: {difference:?}, see {}", folder.display()));
        }
    }
    assert!(
        failures.is_empty(),
        "{}\nif they are right: TYNDALL_BLESS=1 cargo test --test gpu_goldens",
        failures.join("\n")
    );
}

/// The difference from a golden that a wrong render makes.
fn wrong(name: &str, scene: &str, overrides: &[&str]) -> Difference {
    compare(
        &rendered(scene, overrides),
        &png::read(&golden("ray_march", name)).unwrap(),
        LEVELS,
    )
    .unwrap()
}

#[test]
fn wrong_images_are_told_apart() {
    // A light from the other side, a camera half a degree aside, a density a tenth off, another filter
    // of the volume's data: each must be seen.
    let size = "volume.procedural.resolution=48";
    let mechanical = |more: &str| wrong("mechanical_part", "mechanical_part", &[size, more]);
    let light = "lights=[{directional={direction=[-1.0,0.4,-0.6],irradiance=3.14159}}]";
    let cases = [
        ("light", mechanical(light)),
        ("camera", mechanical("camera.azimuth_deg=45.5")),
        (
            "density",
            wrong("supernova", "default", &[size, "medium.density_scale=1.1"]),
        ),
        (
            "resolution",
            wrong("supernova", "default", &["volume.procedural.resolution=47"]),
        ),
        (
            "exposure",
            wrong("supernova", "default", &[size, "image.exposure=0.1"]),
        ),
    ];
    for (what, difference) in cases {
        // Far more than rounding could move.
        assert!(difference.pixels_beyond > 60, "{what}: {difference:?}");
    }
}
