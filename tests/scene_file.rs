//! Scene files: every key, defaults, automatic choices.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

#[path = "scene_file/errors.rs"]
mod errors;
#[path = "scene_file/overrides.rs"]
mod overrides;

use std::path::PathBuf;
use std::sync::Arc;

use glam::{DVec3, UVec3, Vec3};
use tyndall::scene::file::{Override, SceneError, SceneFile, describe};
use tyndall::scene::{
    Exposure, Falloff, HalfAngleParams, Light, Lighting, Projection, Scene, Shading,
    TechniqueParams, ToneMap, TransportColor, linear_from_srgb,
};
use tyndall::volume::{Grid, ReadOptions, Rescale, Statistics, Volume, Voxels};

fn set(text: &str, sets: &[&str]) -> Result<SceneFile, SceneError> {
    let list: Vec<_> = sets.iter().map(|t| Override::parse(t).unwrap()).collect();
    SceneFile::parse(text, "s.toml", PathBuf::new(), &list)
}

fn parse(text: &str) -> SceneFile {
    set(text, &[]).unwrap_or_else(|e| panic!("{e}"))
}

/// A ramp from 0 to 1 along x, 4 voxels a side.
fn resolved(file: &SceneFile) -> Scene {
    let volume = Volume {
        name: "ramp".to_owned(),
        grid: Grid::centred(UVec3::splat(4), DVec3::ONE),
        voxels: Voxels::F32((0..64u8).map(|i| f32::from(i % 4) / 3.0).collect()),
        rescale: Rescale::IDENTITY,
        spatial_unit: Some("mm".to_owned()),
        height_field: None,
    };
    let statistics = Statistics::of(&volume);
    file.resolve_with(Arc::new(volume), Arc::new(statistics))
        .unwrap_or_else(|e| panic!("{e}"))
}

const EVERYTHING: &str = r#"
[volume]
file = "scan.raw"
time = 2
[volume.raw]
dims = [4, 5, 6]
type = "i16"
spacing = [1, 1, 2.5]
endian = "big"
skip_bytes = 100
[transfer_function]
points = [[0, 0, 0, 0, 0], [1, 1, 0.5, 0.25, 0.5]]
color_space = "linear"
opacity_unit_distance = 2
[medium]
density_scale = 3
albedo = 0.5
phase.g = -0.3
[[lights]]
directional = { direction = [0, 0, -2], irradiance = 3 }
[[lights]]
point = { position = [1, 2, 3], intensity = [4, 5, 6], falloff = "none" }
[[lights]]
environment = { radiance = 0.25 }
[camera]
eye = [10, 0, 0]
target = [1, 0, 0]
up = [0, 1, 0]
vfov_deg = 40
[clip.box]
min = [-1, -1, -1]
max = [1, 1, 1]
[clip.plane]
point = [0, 0, 0]
normal = [0, 0, 3]
[image]
width = 320
height = 200
samples_per_axis = 2
background = [0.1, 0.2, 0.3]
exposure = -1.5
tone_map = "filmic"
[technique]
name = "ray_march"
[technique.ray_march]
step = 0.25
early_termination = 0.9
empty_space_skipping = false
shading = { ambient = 0.5, shininess = 50 }
"#;

#[test]
fn every_key_reaches_the_scene() {
    let file = parse(EVERYTHING);
    let raw = file.spec.volume.raw.as_ref().unwrap();
    assert_eq!((raw.dims, raw.skip_bytes), ([4, 5, 6], Some(100)));
    assert_eq!(raw.spacing, Some([1.0, 1.0, 2.5]));
    assert_eq!(file.spec.volume.time, Some(2));
    let scene = resolved(&file);
    let tf = &scene.medium.transfer_function;
    assert_eq!(tf.points[1].color, Vec3::new(1.0, 0.5, 0.25));
    assert_eq!((tf.points[1].value, tf.points[1].opacity), (1.0, 0.5));
    assert_eq!(tf.opacity_unit_distance, 2.0);
    let m = &scene.medium;
    assert_eq!((m.density_scale, m.albedo, m.phase_g), (3.0, 0.5, -0.3));
    assert!(
        matches!(scene.lights[0], Light::Directional { irradiance, .. }
        if irradiance == Vec3::splat(3.0))
    );
    assert!(
        matches!(scene.lights[1], Light::Point { intensity, falloff: Falloff::None, .. }
        if intensity == Vec3::new(4.0, 5.0, 6.0))
    );
    assert!(matches!(scene.lights[2], Light::Environment { radiance }
        if radiance == Vec3::splat(0.25)));
    let vfov_deg = 40.0;
    let c = &scene.camera;
    assert_eq!(
        (c.eye, c.target, c.up),
        (DVec3::X * 10.0, DVec3::X, DVec3::Y)
    );
    assert_eq!(c.projection, Projection::Perspective { vfov_deg });
    assert_eq!(scene.clip.bounds, Some((-DVec3::ONE, DVec3::ONE)));
    assert_eq!(scene.clip.plane.unwrap().normal.normalize(), DVec3::Z);
    let i = &scene.image;
    assert_eq!((i.width, i.height, i.samples_per_axis), (320, 200, 2));
    assert_eq!(i.background, Vec3::new(0.1, 0.2, 0.3));
    assert_eq!(
        (i.exposure, i.tone_map),
        (Exposure::Stops(-1.5), ToneMap::Filmic)
    );
    let TechniqueParams::RayMarch(p) = scene.technique else {
        panic!("not ray_march");
    };
    let shading = p.shading.unwrap();
    assert_eq!((shading.ambient, shading.shininess), (0.5, 50.0));
    assert_eq!(shading.diffuse, 0.9);
    assert_eq!((p.step, p.early_termination), (0.25, 0.9));
    assert!(!p.empty_space_skipping);
}

#[test]
fn an_empty_file_is_automatic() {
    let scene = resolved(&parse(""));
    assert_eq!(scene.lights.len(), 2);
    assert_eq!((scene.image.width, scene.image.height), (768, 768));
    assert_eq!(scene.image.exposure, Exposure::Auto);
    assert_eq!(
        (scene.medium.density_scale, scene.medium.phase_g),
        (1.0, 0.0)
    );
    let TechniqueParams::RayMarch(p) = scene.technique else {
        panic!("not ray_march");
    };
    assert_eq!((p.step, p.early_termination), (0.5, 0.98));
    assert!(scene.medium.transfer_function.name.starts_with("automatic"));
    assert!(resolved(&parse("lights = []")).lights.is_empty());
}

#[test]
fn transfer_functions_are_points_or_presets() {
    let function = |text: &str| resolved(&parse(text)).medium.transfer_function;
    let row = "transfer_function.points = [[0, 0.5, 0.5, 0.5, 0.1]]\n";
    let srgb = function(row).points[0].color;
    assert_eq!(srgb, Vec3::splat(linear_from_srgb(0.5)));
    let linear = function(&format!("{row}transfer_function.color_space = 'linear'"));
    assert_eq!(linear.points[0].color, Vec3::splat(0.5));
    for preset in ["ct_bone", "ct_soft_tissue", "mri", "generic"] {
        let text = format!("transfer_function.preset = '{preset}'");
        assert!(!function(&text).points.is_empty(), "{preset}");
    }
}

#[test]
fn shading_is_a_switch_or_a_table() {
    let shading = |value: &str| {
        let text = format!("technique.ray_march.shading = {value}");
        let TechniqueParams::RayMarch(p) = resolved(&parse(&text)).technique else {
            panic!("not ray_march");
        };
        p.shading
    };
    assert_eq!(shading("false"), None);
    assert_eq!(shading("true"), Some(Shading::default()));
    assert_eq!(shading("{specular = 0}").unwrap().specular, 0.0);
}

#[test]
fn transport_is_automatic_a_colour_or_rows() {
    let half_angle = |text: &str| {
        let text = format!("[technique]\nname = 'half_angle'\n[technique.half_angle]\n{text}");
        let TechniqueParams::HalfAngle(p) = resolved(&parse(&text)).technique else {
            panic!("not half_angle");
        };
        p
    };
    let transport = |value: &str| half_angle(&format!("transport_color = {value}")).transport_color;
    assert_eq!(transport("'auto'"), TransportColor::Auto);
    let rows = |rows: &[[f64; 4]]| TransportColor::Points(rows.into());
    assert_eq!(transport("[1.0, 0.5, 0.2]"), rows(&[[0.0, 1.0, 0.5, 0.2]]));
    assert_eq!(
        transport("[[10, 1, 0, 0], [20, 0, 1, 0.5]]"),
        rows(&[[10.0, 1.0, 0.0, 0.0], [20.0, 0.0, 1.0, 0.5]])
    );
    let p = half_angle("phase_table = [[1, 1, 1], [2, 3, 4]]\nlighting = 'direct'");
    assert_eq!(p.phase_table.unwrap()[1], [2.0, 3.0, 4.0]);
    assert_eq!(p.lighting, Lighting::Direct);
    assert_eq!(half_angle(""), HalfAngleParams::default());
}

#[test]
fn every_scene_in_assets_is_valid() {
    let mut count = 0;
    for entry in std::fs::read_dir("assets/scenes").unwrap() {
        let file = SceneFile::load(&entry.unwrap().path(), &[]).unwrap_or_else(|e| panic!("{e}"));
        resolved(&file);
        count += 1;
    }
    assert!(count >= 5, "{count}");
}

#[test]
fn a_description_holds_every_setting() {
    let all = describe(&resolved(&parse(EVERYTHING)));
    for (pointer, expected) in [
        ("/volume/name", "\"ramp\""),
        ("/volume/dims", "[4,4,4]"),
        ("/volume/unit", "\"mm\""),
        ("/transfer_function/name", "\"inline\""),
        ("/transfer_function/points/1", "[1.0,1.0,0.5,0.25,0.5]"),
        ("/transfer_function/opacity_unit_distance", "2.0"),
        ("/medium/density_scale", "3.0"),
        ("/medium/albedo", "0.5"),
        ("/medium/phase/g", "-0.3"),
        ("/lights/0/directional/irradiance", "[3.0,3.0,3.0]"),
        ("/lights/1/point/falloff", "\"none\""),
        ("/lights/2/environment/radiance", "[0.25,0.25,0.25]"),
        ("/camera/eye", "[10.0,0.0,0.0]"),
        ("/camera/target", "[1.0,0.0,0.0]"),
        ("/camera/up", "[0.0,1.0,0.0]"),
        ("/camera/projection/vfov_deg", "40.0"),
        ("/clip/box/max", "[1.0,1.0,1.0]"),
        ("/clip/plane/point", "[0.0,0.0,0.0]"),
        ("/image/width", "320"),
        ("/image/height", "200"),
        ("/image/samples_per_axis", "2"),
        ("/image/exposure", "-1.5"),
        ("/image/tone_map", "\"filmic\""),
        ("/technique/name", "\"ray_march\""),
        ("/technique/ray_march/step", "0.25"),
        ("/technique/ray_march/early_termination", "0.9"),
        ("/technique/ray_march/empty_space_skipping", "false"),
        ("/technique/ray_march/shading/shininess", "50.0"),
    ] {
        let found = all.pointer(pointer).map(ToString::to_string);
        assert_eq!(found.as_deref(), Some(expected), "{pointer}");
    }
    assert!(all["image"]["background"].is_array());
}

#[test]
fn paths_are_relative_to_the_scene_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.toml");
    std::fs::write(&path, "volume.file = 'no_such.nrrd'").unwrap();
    let file = SceneFile::load(&path, &[]).unwrap();
    let message = file.resolve(&mut |_, _, _| ()).unwrap_err().to_string();
    let inside = folder.path().join("no_such.nrrd");
    assert!(message.contains(&inside.display().to_string()), "{message}");
}

#[test]
fn a_volume_file_takes_overrides_of_the_volume() {
    let time = [Override::parse("volume.time=3").unwrap()];
    let options = ReadOptions::default();
    let file = SceneFile::for_volume_file("a/\"b\".nrrd".as_ref(), &options, &time).unwrap();
    assert_eq!(file.spec.volume.file.as_deref(), Some("a/\"b\".nrrd"));
    assert_eq!(file.spec.volume.time, Some(3));
}

#[test]
fn shapes_and_noise_reach_the_scene() {
    let file = parse(
        "[transfer_function]\ncolor_space = 'linear'\nopacity_unit_distance = 2\n\
         [[transfer_function.primitives]]\nshape = 'box'\nvalue = [0.5, 2]\ncolor = [1, 0.5, 0]\nopacity = 0.25\n\
         [[transfer_function.primitives]]\nshape = 'triangle'\nvalue = [0, 1]\ngradient = [0, 3]\n\
         color = [0, 0, 1]\nopacity = 1\n\
         [medium.perturbation]\nseed = 9\ntime = 0.5\noctaves = [\n\
         { frequency = 2, displacement = 0.1, velocity = [0, 0, 1] },\n\
         { frequency = 4, opacity = 0.5, color = 0.25, offset = [1, 2, 3] },\n]\n",
    );
    let scene = resolved(&file);
    let function = &scene.medium.transfer_function;
    assert_eq!(function.primitives.len(), 2);
    assert_eq!(function.primitives[0].gradient, [0.0, f64::INFINITY]);
    assert_eq!(function.primitives[0].color, Vec3::new(1.0, 0.5, 0.0));
    assert!((function.material(0.75, 9.0).1 - -(0.75f64).ln() / 2.0).abs() < 1e-12);
    let noise = scene.medium.perturbation.as_ref().unwrap();
    assert_eq!((noise.seed, noise.time, noise.octaves.len()), (9, 0.5, 2));
    assert_eq!(noise.octaves[0].displacement, 0.1);
    assert_eq!(noise.octaves[1].color, Vec3::splat(0.25));
    assert_eq!(noise.octaves[1].offset, DVec3::new(1.0, 2.0, 3.0));
    let told = describe(&scene);
    assert!(told["transfer_function"]["primitives"][0]["gradient"][1].is_null());
    assert_eq!(told["medium"]["perturbation"]["octaves"][1]["opacity"], 0.5);
    // Shapes give way to a preset on the command line.
    let text = "[[transfer_function.primitives]]\nshape = 'box'\nvalue = [0, 1]\ncolor = [1, 1, 1]\nopacity = 1\n";
    let file = set(text, &["transfer_function.preset=ct_bone"]).unwrap();
    assert!(!resolved(&file).medium.transfer_function.has_gradients());
}

#[test]
fn time_moves_noise_that_has_a_velocity_and_no_other() {
    let noise = |velocity: &str| {
        format!(
            "[volume.procedural]\nname = 'cumulus'\nresolution = 4\n[medium.perturbation]\ntime = 0.25\n\
             octaves = [{{ frequency = 2, displacement = 0.1, velocity = {velocity} }}]\n"
        )
    };
    let mut file = parse(&noise("[0, 1, 0]"));
    let time = |scene: &Scene| scene.medium.perturbation.as_ref().unwrap().time;
    let quiet: &mut dyn FnMut(&str, u64, u64) = &mut |_, _, _| {};
    let first = file.resolve_steps(3..=5, quiet).unwrap();
    assert_eq!(time(&first), 3.25);
    let next = file.at_step(&first, 4, &mut |_, _, _| {}).unwrap();
    assert_eq!(time(&next), 4.25);
    assert!(Arc::ptr_eq(&first.volume, &next.volume));
    file.set_time(2).unwrap();
    assert_eq!(time(&file.resolve(&mut |_, _, _| {}).unwrap()), 2.25);
    let mut still = parse(&noise("[0, 0, 0]"));
    let message = still.set_time(2).unwrap_err().to_string();
    assert!(message.contains("or noise that moves"), "{message}");
}
