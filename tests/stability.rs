//! Extreme scenes through every technique: finite, not negative, no brighter than light and albedo allow,
//! and at the limit where theory gives one.
#![allow(clippy::unwrap_used, clippy::expect_used)]

mod common;

use tyndall::stability::{Extreme, examine, extremes, subjects};
use tyndall::technique::NAMES;

#[test]
fn every_technique_is_put_to_the_extremes() {
    let subjects = subjects();
    for name in NAMES {
        let is_there = subjects.iter().any(|s| s.params.name() == *name);
        assert!(is_there, "{name} is missing in stability::subjects");
    }
}

#[test]
fn extremes_have_names_of_their_own() {
    let mut names: Vec<_> = extremes().into_iter().map(|e| e.name).collect();
    let all = names.len();
    names.sort();
    names.dedup();
    assert_eq!(names.len(), all);
}

fn assert_stable(extremes: &[Extreme]) {
    let device = common::device();
    let mut complaints = Vec::new();
    for extreme in extremes {
        for subject in subjects() {
            let what = format!("{}; {}", extreme.name, subject.name);
            match examine(&device, extreme, &subject) {
                Ok(finding) => {
                    let list = finding.complaints();
                    complaints.extend(list.iter().map(|c| format!("{what}: {c}")));
                }
                Err(error) => complaints.push(format!("{what}: {error}")),
            }
        }
    }
    assert_eq!(device.live_allocations(), vec![], "memory left behind");
    assert!(complaints.is_empty(), "\n{}", complaints.join("\n"));
}

#[test]
fn extremes_are_rendered_stably() {
    assert_stable(&extremes());
}

#[test]
fn a_wrong_image_is_complained_about() {
    // The same scene under a claim that is not true of it.
    let mut extreme = extremes()
        .into_iter()
        .find(|e| e.name == "albedo 1")
        .unwrap();
    extreme.tau = extreme.tau.map(|tau| 1.001 * tau);
    extreme.irradiance *= 0.5;
    let device = common::device();
    let once = subjects()
        .into_iter()
        .find(|s| s.name == "path_trace, once")
        .unwrap();
    let complaints = examine(&device, &extreme, &once).unwrap().complaints();
    assert!(
        complaints.iter().any(|c| c.contains("scattered once")),
        "{complaints:?}"
    );
    let unlit = subjects()
        .into_iter()
        .find(|s| s.name == "ray_march, unlit")
        .unwrap();
    extreme.tau = Some(3.0);
    let complaints = examine(&device, &extreme, &unlit).unwrap().complaints();
    assert!(
        complaints.iter().any(|c| c.contains("alpha")),
        "{complaints:?}"
    );
}
