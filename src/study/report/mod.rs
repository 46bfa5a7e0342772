//! What a study found, as files: CSV for tables, JSON for programs, a page for people.

mod csv;
mod html;
mod plot;
mod text;

use std::io::Write;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::{About, Pictures, Record, Reference, StudyError, Subject, front};
use crate::gpu::DeviceInfo;
use crate::output::atomic;
use crate::scene::{Medium, Scene};

pub use csv::to_csv;
pub use html::to_html;
pub use plot::plot;
pub use text::escape;

/// How far beyond its goal a reference's error is worth a warning: the samples it takes are estimated.
const UNCONVERGED: f64 = 1.2;

/// A study of some scenes on a device.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// The program's version.
    pub tyndall: String,
    /// The device's name.
    pub device: String,
    /// Driver name and version.
    pub driver: String,
    /// Vulkan version.
    pub vulkan: String,
    /// Frames that times are the medians of.
    pub frames: u32,
    /// One entry a scene.
    pub scenes: Vec<SceneReport>,
}

/// A study of a scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SceneReport {
    /// The scene's name.
    pub name: String,
    /// Hash of the scene without its technique.
    pub scene_hash: String,
    /// Hash of the voxels.
    pub voxels_hash: String,
    /// Pixels across and down.
    pub image: [u32; 2],
    /// What everything was compared with.
    pub reference: About,
    /// Why the errors may not mean what they seem to.
    pub warnings: Vec<String>,
    /// One entry a setting.
    pub records: Vec<Record>,
    /// Positions in `records` of those that no other beats in time and FLIP, the fastest first.
    pub front: Vec<usize>,
}

impl Report {
    /// A report without scenes yet.
    #[must_use]
    pub fn new(device: &DeviceInfo, frames: u32) -> Self {
        Self {
            tyndall: env!("CARGO_PKG_VERSION").to_owned(),
            device: device.name.clone(),
            driver: device.driver.clone(),
            vulkan: device.api.clone(),
            frames,
            scenes: Vec::new(),
        }
    }
}

impl SceneReport {
    /// What was found of a scene.
    #[must_use]
    pub fn new(subject: &Subject, reference: &Reference, records: Vec<Record>) -> Self {
        let point = |r: &Record| {
            let nowhere = (f64::NAN, f64::NAN);
            let measured = r.outcome.measured();
            measured.map_or(nowhere, |m| (m.seconds, m.errors.flip))
        };
        let points: Vec<_> = records.iter().map(point).collect();
        Self {
            name: subject.name.clone(),
            scene_hash: subject.scene_hash(),
            voxels_hash: subject.voxels_hash.clone(),
            image: [subject.scene.image.width, subject.scene.image.height],
            reference: reference.about.clone(),
            warnings: warnings(&subject.scene, &reference.about),
            front: front(&points),
            records,
        }
    }

    /// The place of a record on the front, from 1.
    #[must_use]
    pub fn place(&self, record: usize) -> Option<usize> {
        self.front.iter().position(|i| *i == record).map(|i| i + 1)
    }
}

/// What is doubtful about a reference.
fn warnings(scene: &Scene, reference: &About) -> Vec<String> {
    let mut warnings = Vec::new();
    let Medium {
        transfer_function,
        albedo,
        ..
    } = &scene.medium;
    let points = transfer_function.points.iter().map(|p| p.color);
    let shapes = transfer_function.primitives.iter().map(|p| p.color);
    let colors = points.chain(shapes);
    let brightest = colors.map(|c| c.max_element()).fold(0.0, f32::max);
    let albedo = f64::from(brightest) * albedo;
    if albedo > 1.0 {
        warnings.push(format!(
            "colours times medium.albedo reach {albedo:.2}: above 1 light grows at every scattering, and a \
             path-traced reference need not converge; lower medium.albedo or the colours"
        ));
    }
    if reference.relative_error > UNCONVERGED * reference.goal_error {
        warnings.push(format!(
            "the reference's relative standard error is {:.2} %, not the {:.2} % asked for: give it more time",
            100.0 * reference.relative_error,
            100.0 * reference.goal_error
        ));
    }
    warnings
}

/// Writes `study.csv`, `study.json` and `study.html` into `folder`; returns their paths.
///
/// # Errors
/// A file cannot be written.
pub fn write(
    folder: &Path,
    report: &Report,
    pictures: &Pictures,
) -> Result<[PathBuf; 3], StudyError> {
    let json = serde_json::to_string_pretty(report).unwrap_or_default() + "\n";
    let files = [
        ("study.csv", to_csv(report)),
        ("study.json", json),
        ("study.html", to_html(report, pictures)),
    ];
    for (name, text) in &files {
        atomic::write(&folder.join(name), |file| file.write_all(text.as_bytes()))?;
    }
    Ok(files.map(|(name, _)| folder.join(name)))
}
