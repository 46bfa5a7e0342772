//! Time-dependent volumes: what a step re-runs, that it makes nothing anew, that it shows what it
//! would show on its own; and the commands around it.
#![allow(clippy::unwrap_used, clippy::panic)]

mod common;
mod volume_files;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::Arc;

use common::{device, render_beside};
use serde_json::Value;
use tempfile::TempDir;
use tyndall::gpu::Device;
use tyndall::output::png;
use tyndall::scene::Scene;
use tyndall::scene::file::{Override, SceneFile};
use tyndall::technique::Renderer;
use tyndall::volume::{ReadOptions, ScalarType, read};
use volume_files::{Encoding, Nifti, nrrd, nrrd_type, payload, write};

const N: usize = 9;

/// A ball of radius 2.5 that moves along the diagonal, and grows brighter.
fn ball(step: usize) -> Vec<f64> {
    let voxel = |i: usize| {
        let p = [i % N, i / N % N, i / (N * N)];
        let squared = p.map(|x| (x as f64 - 2.0 - 2.0 * step as f64).powi(2));
        let far = squared.iter().sum::<f64>().sqrt() / 2.5;
        (1.0 - far).max(0.0) * (1.0 + step as f64)
    };
    (0..N * N * N).map(voxel).collect()
}

/// Three steps in one file.
fn nifti(folder: &Path, scalar_type: ScalarType) -> PathBuf {
    let n = N as i16;
    let header = Nifti::new(&[n, n, n, 3], scalar_type, false);
    let steps: Vec<f64> = (0..3).flat_map(ball).collect();
    let data = payload(&steps, scalar_type, false, Encoding::Raw);
    write(folder, "ball.nii", &[&header.bytes, &data])
}

/// Three steps in numbered files; the last one has a voxel that is not a number.
fn series(folder: &Path, scalar_type: ScalarType) -> PathBuf {
    let name = nrrd_type(scalar_type);
    let fields =
        format!("type: {name}\ndimension: 3\nsizes: {N} {N} {N}\nendian: little\nencoding: raw");
    for (step, number) in ["08", "10", "200"].into_iter().enumerate() {
        let mut values = ball(step);
        if step == 2 {
            values[N * N * N / 2] = f64::NAN;
        }
        let data = payload(&values, scalar_type, false, Encoding::Raw);
        let parts = [nrrd(&fields).as_bytes(), &data].concat();
        write(folder, &format!("ball_{number}.nrrd"), &[&parts]);
    }
    folder.join("ball_{}.nrrd")
}

/// A scene around a file whose camera does not depend on the volume.
fn scene_file(path: &Path, technique: &str) -> SceneFile {
    let keys = [
        "image.width=24",
        "image.height=20",
        "camera.eye=[30, -40, 20]",
        "camera.target=[4, 4, 4]",
        "transfer_function.points=[[0.2, 1, 0.5, 0.2, 0], [1, 0.2, 0.5, 1, 0.4], [3, 1, 1, 1, 0.9]]",
        "technique.path_trace.samples=4",
    ];
    let technique = format!("technique.name={technique}");
    let keys = keys.into_iter().chain([technique.as_str()]);
    let overrides: Vec<_> = keys.map(|k| Override::parse(k).unwrap()).collect();
    SceneFile::for_volume_file(path, &ReadOptions::default(), &overrides).unwrap()
}

fn held(device: &Device) -> Vec<(String, u64)> {
    let live = device.live_allocations().into_iter();
    let mut held: Vec<_> = live.map(|a| (a.name, a.bytes)).collect();
    held.sort();
    held
}

/// The step in a renderer of its own, read and resolved apart from the others.
fn alone(
    device: &Device,
    path: &Path,
    file: &SceneFile,
    step: u32,
    of: &Scene,
) -> tyndall::output::Image {
    let options = ReadOptions {
        raw: None,
        time: step,
    };
    let volume = read(path, &options, &mut |_, _| {}).unwrap();
    let scene = file
        .resolve_with(Arc::new(volume), of.statistics.clone())
        .unwrap();
    assert_eq!((&scene.camera, &scene.lights), (&of.camera, &of.lights));
    render_beside(device, &scene)
}

/// Renders the three steps of a file through one renderer; `stages` must be those of each further one.
fn steps_run(path: &Path, technique: &str, stages: &[&str]) {
    let device = device();
    let file = scene_file(path, technique);
    let first = file.resolve_steps(0..=2, &mut |_, _, _| {}).unwrap();
    assert_eq!((first.statistics.min, first.statistics.max), (0.0, 3.0));
    let mut renderer = Renderer::new(&device, first).unwrap();
    let (image, _) = renderer.render(&mut |_, _, _| {}).unwrap();
    let mut images = vec![image];
    let (allocated, created) = (held(&device), device.created());
    assert!(created > allocated.len() / 2, "they are counted");
    for step in 1..3 {
        let next = file
            .at_step(renderer.scene(), step, &mut |_, _, _| {})
            .unwrap();
        renderer.set_scene(next).unwrap();
        let (image, report) = renderer.render(&mut |_, _, _| {}).unwrap();
        let ran: Vec<_> = report.stages.iter().map(|s| s.name.as_str()).collect();
        let ran: Vec<_> = ran.iter().map(|s| s.trim_end_matches("_r32f")).collect();
        assert_eq!(ran, stages, "{technique}, step {step}");
        assert_eq!(held(&device), allocated, "{technique}, step {step}");
        assert_eq!(
            device.created(),
            created,
            "{technique}, step {step}: images, pipelines"
        );
        images.push(image);
    }
    for (step, image) in (0..).zip(&images) {
        let alone = alone(&device, path, &file, step, renderer.scene());
        assert!(
            *image == alone,
            "{technique}, step {step} is not as on its own"
        );
    }
    assert!(images[0] != images[1] && images[1] != images[2]);
}

const VOLUME: [&str; 4] = [
    "medium.upload_volume",
    "medium.cell_min_max",
    "medium.cell_occupancy",
    "medium.cell_distance",
];

#[test]
fn a_step_of_a_4d_file_runs_what_depends_on_the_voxels() {
    let dir = TempDir::new().unwrap();
    // Doubles are stored as shares of the range, which must be the same for all steps.
    let path = nifti(dir.path(), ScalarType::F64);
    let march = ["ray_march.march", "ray_march.read_back"];
    steps_run(&path, "ray_march", &[&VOLUME[..], &march].concat());
}

#[test]
fn a_step_of_a_numbered_series_runs_what_depends_on_the_voxels() {
    let dir = TempDir::new().unwrap();
    let path = series(dir.path(), ScalarType::F32);
    // One step has a voxel that is not a number: all have a mask.
    let [upload, cells @ ..] = VOLUME;
    let volume = [&[upload, "medium.upload_mask"][..], &cells].concat();
    let march = ["ray_march.march", "ray_march.read_back"];
    steps_run(&path, "ray_march", &[&volume[..], &march].concat());
    let scatter = [
        "single_scatter.light_cache",
        "single_scatter.march",
        "single_scatter.read_back",
    ];
    steps_run(&path, "single_scatter", &[&volume[..], &scatter].concat());
}

#[test]
fn a_traced_step_makes_nothing_anew_either() {
    let dir = TempDir::new().unwrap();
    let path = nifti(dir.path(), ScalarType::F32);
    let trace = [
        "path_trace.upload_leaves",
        "path_trace.trace",
        "path_trace.read_back",
    ];
    steps_run(
        &path,
        "path_trace",
        &[&["medium.upload_volume"][..], &trace].concat(),
    );
}

fn tyndall(folder: &Path, args: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_tyndall"));
    command
        .current_dir(folder)
        .args(args)
        .env("XDG_CACHE_HOME", folder.join("cache"));
    command.env_remove("TYNDALL_DEVICE").output().unwrap()
}

/// Runs and expects success; returns standard output.
fn done(folder: &Path, args: &[&str]) -> String {
    let output = tyndall(folder, args);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{args:?}: {message}");
    String::from_utf8(output.stdout).unwrap()
}

/// Runs and expects a failure with `code` whose message holds every word.
fn fails(folder: &Path, args: &[&str], code: i32, words: &[&str]) {
    let output = tyndall(folder, args);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(code), "{args:?}: {message}");
    // Long lines are broken.
    let message = message
        .split_whitespace()
        .collect::<Vec<_>>()
        .join(" ")
        .replace(" │ ", " ");
    for word in words {
        assert!(
            message.contains(word),
            "{args:?}: `{word}` is not in\n{message}"
        );
    }
}

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap()
}

#[test]
fn render_writes_a_picture_for_every_step() {
    let dir = TempDir::new().unwrap();
    series(dir.path(), ScalarType::U16);
    let render = ["render", "ball_{}.nrrd", "--size", "24x20"];
    let all = [
        &render[..],
        &["--time", "all", "-o", "all_{}.png", "-o", "all.json"],
    ]
    .concat();
    let printed = done(dir.path(), &all);
    for words in [
        "step 0: all_0.png",
        "step 2: all_2.png",
        "3 steps in",
        "as step 0",
    ] {
        assert!(printed.contains(words), "{words}: {printed}");
    }
    let report = json(&fs::read_to_string(dir.path().join("all.json")).unwrap());
    let steps = report["steps"].as_array().unwrap();
    assert_eq!(steps.len(), 3);
    assert_eq!(steps[2]["volume"], "ball_200.nrrd");
    assert_eq!(steps[1]["files"][0], "all_1.png");
    let stages = |i: usize| steps[i]["frame"]["stages"].as_array().unwrap().len();
    assert_eq!(stages(1), stages(0) - 1, "all but the table");
    assert!(report["exposure_stops"].is_number() && report["frame"].is_null());
    let two = png::read_metadata(&dir.path().join("all_2.png")).unwrap();
    assert_eq!(two["time_step"], "2");

    // A part of them, by the default name; a report for each.
    let part = [&render[..], &["--time", "1..2", "-q"]].concat();
    done(dir.path(), &part);
    assert!(!dir.path().join("ball_0.png").exists() && dir.path().join("ball_2.png").exists());
    let each = [
        &render[..],
        &["--time", "1..2", "--json", "-o", "{}.json", "-q"],
    ]
    .concat();
    let printed = json(&done(dir.path(), &each));
    assert_eq!(printed["steps"][0]["time_step"], 1);
    let one = json(&fs::read_to_string(dir.path().join("1.json")).unwrap());
    assert_eq!(one["frame"]["stages"].as_array().unwrap().len(), stages(0));

    // One step, whose number is put into the name as well.
    done(
        dir.path(),
        &[&render[..], &["--time", "1", "-o", "one_{}.png"]].concat(),
    );
    assert!(dir.path().join("one_1.png").exists());
}

#[test]
fn a_scene_file_names_a_series_and_a_step() {
    let dir = TempDir::new().unwrap();
    series(dir.path(), ScalarType::F32);
    let scene = "[volume]\nfile = \"ball_{}.nrrd\"\ntime = 1\n[image]\nwidth = 20\nheight = 16\n";
    fs::write(dir.path().join("scene.toml"), scene).unwrap();
    let of = |args: &[&str]| {
        json(&done(
            dir.path(),
            &[&["info", "scene.toml", "--json"], args].concat(),
        ))
    };
    let info = of(&[]);
    assert_eq!(
        (&info["time_steps"], &info["time_step"]),
        (&3.into(), &1.into())
    );
    assert_eq!(info["volume"]["name"], "ball_10.nrrd");
    assert_eq!(of(&["--time", "2"])["volume"]["name"], "ball_200.nrrd");
    assert_eq!(of(&["--time", "2"])["statistics"]["nan"], 1);
    let text = done(dir.path(), &["info", "scene.toml"]);
    assert!(text.contains("3 steps, 0 to 2; here step 1"), "{text}");
    let header = done(dir.path(), &["info", "ball_{}.nrrd", "--header"]);
    assert!(header.contains("3 time step(s)"), "{header}");
    done(
        dir.path(),
        &[
            "render",
            "scene.toml",
            "--time",
            "0..1",
            "-o",
            "s{}.png",
            "--validate",
        ],
    );
    assert!(dir.path().join("s1.png").exists());
}

#[test]
fn bench_measures_a_time_step_where_there_are_several() {
    let dir = TempDir::new().unwrap();
    series(dir.path(), ScalarType::F32);
    let quick = ["--frames", "1", "--warmup", "0", "--repeat", "2", "--json"];
    let scene = [
        "bench",
        "ball_{}.nrrd",
        "--time",
        "2",
        "--set",
        "image.width=20",
        "--set",
        "image.height=16",
    ];
    let report = json(&done(dir.path(), &[&scene[..], &quick].concat()));
    let changes = report["changes"].as_array().unwrap();
    let row = changes.iter().find(|c| c["what"] == "time step").unwrap();
    assert!(row["device_seconds"]["median"].as_f64().unwrap() > 0.0);
    assert!(row["wall_seconds"]["median"].as_f64().unwrap() > 0.0);
    let ran = row["stages"].as_array().unwrap();
    assert_eq!(ran[0], "medium.upload_volume");
    assert!(ran.iter().all(|s| s != "medium.upload_table"), "{ran:?}");
}

#[test]
fn what_cannot_be_is_refused() {
    let dir = TempDir::new().unwrap();
    series(dir.path(), ScalarType::U16);
    let render = |args: &[&'static str]| [&["render", "ball_{}.nrrd"], args].concat();
    let no_place = render(&["--time", "all", "-o", "out.png"]);
    fails(
        dir.path(),
        &no_place,
        2,
        &["--output out.png", "{} in the name, as in out_{}.png"],
    );
    let beyond = render(&["--time", "1..3"]);
    fails(
        dir.path(),
        &beyond,
        3,
        &["ball_{}.nrrd", "3 time step(s)", "steps 1 to 3"],
    );
    let beyond = render(&["--time", "3"]);
    fails(
        dir.path(),
        &beyond,
        3,
        &["time step 3", "0 (ball_08.nrrd) to 2 (ball_200.nrrd)"],
    );
    fails(
        dir.path(),
        &render(&["--time", "2..1"]),
        2,
        &["FIRST..LAST"],
    );
    let auto = render(&["--time", "all", "--technique", "auto", "--max-flip", "0.1"]);
    fails(
        dir.path(),
        &auto,
        2,
        &["--technique auto", "several time steps"],
    );
    fails(
        dir.path(),
        &["info", "ball_{}.nrrd", "--time", "all"],
        2,
        &["`render`"],
    );
    fails(
        dir.path(),
        &["render", "cloud", "--time", "1"],
        3,
        &["a formula"],
    );
    fails(
        dir.path(),
        &["render", "bowl_{}.nrrd"],
        3,
        &["bowl_{}.nrrd", "none among 3 names"],
    );
    let wider = nrrd("type: ushort\ndimension: 3\nsizes: 9 9 8\nendian: little\nencoding: raw");
    write(
        dir.path(),
        "ball_300.nrrd",
        &[wider.as_bytes(), &[0; 2 * 9 * 9 * 8]],
    );
    let mixed = render(&["--time", "all"]);
    let words = [
        "ball_300.nrrd",
        "9 × 9 × 8 voxels of u16",
        "9 × 9 × 9",
        "ball_08.nrrd",
    ];
    fails(dir.path(), &mixed, 3, &words);
    let pictures = fs::read_dir(dir.path()).unwrap();
    let pictures = pictures.filter(|e| {
        e.as_ref()
            .unwrap()
            .path()
            .extension()
            .is_some_and(|x| x == "png")
    });
    assert_eq!(pictures.count(), 0, "failures leave nothing behind");
}
