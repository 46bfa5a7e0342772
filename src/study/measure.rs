//! One setting of one technique: timed, and compared with the reference.

use serde::{Deserialize, Serialize};

use super::{Configuration, Reference, StudyError};
use crate::gpu::Device;
use crate::output::Image;
use crate::output::metrics::{CompareError, CompareOptions, Comparison, Estimate, compare_images};
use crate::scene::Scene;
use crate::technique::{
    FrameReport, Input, RenderError, Renderer, Spread, StageSpread, stage_spreads,
};

/// What a study knows of one setting in one scene on one device.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// Hash of scene, setting, reference, frames, device and shaders.
    pub key: String,
    /// The scene's name.
    pub scene: String,
    /// The device's name.
    pub device: String,
    /// Pixels across and down.
    pub image: [u32; 2],
    /// Frames that times are the medians of.
    pub frames: u32,
    /// Technique and settings.
    #[serde(flatten)]
    pub configuration: Configuration,
    /// What came of it.
    pub outcome: Outcome,
}

/// What came of a setting.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// It was rendered.
    Measured(Box<Measured>),
    /// The device refused it, or its image has no measure: why.
    Failed(String),
}

/// Times, memory and errors of a setting.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Measured {
    /// Host seconds of a frame after a change of the camera, median.
    pub seconds: f64,
    /// Host seconds of the first frame: uploads, pipelines and all.
    pub first_seconds: f64,
    /// Every stage of the first frame.
    pub stages: Vec<Stage>,
    /// Device memory while rendering, as planned.
    pub bytes: u64,
    /// Samples a pixel, where there is chance in the image.
    pub samples: Option<u32>,
    /// Distance from the reference.
    pub errors: Errors,
}

/// A stage's share of the time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Stage {
    /// `technique.stage`.
    pub name: String,
    /// Device seconds in a frame after a change of the camera, median; 0 if it did not run.
    pub seconds: f64,
    /// Device seconds in the first frame.
    pub first_seconds: f64,
    /// Whether a change of the image runs it again: then its time is taken to grow with the pixels.
    pub grows_with_image: bool,
}

/// Distance from the reference.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Errors {
    /// Of radiance.
    pub rmse: f64,
    /// Of radiance, relative to the reference's.
    pub relative_mse: Option<f64>,
    /// Mean difference of radiance.
    pub bias: f64,
    /// The same as a share of the reference's mean.
    pub relative_bias: Option<f64>,
    /// Mean LDR-FLIP, both as shown with the reference's exposure.
    pub flip: f64,
    /// Largest LDR-FLIP.
    pub flip_largest: f64,
    /// Mean HDR-FLIP.
    pub hdr_flip: Option<f64>,
    /// Structural similarity as shown; `None` of images under 11 pixels.
    pub ssim: Option<f64>,
}

/// What a rendering leaves behind besides numbers.
pub(super) struct Rendered {
    pub(super) image: Image,
    pub(super) comparison: Comparison,
}

impl Outcome {
    /// The numbers, if it was rendered.
    #[must_use]
    pub fn measured(&self) -> Option<&Measured> {
        match self {
            Self::Measured(measured) => Some(measured),
            Self::Failed(_) => None,
        }
    }
}

/// Compares an image with the reference, both shown with the scene's exposure (of the reference, where it
/// is automatic) and tone map.
///
/// # Errors
/// The image is of another size or not finite.
pub fn compare(
    image: &Image,
    reference: &Reference,
    scene: &Scene,
) -> Result<Comparison, CompareError> {
    let options = CompareOptions {
        exposure: scene.image.exposure,
        tone_map: scene.image.tone_map,
        ..CompareOptions::default()
    };
    let reference = Estimate {
        image: &reference.image,
        variance: Some(&reference.variance),
    };
    compare_images(image, reference, &options)
}

/// Renders the scene once from where it is seen, and `frames` times from beside it.
///
/// What the device cannot do is an outcome; what Vulkan reports is an error.
pub(super) fn measure(
    device: &Device,
    scene: &Scene,
    reference: &Reference,
    frames: u32,
    progress: &mut dyn FnMut(f64),
) -> Result<(Outcome, Option<Rendered>), StudyError> {
    let mut renderer = match Renderer::new(device, scene.clone()) {
        Ok(renderer) => renderer,
        Err(RenderError::Plan(refusal)) => return Ok((Outcome::Failed(refusal.to_string()), None)),
        Err(error) => return Err(error.into()),
    };
    let mut image = None;
    let mut reports = Vec::new();
    for frame in 0..=frames {
        if frame > 0 {
            let mut turned = scene.clone();
            turned.camera = scene.camera.orbit(0.5 * f64::from(frame));
            renderer.set_scene(turned)?;
        }
        let in_all = f64::from(frames + 1);
        let (rendered, report) = renderer.render(&mut |phase, done, total| {
            if phase == "rendering" {
                let share = done as f64 / total.max(1) as f64;
                progress((f64::from(frame) + share.min(1.0)) / in_all);
            }
        })?;
        image.get_or_insert(rendered);
        reports.push(report);
    }
    let Some(image) = image else {
        return Ok((Outcome::Failed("nothing was rendered".to_owned()), None));
    };
    let comparison = match compare(&image, reference, scene) {
        Ok(comparison) => comparison,
        Err(error) => return Ok((Outcome::Failed(error.to_string()), None)),
    };
    let measured = summary(&renderer, &reports, &comparison);
    let rendered = Rendered { image, comparison };
    Ok((Outcome::Measured(Box::new(measured)), Some(rendered)))
}

fn summary(renderer: &Renderer, reports: &[FrameReport], comparison: &Comparison) -> Measured {
    let (first, warm) = reports.split_at(1.min(reports.len()));
    let walls = |reports: &[FrameReport]| {
        let seconds = reports.iter().map(|r| r.wall_seconds).collect();
        Spread::of(seconds).median
    };
    Measured {
        seconds: walls(warm),
        first_seconds: walls(first),
        stages: stages(renderer, first, warm),
        bytes: renderer.plan().bytes(),
        samples: first.first().and_then(|r| r.samples),
        errors: Errors::of(comparison),
    }
}

fn stages(renderer: &Renderer, first: &[FrameReport], warm: &[FrameReport]) -> Vec<Stage> {
    let warm = stage_spreads(warm);
    let grows = |name: &str| {
        let plan = renderer.plan().stages.iter().find(|s| s.name == name);
        plan.is_some_and(|s| s.depends_on.contains(Input::Image))
    };
    let stage = |s: StageSpread| Stage {
        seconds: warm
            .iter()
            .find(|w| w.name == s.name)
            .map_or(0.0, |w| w.seconds.median),
        first_seconds: s.seconds.median,
        grows_with_image: grows(&s.name),
        name: s.name,
    };
    stage_spreads(first).into_iter().map(stage).collect()
}

impl Errors {
    fn of(comparison: &Comparison) -> Self {
        let (e, s) = (&comparison.errors, &comparison.shown);
        Self {
            rmse: e.rmse,
            relative_mse: e.relative_mse,
            bias: e.bias,
            relative_bias: e.relative_bias,
            flip: s.flip.mean,
            flip_largest: s.flip.largest,
            hdr_flip: comparison.hdr_flip.map(|h| h.error.mean),
            ssim: s.ssim,
        }
    }
}
