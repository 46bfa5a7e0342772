//! Studies without a device: what is tried, what is kept, what is chosen, what is written.
#![allow(clippy::unwrap_used, clippy::panic)]

use std::fs;
use std::path::PathBuf;

use tempfile::TempDir;
use tyndall::scene::file::{Override, SceneFile};
use tyndall::study::{
    About, Configuration, Errors, Goal, Journal, Measured, Outcome, Pictures, Record, Report,
    SceneReport, Search, Setting, Stage, StudyError, Subject, expand, extrapolate, front, plot,
    to_csv, to_html,
};
use tyndall::technique::{KNOBS, Knob, Knobs, NAMES};
use tyndall::volume::procedural::Procedural;

/// Most settings of a technique that a study should try.
const FEW: usize = 24;

fn overrides(list: &[&str]) -> Vec<Override> {
    list.iter().map(|o| Override::parse(o).unwrap()).collect()
}

/// The Shepp-Logan phantom at 8^3.
fn subject(more: &[&str], techniques: &[&str], fixed: &[&str]) -> Result<Subject, StudyError> {
    let told = overrides(&[&["volume.procedural.resolution=8"], more].concat());
    let file = |knobs: &[Override]| {
        SceneFile::for_procedural(Procedural::SheppLogan, &[told.as_slice(), knobs].concat())
    };
    let scene = file(&[]).unwrap().resolve(&mut |_, _, _| {}).unwrap();
    let owned = |list: &[&str]| list.iter().map(|t| (*t).to_owned()).collect::<Vec<_>>();
    Subject::new(
        "phantom".to_owned(),
        scene,
        &owned(techniques),
        &owned(fixed),
        &file,
    )
}

fn labels(subject: &Subject) -> Vec<String> {
    let variants = subject.variants.iter();
    variants.map(|v| v.configuration.label()).collect()
}

fn configuration(technique: &str, value: &str) -> Configuration {
    Configuration {
        technique: technique.to_owned(),
        settings: vec![Setting {
            key: format!("technique.{technique}.step"),
            value: value.to_owned(),
        }],
    }
}

fn measured(seconds: f64, flip: f64) -> Measured {
    let stage = |name: &str, seconds, grows_with_image| Stage {
        name: name.to_owned(),
        seconds,
        first_seconds: 2.0 * seconds,
        grows_with_image,
    };
    Measured {
        seconds,
        first_seconds: 4.0 * seconds,
        stages: vec![
            stage("t.cache", 0.25 * seconds, false),
            stage("t.image", 0.5 * seconds, true),
        ],
        bytes: 1024,
        samples: Some(4),
        errors: Errors {
            rmse: 0.125,
            relative_mse: None,
            bias: -0.5,
            relative_bias: Some(-0.25),
            flip,
            flip_largest: 0.75,
            hdr_flip: Some(0.0625),
            ssim: None,
        },
    }
}

fn record(key: &str, technique: &str, value: &str, outcome: Outcome) -> Record {
    Record {
        key: key.to_owned(),
        scene: "phantom".to_owned(),
        device: "device, \"quoted\"".to_owned(),
        image: [32, 16],
        frames: 3,
        configuration: configuration(technique, value),
        outcome,
    }
}

fn rendered(key: &str, technique: &str, value: &str, seconds: f64, flip: f64) -> Record {
    let outcome = Outcome::Measured(Box::new(measured(seconds, flip)));
    record(key, technique, value, outcome)
}

/// A scene with a name that tries to leave its place, three settings and one that failed.
fn report() -> Report {
    let failed = Outcome::Failed("too <small>, \"far\" & wide".to_owned());
    let records = vec![
        rendered("a1", "ray_march", "1", 0.5, 0.25),
        rendered("a2", "ray_march", "0.5", 1.0, 0.5),
        record("a3", "ray_march", "0.25", failed),
        rendered("a4", "path_trace", "4", 2.0, 0.125),
    ];
    Report {
        tyndall: "0".to_owned(),
        device: "a <b>device</b>".to_owned(),
        driver: "driver".to_owned(),
        vulkan: "1.3".to_owned(),
        frames: 3,
        scenes: vec![SceneReport {
            name: "<script>alert(1)</script> & \"x\"".to_owned(),
            scene_hash: "5ce4e".to_owned(),
            voxels_hash: "70e15".to_owned(),
            image: [32, 16],
            reference: About {
                key: "aa".to_owned(),
                samples: 100,
                relative_error: 0.0078125,
                goal_error: 0.005,
                seconds: 1.5,
            },
            warnings: vec!["do not < trust".to_owned()],
            front: vec![0, 3],
            records,
        }],
    }
}

#[test]
fn every_technique_has_a_few_settings_that_its_scenes_accept() {
    let named: Vec<_> = KNOBS.iter().map(|k| k.technique).collect();
    assert_eq!(named, NAMES);
    for Knobs {
        technique: name,
        knobs,
        ..
    } in KNOBS
    {
        for knob in *knobs {
            let own = knob.key.starts_with(&format!("technique.{name}."));
            assert!(own || knob.key == Knob::SAMPLES_PER_AXIS, "{}", knob.key);
        }
        // Fails if a value is refused.
        let found = subject(&[], &[name], &[]).unwrap().variants.len();
        assert!((2..=FEW).contains(&found), "{name}: {found} settings");
    }
}

#[test]
fn knobs_that_do_not_apply_or_are_set_by_hand_stay_as_they_are() {
    let lit = labels(&subject(&[], &["ray_march"], &[]).unwrap());
    assert_eq!(lit.len(), 20);
    assert_eq!(lit[0], "step=4 samples_per_axis=1 merge_opacity=1");
    let unlit = subject(&["technique.ray_march.shading=false"], &["ray_march"], &[]).unwrap();
    assert_eq!(unlit.variants.len(), 10);
    let scene = unlit.variants[0].apply(&unlit.scene);
    assert!(!scene.technique.uses_lights(), "shading stays off");
    let fixed = ["technique.ray_march.step", "image.samples_per_axis"];
    let fixed = subject(&[], &["ray_march"], &fixed).unwrap();
    assert_eq!(
        labels(&fixed),
        ["merge_opacity=1", "merge_opacity=0.015625"]
    );
    let all = subject(&[], &[], &[]).unwrap();
    assert_eq!(all.variants.len(), 20 + 24 + 24 + 11 + 14 + 5);
    let refused = subject(&[], &["ray_marsh"], &[]).unwrap_err().to_string();
    assert!(
        refused.contains("ray_marsh") && refused.contains("path_trace"),
        "{refused}"
    );
}

#[test]
fn few_knobs_are_combined_and_many_are_not() {
    let three = Knob::new("a.x", &["1", "2", "3"]);
    let two = Knob::new("a.y", &["0", "9"]);
    let short = |settings: Vec<Vec<Setting>>| -> Vec<String> {
        let join = |list: &Vec<Setting>| list.iter().map(|s| s.value.clone()).collect();
        settings.iter().map(join).collect()
    };
    let all = ["10", "19", "20", "29", "30", "39"];
    assert_eq!(short(expand(&[three, two])), all);
    assert_eq!(short(expand(&[])), [""]);
    // 36 combinations: all together from coarse to fine, then each alone from the finest.
    let expected = [
        "1100", "2200", "3399", "1399", "2399", "3199", "3299", "3309", "3390",
    ];
    let mut found = short(expand(&[three, three, two, two]));
    // The knobs of two values turn with the last step.
    found[0..3].sort();
    assert_eq!(found, expected);
}

#[test]
fn a_journal_goes_on_after_a_torn_line() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("study.jsonl");
    let mut journal = Journal::open(path.clone(), false).unwrap();
    assert!(journal.is_empty());
    let first = rendered("k1", "ray_march", "1", 0.5, 0.25);
    journal.push(first.clone()).unwrap();
    journal
        .push(record(
            "k2",
            "ray_march",
            "2",
            Outcome::Failed("no".to_owned()),
        ))
        .unwrap();
    let whole = fs::read(&path).unwrap();
    fs::write(&path, &whole[..whole.len() - 7]).unwrap();
    let mut journal = Journal::open(path.clone(), false).unwrap();
    assert_eq!(journal.len(), 1);
    assert_eq!(journal.get("k1"), Some(&first));
    journal
        .push(rendered("k3", "ray_march", "3", 1.0, 0.5))
        .unwrap();
    let journal = Journal::open(path.clone(), false).unwrap();
    assert_eq!(journal.len(), 2);
    assert!(journal.get("k2").is_none() && journal.get("k3").is_some());
    assert!(Journal::open(path.clone(), true).unwrap().is_empty());
    assert!(!path.exists());
    assert!(
        Journal::open(path, true).unwrap().is_empty(),
        "nothing to forget"
    );
}

/// Fields of a line, quotes undone.
fn fields(line: &str) -> Vec<String> {
    let (mut list, mut field, mut quoted) = (Vec::new(), String::new(), false);
    let mut characters = line.chars().peekable();
    while let Some(c) = characters.next() {
        match c {
            '"' if quoted && characters.peek() == Some(&'"') => {
                field.push('"');
                characters.next();
            }
            '"' => quoted = !quoted,
            ',' if !quoted => list.push(std::mem::take(&mut field)),
            other => field.push(other),
        }
    }
    list.push(field);
    list
}

#[test]
fn json_and_csv_come_back_as_they_were() {
    let report = report();
    let json = serde_json::to_string(&report).unwrap();
    assert_eq!(serde_json::from_str::<Report>(&json).unwrap(), report);
    let csv = to_csv(&report);
    let rows: Vec<_> = csv.split_terminator("\r\n").map(fields).collect();
    assert_eq!(rows.len(), 5);
    assert!(rows.iter().all(|r| r.len() == rows[0].len()));
    let cell = |row: usize, name: &str| {
        let column = rows[0].iter().position(|n| n == name).unwrap();
        rows[row][column].clone()
    };
    assert_eq!(cell(1, "device"), "device, \"quoted\"");
    assert_eq!(cell(1, "settings"), "technique.ray_march.step=1");
    assert_eq!(cell(1, "stage_seconds"), "t.cache=0.125 t.image=0.25");
    assert_eq!(cell(1, "ssim"), "");
    assert_eq!(cell(3, "failure"), "too <small>, \"far\" & wide");
    assert_eq!(cell(3, "seconds"), "");
    assert_eq!(cell(4, "flip").parse::<f64>().unwrap(), 0.125);
    assert_eq!([1, 2, 3, 4].map(|i| cell(i, "front")), ["1", "", "", "2"]);
}

/// Fails unless every tag is closed in order and no `<` or `&` stands alone.
fn assert_well_formed(text: &str) {
    let mut open: Vec<&str> = Vec::new();
    let text = text.strip_prefix("<!DOCTYPE html>").unwrap_or(text);
    for part in text.split('<').skip(1) {
        let (tag, rest) = part.split_once('>').unwrap();
        assert_eq!(tag.matches('"').count() % 2, 0, "<{tag}>");
        let name = tag.split([' ', '/']).next().unwrap();
        if let Some(closed) = tag.strip_prefix('/') {
            assert_eq!(open.pop(), Some(closed.trim()), "</{closed}>");
        } else if !tag.ends_with('/') {
            assert!(
                name.chars().all(|c| c.is_ascii_alphanumeric()) && !name.is_empty(),
                "<{tag}>"
            );
            open.push(name);
        }
        for reference in rest.split('&').skip(1) {
            let end = reference.find(';').unwrap_or(usize::MAX);
            assert!(end <= 5, "&{reference}");
        }
    }
    assert!(open.is_empty(), "{open:?} left open");
}

#[test]
fn the_page_is_whole_and_nothing_leaves_its_place() {
    let folder = TempDir::new().unwrap();
    let pictures = Pictures::new(folder.path().join("images")).unwrap();
    fs::write(pictures.image("a1"), b"picture").unwrap();
    let report = report();
    let page = to_html(&report, &pictures);
    assert_well_formed(&page);
    assert!(!page.contains("<script>") && !page.contains("<b>device</b>"));
    assert!(page.contains("&lt;script&gt;alert(1)&lt;/script&gt; &amp; &quot;x&quot;"));
    assert!(page.contains("too &lt;small&gt;, &quot;far&quot; &amp; wide"));
    assert!(page.contains("do not &lt; trust"));
    assert!(page.contains("data:image/png;base64,cGljdHVyZQ=="));
    for i in 0..4 {
        assert!(page.contains(&format!("id=\"s0-{i}\"")), "row {i}");
    }
    assert!(page.contains("computes another model than the reference"));
    let svg = plot(&report.scenes[0], "s0");
    assert_well_formed(&svg);
    assert_eq!(
        svg.matches("class=\"point\"").count(),
        3,
        "all that was measured"
    );
    let line = svg.split("class=\"front\" points=\"").nth(1).unwrap();
    assert_eq!(line.split('"').next().unwrap().split(' ').count(), 2);
    assert!(!svg.contains("NaN") && !svg.contains("inf"));
}

#[test]
fn a_plot_of_one_point_or_none_has_finite_places() {
    let mut scene = report().scenes.remove(0);
    scene.records.truncate(1);
    scene.front = vec![0];
    for records in [1, 0] {
        scene.records.truncate(records);
        scene.front.truncate(records);
        let svg = plot(&scene, "s");
        assert_well_formed(&svg);
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
    }
}

#[test]
fn only_what_depends_on_the_image_grows_with_it() {
    // A quarter of the time stays.
    assert_eq!(extrapolate(&measured(1.0, 0.0), 16.0), 0.25 + 0.75 * 16.0);
    assert_eq!(extrapolate(&measured(1.0, 0.0), 1.0), 1.0);
}

fn settings() -> Vec<Record> {
    vec![
        rendered("1", "ray_march", "1", 1.0, 0.5),
        rendered("2", "ray_march", "2", 2.0, 0.25),
        rendered("3", "path_trace", "1", 3.0, 0.375),
        rendered("4", "path_trace", "2", 4.0, 0.125),
        record("5", "path_trace", "3", Outcome::Failed("no".to_owned())),
    ]
}

#[test]
fn the_search_keeps_its_limit_and_learns_from_a_miss() {
    let value = |s: &Search| s.best().map(|c| c.configuration.clone());
    let fast = Search::new(Goal::MaxFlip(0.4), &settings(), 1.0);
    assert_eq!(fast.promising(), 3);
    assert_eq!(value(&fast), Some(configuration("ray_march", "2")));
    let mut within = Search::new(Goal::BudgetSeconds(3.5), &settings(), 1.0);
    let best = configuration("ray_march", "2");
    assert_eq!(value(&within), Some(best.clone()));
    // It took four times as long, so the technique's other setting takes 4 seconds too.
    within.miss(&best, 8.0, 0.25);
    assert_eq!(value(&within), Some(configuration("path_trace", "1")));
    within.miss(&configuration("path_trace", "1"), 6.0, 0.375);
    assert_eq!(value(&within), None);
    assert_eq!(
        within.nearest(),
        Some((&configuration("ray_march", "1"), 4.0))
    );
    assert_eq!(within.missed.len(), 2);
}

#[test]
fn what_is_out_of_reach_has_a_nearest_value() {
    let exact = Search::new(Goal::MaxFlip(0.01), &settings(), 1.0);
    assert!(exact.best().is_none());
    assert_eq!(
        exact.nearest(),
        Some((&configuration("path_trace", "2"), 0.125))
    );
    let none = Search::new(Goal::MaxFlip(0.01), &[], 1.0);
    assert!(none.best().is_none() && none.nearest().is_none());
}

#[test]
fn options_are_what_render_takes() {
    let options = configuration("ray_march", "0.5").options();
    assert_eq!(
        options,
        "--technique ray_march --set technique.ray_march.step=0.5"
    );
    assert_eq!(front(&[(2.0, 0.1), (1.0, 0.2), (3.0, 0.3)]), [1, 0]);
    let folder = Pictures::new(PathBuf::from("/dev/null/images"));
    assert!(
        folder
            .unwrap_err()
            .to_string()
            .contains("create the folder")
    );
}
