//! The command as a user runs it: files, exit codes, messages.
#![allow(clippy::unwrap_used, clippy::panic)]

use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};

use serde_json::Value;
use tempfile::TempDir;
use tyndall::output::{exr, png};

/// A small and quick built-in scene.
const SMALL: [&str; 4] = [
    "--set",
    "volume.procedural.resolution=16",
    "--set",
    "image.width=40",
];

fn tyndall(folder: &Path, args: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_tyndall"));
    // The pipeline cache goes to the test's own folder.
    command
        .current_dir(folder)
        .args(args)
        .env("XDG_CACHE_HOME", folder.join("cache"));
    command.env_remove("TYNDALL_DEVICE").output().unwrap()
}

fn small<'a>(args: &[&'a str]) -> Vec<&'a str> {
    [args, &SMALL, &["--set", "image.height=30"]].concat()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Runs and expects success; returns standard output.
fn done(folder: &Path, args: &[&str]) -> String {
    let output = tyndall(folder, args);
    assert!(
        output.status.success(),
        "{args:?}: {}",
        text(&output.stderr)
    );
    text(&output.stdout)
}

/// Runs and expects a failure with `code` whose message holds every word.
fn fails(folder: &Path, args: &[&str], code: i32, words: &[&str]) {
    let output = tyndall(folder, args);
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{args:?}: {message}");
    for word in words {
        assert!(
            message.contains(word),
            "{args:?}: `{word}` is not in\n{message}"
        );
    }
    assert!(!message.contains("panicked"), "{message}");
}

/// A NIfTI-1 file of 4 x 3 x 2 voxels, u8, rotated by no quaternion but with a qform of RAS axes.
fn nifti() -> Vec<u8> {
    let mut bytes = vec![0u8; 352];
    let mut put = |at: usize, value: &[u8]| bytes[at..at + value.len()].copy_from_slice(value);
    put(0, &348i32.to_le_bytes());
    for (i, n) in [3i16, 4, 3, 2, 1, 1, 1, 1].into_iter().enumerate() {
        put(40 + 2 * i, &n.to_le_bytes());
    }
    put(70, &2i16.to_le_bytes());
    put(72, &8i16.to_le_bytes());
    for (i, x) in [1f32, 2.0, 2.0, 3.0, 0.0, 0.0, 0.0, 0.0]
        .into_iter()
        .enumerate()
    {
        put(76 + 4 * i, &x.to_le_bytes());
    }
    put(108, &352f32.to_le_bytes());
    put(112, &1f32.to_le_bytes());
    put(252, &1i16.to_le_bytes());
    put(344, b"n+1\0");
    bytes.extend((0..24u8).map(|i| i * 10));
    bytes
}

#[test]
fn render_writes_png_exr_and_json_that_say_where_they_come_from() {
    let folder = TempDir::new().unwrap();
    let at = |name: &str| folder.path().join(name);
    done(
        folder.path(),
        &small(&["render", "-o", "a.png", "-o", "a.exr", "-o", "a.json"]),
    );
    let picture = png::read(&at("a.png")).unwrap();
    assert_eq!((picture.width, picture.height), (40, 30));
    let stated = png::read_metadata(&at("a.png")).unwrap();
    for key in ["device", "driver", "scene", "technique", "version"] {
        assert!(stated.contains_key(key), "{key} in {stated:?}");
    }
    let raw = fs::read(at("a.png")).unwrap();
    for word in ["Exposure", "Tone map"] {
        assert!(
            raw.windows(word.len()).any(|w| w == word.as_bytes()),
            "{word}"
        );
    }
    let image = exr::read(&at("a.exr")).unwrap();
    assert!(image.pixels.iter().any(|p| p[3] > 0.1), "something is seen");
    assert_eq!(
        exr::read_metadata(&at("a.exr")).unwrap()["technique"],
        "ray_march"
    );
    let json: Value = serde_json::from_slice(&fs::read(at("a.json")).unwrap()).unwrap();
    let stages = json["frame"]["stages"].as_array().unwrap();
    assert!(stages.iter().any(
        |s| s["name"].as_str().unwrap().starts_with("ray_march.march")
            && s["seconds"].as_f64().unwrap() > 0.0
    ));
    assert!(json["bytes_allocated"].as_u64().unwrap() >= 40 * 30 * 16);
    assert_eq!(json["scene"]["image"]["width"], 40);
    assert!(json["device"]["name"].is_string());
}

#[test]
fn options_reach_the_image() {
    let folder = TempDir::new().unwrap();
    let at = |name: &str| folder.path().join(name);
    done(
        folder.path(),
        &small(&["render", "--alpha", "--bits", "16", "-o", "alpha.png"]),
    );
    let picture = png::read(&at("alpha.png")).unwrap();
    assert_eq!(picture.pixels[0][3], 0.0, "the corner is transparent");
    let printed = done(
        folder.path(),
        &[
            "render",
            "shepp_logan",
            "--size",
            "20x10",
            "--exposure",
            "-1.5",
            "--tone-map",
            "reinhard",
            "--json",
            "-q",
        ],
    );
    let json: Value = serde_json::from_str(&printed).unwrap();
    assert_eq!(json["exposure_stops"], -1.5);
    assert_eq!(json["tone_map"], "reinhard");
    assert_eq!(
        png::read(&at("shepp_logan.png")).unwrap().height,
        10,
        "named after its input"
    );
}

#[test]
fn path_trace_ends_at_its_goal() {
    let folder = tempfile::tempdir().unwrap();
    let render = |goal: &[&str]| {
        let args = [
            &[
                "render",
                "cloud",
                "--technique",
                "path_trace",
                "--size",
                "24x24",
                "-o",
                "a.json",
            ],
            &["--set", "volume.procedural.resolution=24"][..],
            goal,
        ]
        .concat();
        done(folder.path(), &args);
        let text = fs::read_to_string(folder.path().join("a.json")).unwrap();
        serde_json::from_str::<Value>(&text).unwrap()["frame"]["samples"]
            .as_u64()
            .unwrap()
    };
    assert_eq!(render(&["--spp", "5"]), 5);
    let (rough, fine) = (
        render(&["--target-error", "0.05"]),
        render(&["--target-error", "0.0125"]),
    );
    // A quarter of the error takes sixteen times the samples.
    assert!(fine > 6 * rough && fine < 40 * rough, "{rough} {fine}");
    assert!(render(&["--time", "300ms", "--spp", "100000"]) < 100_000);
    let scene = ["render", "cloud", "--spp", "4"];
    fails(
        folder.path(),
        &scene,
        2,
        &["--spp", "--technique path_trace"],
    );
    let time = ["render", "cloud", "--time", "soon"];
    fails(folder.path(), &time, 2, &["time step", "30s"]);
}

/// Seeds differ by what the variances explain, a bias by more.
#[test]
fn path_traced_exrs_tell_noise_from_bias() {
    let folder = TempDir::new().unwrap();
    let at = |name: &str| folder.path().join(name);
    let render = |name: &str, options: &[&str]| {
        let cloud = ["render", "cloud", "-q", "-o", name, "--size", "32x24"];
        let quick = ["--set", "volume.procedural.resolution=16"];
        let traced = [&cloud, &quick[..], &["--technique", "path_trace"], options];
        done(folder.path(), &traced.concat());
    };
    let seed = |name, seed| render(name, &["--spp", "256", "--set", seed]);
    seed("a.exr", "technique.path_trace.seed=1");
    seed("b.exr", "technique.path_trace.seed=2");
    let variance = exr::read_variance(&at("a.exr")).unwrap().unwrap();
    assert_eq!(variance.pixels.len(), 32 * 24);
    assert!(variance.pixels.iter().any(|p| p[0] > 0.0));

    // The cloud covers some 270 pixels. Of as many normal numbers the largest is about 3; samples
    // of light have longer tails. By chance the mean of a channel is beyond 5 once in half a million.
    let limits = ["--max-z", "8", "--max-mean-z", "5"];
    let args = [&["compare", "a.exr", "b.exr", "--json"][..], &limits].concat();
    let report: Value = serde_json::from_str(&done(folder.path(), &args)).unwrap();
    // Were the variances too small or too large by a factor of two, this would be 1.4 or 0.7. It
    // spreads by 1 / sqrt(2 * 270) = 0.04.
    let rms = report["comparison"]["z_score"]["rms"].as_f64().unwrap();
    assert!((0.8..1.25).contains(&rms), "{rms}");

    // Light that is scattered more than once is missing.
    let single = [
        "--spp",
        "256",
        "--set",
        "technique.path_trace.max_scatter=1",
    ];
    render("single.exr", &single);
    let args = ["compare", "single.exr", "a.exr", "--max-mean-z", "5"];
    fails(folder.path(), &args, 6, &["--max-mean-z 5", "found"]);

    // One sample says nothing of its variance, nor does a technique without chance.
    render("one.exr", &["--spp", "1"]);
    assert_eq!(exr::read_variance(&at("one.exr")).unwrap(), None);
    done(folder.path(), &small(&["render", "-q", "-o", "march.exr"]));
    assert_eq!(exr::read_variance(&at("march.exr")).unwrap(), None);
}

#[test]
fn volume_files_render_without_a_scene() {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("scan.nii"), nifti()).unwrap();
    fs::write(
        folder.path().join("scan.raw"),
        (0..24u8).collect::<Vec<_>>(),
    )
    .unwrap();
    done(
        folder.path(),
        &[
            "render",
            "scan.nii",
            "--size",
            "16x16",
            "-o",
            "nii.png",
            "--validate",
        ],
    );
    let raw = [
        "--dims",
        "4,3,2",
        "--type",
        "u8",
        "--spacing",
        "2,2,3",
        "--size",
        "16x16",
    ];
    done(
        folder.path(),
        &[
            &["render", "scan.raw", "--tf", "generic", "-o", "raw.png"],
            &raw[..],
        ]
        .concat(),
    );
    let header = done(folder.path(), &["info", "scan.nii", "--header", "--json"]);
    let header: Value = serde_json::from_str(&header).unwrap();
    assert_eq!(header["dims"], serde_json::json!([4, 3, 2]));
    assert_eq!(header["space"], "patient_ras");
    let info: Value =
        serde_json::from_str(&done(folder.path(), &["info", "scan.nii", "--json"])).unwrap();
    assert_eq!(info["statistics"]["max"], 230.0);
    assert!(done(folder.path(), &["info", "scan.nii"]).contains("4 x 3 x 2 of u8"));
    fails(
        folder.path(),
        &["render", "scan.raw"],
        3,
        &["scan.raw", "--dims"],
    );
}

#[test]
fn the_other_commands_print_for_people_and_programs() {
    let folder = TempDir::new().unwrap();
    let json =
        |args: &[&str]| -> Value { serde_json::from_str(&done(folder.path(), args)).unwrap() };
    assert!(json(&["devices", "--json"])[0]["name"].is_string());
    assert!(done(folder.path(), &["devices"]).contains("usable"));
    assert_eq!(json(&small(&["plan", "--json"]))["technique"], "ray_march");
    assert!(done(folder.path(), &small(&["plan"])).contains("left out"));
    let bench = json(&small(&[
        "bench", "--frames", "2", "--warmup", "1", "--repeat", "1", "--json",
    ]));
    let changes: Vec<_> = bench["changes"]
        .as_array()
        .unwrap()
        .iter()
        .map(|c| c["what"].as_str().unwrap())
        .collect();
    assert_eq!(
        changes,
        [
            "nothing",
            "volume",
            "transfer function",
            "phase",
            "light",
            "camera"
        ]
    );
    assert!(bench["orbit"][0]["seconds"]["median"].as_f64().unwrap() > 0.0);
    let table = done(
        folder.path(),
        &small(&["bench", "--frames", "1", "--warmup", "0", "--repeat", "1"]),
    );
    assert!(table.contains("first frame") && table.contains("ray_march.march"));
    assert!(done(folder.path(), &["completions", "bash"]).contains("_tyndall"));
}

#[test]
fn bench_puts_a_papers_ratios_beside_its_own() {
    let folder = TempDir::new().unwrap();
    let paper = ["bench", "--paper", "ament2013"];
    let one = [
        "--rows", "buoyancy", "--size", "32x24", "--frames", "1", "--repeat", "1", "--json",
    ];
    let report: Value =
        serde_json::from_str(&done(folder.path(), &[&paper[..], &one].concat())).unwrap();
    assert_eq!(report["image"], serde_json::json!([32, 24]));
    assert_eq!(report["rows"].as_array().unwrap().len(), 1);
    let row = &report["rows"][0];
    assert_eq!(row["dims"], serde_json::json!([181, 91, 181]));
    let models = row["models"].as_array().unwrap();
    let names: Vec<_> = models
        .iter()
        .map(|m| m["model"].as_str().unwrap())
        .collect();
    assert!(names.contains(&"emission_absorption"), "{names:?}");
    assert!(names.contains(&"single_scattering"), "{names:?}");
    let ambient = models
        .iter()
        .find(|m| m["model"] == "ambient_scattering")
        .unwrap();
    let whats: Vec<_> = ambient["times"]
        .as_array()
        .unwrap()
        .iter()
        .map(|t| &t["what"])
        .collect();
    assert_eq!(whats, ["transfer_function", "phase", "light", "rendering"]);
    let rendering = &ambient["times"][3];
    let printed = rendering["over_unlit"]["paper"].as_f64().unwrap();
    assert!((printed - 180.0 / 63.0).abs() < 1e-9, "{printed}");
    assert!(ambient["bytes"].as_u64().unwrap() > 0);
    assert!(
        report["summary"]
            .as_array()
            .unwrap()
            .iter()
            .any(|s| s["goal"] == 1.5)
    );
}

#[test]
fn bench_puts_slices_with_light_beside_those_without() {
    let folder = TempDir::new().unwrap();
    let args = [
        "bench",
        "--paper",
        "kniss2003",
        "--size",
        "16x12",
        "--frames",
        "1",
        "--repeat",
        "1",
        "--json",
    ];
    let report: Value = serde_json::from_str(&done(folder.path(), &args)).unwrap();
    assert_eq!(report["unlit"], "slices_unlit");
    let row = &report["rows"][0];
    assert_eq!(row["dims"], serde_json::json!([256, 256, 512]));
    assert_eq!(row["radius_voxels"], Value::Null);
    let models = row["models"].as_array().unwrap();
    let names: Vec<_> = models.iter().map(|m| &m["model"]).collect();
    let expected = [
        "slices_unlit",
        "slices_surface",
        "slices_direct",
        "slices_indirect",
        "slices_noise",
    ];
    assert_eq!(names, expected);
    for model in models {
        assert_eq!(model["technique"], "half_angle");
        // Nothing is kept from frame to frame, so that no change has a time of its own.
        let times = model["times"].as_array().unwrap();
        assert_eq!(times.len(), 1, "{model}");
        assert_eq!(times[0]["what"], "rendering");
        assert_eq!(times[0]["paper_seconds"], Value::Null, "a share, no time");
    }
    let indirect = &models[3]["times"][0]["over_unlit"];
    assert!(indirect["here"].as_f64().unwrap() > 0.0);
    let paper = indirect["paper"].as_f64().unwrap();
    assert!((2.0..=2.5).contains(&paper), "{paper}");
    let mut summary = report["summary"].as_array().unwrap().iter();
    assert!(summary.any(|s| s["model"] == "slices_indirect" && s["goal"] == 1.6));
}

#[test]
fn bench_refuses_a_scene_beside_a_paper_and_rows_it_does_not_have() {
    let folder = TempDir::new().unwrap();
    let paper = ["bench", "--paper", "ament2013"];
    let with = |more: &[&'static str]| [&paper[..], more].concat();
    fails(
        folder.path(),
        &with(&["--rows", "8"]),
        2,
        &["--rows 8", "7 Boundary Layer"],
    );
    for more in [
        ["cloud"].as_slice(),
        &["--technique", "ray_march"],
        &["--warmup", "1"],
    ] {
        fails(folder.path(), &with(more), 2, &["cannot be used with"]);
    }
    fails(folder.path(), &["bench", "--rows", "1"], 2, &["--paper"]);
}

#[test]
fn the_published_schema_is_the_programs() {
    let folder = TempDir::new().unwrap();
    let published = fs::read_to_string(format!(
        "{}/assets/scene.schema.json",
        env!("CARGO_MANIFEST_DIR")
    ))
    .unwrap();
    let now = done(folder.path(), &["schema"]);
    assert!(
        now == published,
        "stale; run: cargo run -- schema > assets/scene.schema.json"
    );
}

#[test]
fn failures_have_their_exit_code_and_name_the_cause() {
    let folder = TempDir::new().unwrap();
    let file = |name: &str, content: &str| fs::write(folder.path().join(name), content).unwrap();
    file("key.toml", "[image]\nwidht = 3\n");
    file("value.toml", "[medium]\nalbedo = 2\n");
    file(
        "bad.nrrd",
        "NRRD0004\ntype: float\ndimension: 3\nsizes: 1 2\n\n",
    );
    fails(
        folder.path(),
        &["render", "key.toml"],
        3,
        &["key.toml:2:1", "widht", "`width`"],
    );
    fails(
        folder.path(),
        &["render", "value.toml"],
        3,
        &["value.toml:2:1", "medium.albedo", "2", "from 0 to 1"],
    );
    fails(
        folder.path(),
        &["render", "bad.nrrd"],
        3,
        &["bad.nrrd", "sizes"],
    );
    fails(
        folder.path(),
        &["render", "none.nii.gz"],
        3,
        &["none.nii.gz", "open"],
    );
    fails(
        folder.path(),
        &["render", "--set", "image.width"],
        3,
        &["KEY=VALUE"],
    );
    fails(
        folder.path(),
        &["render", "-o", "a.jpg"],
        2,
        &["a.jpg", ".png, .exr or .json"],
    );
    fails(
        folder.path(),
        &["render", "--size", "12"],
        2,
        &["WIDTHxHEIGHT"],
    );
    fails(folder.path(), &["render", "--nonsense"], 2, &["--nonsense"]);
    fails(
        folder.path(),
        &["render", "-o", "no/where.png"],
        1,
        &["no", "folder"],
    );
    fails(
        folder.path(),
        &small(&["render", "--device", "no such device"]),
        4,
        &["no such device", "available"],
    );
    fails(
        folder.path(),
        &small(&["render", "--set", "technique.ray_march.step=0"]),
        3,
        &["technique.ray_march.step"],
    );
    let left: Vec<_> = fs::read_dir(folder.path())
        .unwrap()
        .map(|e| e.unwrap().file_name().into_string().unwrap())
        .filter(|name| !["key.toml", "value.toml", "bad.nrrd", "cache"].contains(&name.as_str()))
        .collect();
    assert!(left.is_empty(), "failures leave nothing behind: {left:?}");
}

#[test]
fn a_reader_that_goes_away_is_no_failure() {
    let folder = TempDir::new().unwrap();
    let mut child = Command::new(env!("CARGO_BIN_EXE_tyndall"))
        .current_dir(folder.path())
        .args(["completions", "zsh"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert!(
        !text(&output.stderr).contains("panicked"),
        "{}",
        text(&output.stderr)
    );
}

#[test]
fn no_progress_bar_is_drawn_where_nobody_watches() {
    let folder = TempDir::new().unwrap();
    let output = tyndall(folder.path(), &small(&["render", "-o", "a.png"]));
    let message = text(&output.stderr);
    assert!(
        !message.contains('\r') && !message.contains('\u{1b}'),
        "{message:?}"
    );
    let quiet = tyndall(folder.path(), &small(&["render", "-q", "-o", "a.png"]));
    assert!(
        quiet.stdout.is_empty() && quiet.stderr.is_empty(),
        "{quiet:?}"
    );
}
