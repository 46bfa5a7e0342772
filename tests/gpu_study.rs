//! Studies on a device: measured once, resumed, reported; and the setting chosen from them.
#![allow(clippy::unwrap_used, clippy::panic, clippy::expect_used)]

mod common;

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;
use tempfile::TempDir;
use tyndall::scene::file::{Override, SceneFile};
use tyndall::study::{
    Cache, Journal, Pictures, ReferenceGoal, Report, SceneReport, Settings, Subject, run_scene,
    write,
};
use tyndall::volume::procedural::Procedural;

/// The Shepp-Logan phantom at 16^3, seen by 16 x 16 pixels.
const SMALL: [&str; 3] = [
    "volume.procedural.resolution=16",
    "image.width=16",
    "image.height=16",
];

const GOAL: ReferenceGoal = ReferenceGoal {
    error: 0.05,
    // Never reached: the reference must not depend on the machine's speed.
    seconds: 600.0,
    samples: 4096,
};

fn subject() -> Subject {
    let told: Vec<_> = SMALL.iter().map(|o| Override::parse(o).unwrap()).collect();
    let file = |knobs: &[Override]| {
        SceneFile::for_procedural(Procedural::SheppLogan, &[told.as_slice(), knobs].concat())
    };
    let scene = file(&[]).unwrap().resolve(&mut |_, _, _| {}).unwrap();
    Subject::new("phantom".to_owned(), scene, &[], &[], &file).unwrap()
}

#[test]
fn a_study_measures_once_and_goes_on_where_it_was() {
    let folder = TempDir::new().unwrap();
    let device = common::device();
    let subject = subject();
    let cache = Cache::new(folder.path().join("cache")).unwrap();
    let reference = |rendered: &mut bool| {
        let mut show = |_, _| *rendered = true;
        cache
            .reference(&device, &subject, &GOAL, &mut show)
            .unwrap()
    };
    let mut rendered = false;
    let first = reference(&mut rendered);
    assert!(rendered && !first.from_cache);
    // The goal is estimated from 32 samples, and the scene is dark around the phantom.
    assert!(
        first.about.relative_error < 1.5 * GOAL.error,
        "{:?}",
        first.about
    );
    rendered = false;
    let second = reference(&mut rendered);
    assert!(!rendered && second.from_cache);
    assert_eq!(second.about, first.about);
    assert_eq!(second.image, first.image);
    assert_eq!(second.variance, first.variance);

    let pictures = Pictures::new(folder.path().join("images")).unwrap();
    let settings = Settings {
        frames: 2,
        pictures: Some(&pictures),
    };
    let path = folder.path().join("study.jsonl");
    let study = || {
        let mut journal = Journal::open(path.clone(), false).unwrap();
        let mut show = |_| {};
        run_scene(
            &device,
            &subject,
            &first,
            &mut journal,
            &settings,
            &mut show,
        )
        .unwrap()
    };
    let records = study();
    assert_eq!(records.len(), subject.variants.len());
    let kept = fs::read(&path).unwrap();
    assert_eq!(study(), records, "times too: nothing was measured again");
    assert_eq!(fs::read(&path).unwrap(), kept);

    // Interrupted within the last line: that setting alone is measured again.
    fs::write(&path, &kept[..kept.len() - 20]).unwrap();
    let resumed = study();
    assert_eq!(resumed[..resumed.len() - 1], records[..records.len() - 1]);
    let lines = fs::read_to_string(&path).unwrap().lines().count();
    assert_eq!(lines, records.len() + 1, "the torn line and the new one");

    // A lost picture is made again, and with it the measurement.
    fs::remove_file(pictures.error(&records[0].key)).unwrap();
    study();
    assert!(pictures.error(&records[0].key).is_file());

    for record in &records {
        let m = record.outcome.measured().unwrap();
        let label = record.configuration.label();
        assert!(
            m.seconds > 0.0 && m.first_seconds > 0.0 && m.bytes > 0,
            "{label}"
        );
        assert!(
            m.stages.iter().any(|s| s.grows_with_image),
            "{label}: the image"
        );
        let once = |s: &&tyndall::study::Stage| s.name == "medium.upload_table";
        let once = m.stages.iter().find(once).unwrap();
        assert!(
            !once.grows_with_image && once.seconds == 0.0,
            "{label}: a camera change"
        );
    }
    check_report(folder.path(), &subject, &device, &first, records, &pictures);
}

/// Samples help, and the files hold every setting.
fn check_report(
    folder: &Path,
    subject: &Subject,
    device: &tyndall::gpu::Device,
    reference: &tyndall::study::Reference,
    records: Vec<tyndall::study::Record>,
    pictures: &Pictures,
) {
    let flips: Vec<f64> = records
        .iter()
        .filter(|r| r.configuration.technique == "path_trace")
        .map(|r| r.outcome.measured().unwrap().errors.flip)
        .collect();
    assert_eq!(flips.len(), 5);
    assert!(flips[4] < flips[2] && flips[2] < flips[0], "{flips:?}");
    let mut report = Report::new(device.info(), 2);
    pictures.write_reference(reference, &subject.scene).unwrap();
    report
        .scenes
        .push(SceneReport::new(subject, reference, records.clone()));
    let scene = &report.scenes[0];
    assert_eq!(scene.warnings, [""; 0]);
    assert!(!scene.front.is_empty());
    let [csv, json, html] = write(folder, &report, pictures).unwrap();
    let (csv, html) = (
        fs::read_to_string(csv).unwrap(),
        fs::read_to_string(html).unwrap(),
    );
    for record in &records {
        assert!(csv.contains(&record.key) && html.contains(&record.configuration.options()));
    }
    // Of every setting an image and a map, and the reference.
    assert_eq!(
        html.matches("data:image/png;base64,").count(),
        2 * records.len() + 1
    );
    let read: Report = serde_json::from_slice(&fs::read(json).unwrap()).unwrap();
    assert_eq!(read.scenes[0].records.len(), records.len());
}

fn tyndall(folder: &Path, args: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_tyndall"));
    command
        .current_dir(folder)
        .args(args)
        .env("XDG_CACHE_HOME", folder.join("cache"));
    command.env_remove("TYNDALL_DEVICE").output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Runs with a small volume and image, checks the code, and returns what was said on both streams.
fn said(folder: &Path, args: &[&str], code: i32) -> String {
    let small = SMALL
        .iter()
        .flat_map(|key| ["--set", key])
        .collect::<Vec<_>>();
    said_of(folder, &[args, &small].concat(), code)
}

/// The same of the scene as it is.
fn said_of(folder: &Path, args: &[&str], code: i32) -> String {
    let output = tyndall(folder, args);
    let said = text(&output.stdout) + &text(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{args:?}: {said}");
    assert!(!said.contains("panicked"), "{said}");
    said
}

#[test]
fn the_command_studies_and_resumes() {
    let folder = TempDir::new().unwrap();
    let args = [
        "study",
        "shepp_logan",
        "--techniques",
        "ray_march",
        "--frames",
        "1",
        "--reference-error",
        "0.2",
        "-o",
        "results/here",
    ];
    let first = said(folder.path(), &args, 0);
    assert!(first.contains("settings that no other beats"), "{first}");
    let journal = folder.path().join("results/here/study.jsonl");
    let kept = fs::read(&journal).unwrap();
    assert_eq!(said(folder.path(), &args, 0), first);
    assert_eq!(fs::read(&journal).unwrap(), kept);
    said(folder.path(), &[&args[..], &["--fresh"]].concat(), 0);
    assert_ne!(fs::read(&journal).unwrap(), kept, "measured again");
}

#[test]
fn wrong_scenes_are_all_told_before_anything_is_done() {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("wrong.toml"), "[image]\nwidht = 3\n").unwrap();
    let args = ["study", "shepp_logan", "wrong.toml", "missing.nrrd"];
    let message = said_of(folder.path(), &args, 3);
    assert!(
        message.contains("widht") && message.contains("missing.nrrd"),
        "{message}"
    );
    assert!(!folder.path().join("out").exists());
    let message = said(
        folder.path(),
        &["study", "shepp_logan", "--techniques", "x"],
        2,
    );
    assert!(message.contains("expected one of ray_march"), "{message}");
}

/// The part of the JSON output that says what was chosen.
fn chosen(folder: &Path, limit: [&str; 2]) -> Value {
    let args = [
        "render",
        "shepp_logan",
        "--technique",
        "auto",
        "-o",
        "a.json",
    ];
    let sentence = said(folder, &[&args[..], &limit].concat(), 0);
    assert!(sentence.contains("auto: "), "{sentence}");
    let json: Value = serde_json::from_slice(&fs::read(folder.join("a.json")).unwrap()).unwrap();
    let auto = json["auto"].clone();
    assert_eq!(
        json["scene"]["technique"]["name"],
        auto["chosen"]["technique"]
    );
    auto
}

#[test]
fn auto_keeps_its_limit_or_says_the_nearest() {
    let folder = TempDir::new().unwrap();
    let auto = ["render", "shepp_logan", "--technique", "auto"];
    let with = |more: &[&'static str]| [&auto[..], more].concat();
    // The first measures; what is out of reach names what is not.
    let refused = said(folder.path(), &with(&["--max-flip", "1e-9"]), 6);
    let nearest = refused.split("nearest possible value is ").nth(1).unwrap();
    let nearest = nearest.split(',').next().unwrap();
    let found = chosen(folder.path(), ["--max-flip", nearest]);
    assert!(found["chosen"]["flip"].as_f64().unwrap() <= nearest.parse().unwrap());
    let any = chosen(folder.path(), ["--max-flip", "1"]);
    assert!(any["chosen"]["seconds"].as_f64() <= found["chosen"]["seconds"].as_f64());
    assert_eq!(any["settings"], any["settings_that_should_keep_it"]);
    // An hour is enough for the most accurate.
    let slow = chosen(folder.path(), ["--budget", "3600000"]);
    assert!(slow["chosen"]["flip"].as_f64() <= found["chosen"]["flip"].as_f64());
    assert!(slow["found_seconds"].as_f64().unwrap() > 0.0);
    let refused = said(folder.path(), &with(&["--budget", "1e-6"]), 6);
    assert!(
        refused.contains("nearest possible value is about"),
        "{refused}"
    );
}

#[test]
fn auto_needs_one_limit_and_render() {
    let folder = TempDir::new().unwrap();
    let auto = ["render", "shepp_logan", "--technique", "auto"];
    said(folder.path(), &auto, 2);
    said(folder.path(), &[&auto[..], &["--budget", "0"]].concat(), 2);
    let both = ["--budget", "1", "--max-flip", "1"];
    said(folder.path(), &[&auto[..], &both].concat(), 2);
    said(
        folder.path(),
        &["render", "shepp_logan", "--max-flip", "1"],
        2,
    );
    said(
        folder.path(),
        &["plan", "shepp_logan", "--technique", "auto"],
        2,
    );
}
