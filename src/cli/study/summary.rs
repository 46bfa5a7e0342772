//! The study for people: each scene's front, and where the rest is.

use std::path::PathBuf;

use crate::study::{Record, Report, SceneReport};
use crate::technique::size;

pub(super) fn summary(report: &Report, files: &[PathBuf]) -> String {
    let mut lines = vec![format!("{} ({})", report.device, report.driver)];
    for scene in &report.scenes {
        lines.push(String::new());
        lines.extend(front(scene));
    }
    let names: Vec<_> = files.iter().map(|f| f.display().to_string()).collect();
    lines.push(String::new());
    lines.push(names.join(", "));
    lines.join("\n")
}

fn front(scene: &SceneReport) -> Vec<String> {
    let r = &scene.reference;
    let [width, height] = scene.image;
    let mut lines = vec![format!(
        "{}: {width} x {height}; reference of {} samples, relative standard error {:.2} %",
        scene.name,
        r.samples,
        100.0 * r.relative_error
    )];
    lines.extend(scene.warnings.iter().map(|w| format!("warning: {w}")));
    let failed = |r: &&Record| r.outcome.measured().is_none();
    let failed = scene.records.iter().filter(failed).count();
    lines.push(format!(
        "{:>10} {:>10} {:>9} {:>9} {:>9} {:>10}   the {} of {} settings that no other beats{}",
        "ms",
        "first",
        "FLIP",
        "SSIM",
        "bias",
        "memory",
        scene.front.len(),
        scene.records.len(),
        if failed > 0 {
            format!(", {failed} could not be measured")
        } else {
            String::new()
        }
    ));
    lines.extend(scene.front.iter().filter_map(|i| row(&scene.records[*i])));
    lines
}

fn row(record: &Record) -> Option<String> {
    let m = record.outcome.measured()?;
    let dash = || "-".to_owned();
    let bias = m.errors.relative_bias;
    Some(format!(
        "{:>10.2} {:>10.2} {:>9.4} {:>9} {:>9} {:>10}   {} {}",
        1e3 * m.seconds,
        1e3 * m.first_seconds,
        m.errors.flip,
        m.errors.ssim.map_or_else(dash, |s| format!("{s:.4}")),
        bias.map_or_else(dash, |b| format!("{:+.2} %", 100.0 * b)),
        size(m.bytes),
        record.configuration.technique,
        record.configuration.label()
    ))
}
