//! One row a setting.

use super::{Record, Report, SceneReport};
use crate::study::{Measured, Outcome, Stage};

const COLUMNS: [&str; 26] = [
    "scene",
    "technique",
    "settings",
    "width",
    "height",
    "device",
    "frames",
    "seconds",
    "first_seconds",
    "stage_seconds",
    "first_stage_seconds",
    "bytes",
    "samples",
    "rmse",
    "relative_mse",
    "bias",
    "relative_bias",
    "flip",
    "flip_largest",
    "hdr_flip",
    "ssim",
    "front",
    "reference_samples",
    "reference_relative_error",
    "failure",
    "key",
];

/// A table with a heading; times in seconds, errors of radiance, lines end as RFC 4180 has it.
#[must_use]
pub fn to_csv(report: &Report) -> String {
    let mut text = COLUMNS.join(",") + "\r\n";
    for scene in &report.scenes {
        for (i, record) in scene.records.iter().enumerate() {
            let fields = row(scene, i, record);
            let fields: Vec<String> = fields.iter().map(|f| quoted(f)).collect();
            text += &fields.join(",");
            text += "\r\n";
        }
    }
    text
}

fn row(scene: &SceneReport, i: usize, record: &Record) -> [String; 26] {
    let measured = record.outcome.measured();
    let value = |of: fn(&Measured) -> Option<f64>| {
        let value = measured.and_then(of);
        value.map_or_else(String::new, |v| v.to_string())
    };
    let stages = |of: fn(&Stage) -> f64| {
        let stages = measured.map_or(&[][..], |m| &m.stages);
        let list: Vec<_> = stages
            .iter()
            .map(|s| format!("{}={}", s.name, of(s)))
            .collect();
        list.join(" ")
    };
    let settings = record.configuration.settings.iter();
    let settings: Vec<_> = settings.map(|s| format!("{}={}", s.key, s.value)).collect();
    let failure = match &record.outcome {
        Outcome::Failed(why) => why.clone(),
        Outcome::Measured(_) => String::new(),
    };
    [
        record.scene.clone(),
        record.configuration.technique.clone(),
        settings.join(" "),
        record.image[0].to_string(),
        record.image[1].to_string(),
        record.device.clone(),
        record.frames.to_string(),
        value(|m| Some(m.seconds)),
        value(|m| Some(m.first_seconds)),
        stages(|s| s.seconds),
        stages(|s| s.first_seconds),
        measured.map_or_else(String::new, |m| m.bytes.to_string()),
        measured
            .and_then(|m| m.samples)
            .map_or_else(String::new, |n| n.to_string()),
        value(|m| Some(m.errors.rmse)),
        value(|m| m.errors.relative_mse),
        value(|m| Some(m.errors.bias)),
        value(|m| m.errors.relative_bias),
        value(|m| Some(m.errors.flip)),
        value(|m| Some(m.errors.flip_largest)),
        value(|m| m.errors.hdr_flip),
        value(|m| m.errors.ssim),
        scene.place(i).map_or_else(String::new, |n| n.to_string()),
        scene.reference.samples.to_string(),
        scene.reference.relative_error.to_string(),
        failure,
        record.key.clone(),
    ]
}

fn quoted(field: &str) -> String {
    if field.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", field.replace('"', "\"\""))
    } else {
        field.to_owned()
    }
}
