//! The converged image that everything is measured against, kept on disk under the hash of all that
//! decides it.

use std::path::{Path, PathBuf};
use std::time::Instant;

use serde::{Deserialize, Serialize};

use super::{StudyError, Subject, key};
use crate::gpu::Device;
use crate::output::{Image, Metadata, Variance, exr};
use crate::scene::{PathTraceParams, Scene, TechniqueParams};
use crate::technique::{RenderError, Renderer};

/// Samples that tell how many the reference needs.
const PILOT_SAMPLES: u32 = 32;

/// Random numbers of the pilot and of the reference: neither each other's nor those of a scene, so that no
/// image is measured against its own noise.
const SEEDS: [u32; 2] = [0x9e37_79b9, 0x85eb_ca6b];

/// When a reference is good enough.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReferenceGoal {
    /// Root mean square of the pixels' standard errors as a share of the mean radiance, as estimated from
    /// a first, separate image: a number of samples chosen by the reference's own would bias it.
    pub error: f64,
    /// Seconds after which it ends whatever its error.
    pub seconds: f64,
    /// Samples a pixel, at most.
    pub samples: u32,
}

/// What is known of a reference.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct About {
    /// What it is filed under.
    pub key: String,
    /// Samples a pixel.
    pub samples: u32,
    /// Root mean square of the pixels' standard errors as a share of the mean radiance.
    pub relative_error: f64,
    /// What that was to be.
    pub goal_error: f64,
    /// Seconds it took.
    pub seconds: f64,
}

/// A reference image.
#[derive(Clone, Debug)]
pub struct Reference {
    /// Linear radiance.
    pub image: Image,
    /// Variances of its pixels' means.
    pub variance: Variance,
    /// What is known of it.
    pub about: About,
    /// Whether it came from the disk.
    pub from_cache: bool,
}

/// A folder of references.
#[derive(Clone, Debug)]
pub struct Cache {
    folder: PathBuf,
}

/// Shares of the work done: `progress(done, total)`.
type Progress<'a> = &'a mut dyn FnMut(u64, u64);

impl Cache {
    /// Keeps files in `folder`, which is made if need be.
    ///
    /// # Errors
    /// It cannot be made.
    pub fn new(folder: PathBuf) -> Result<Self, StudyError> {
        std::fs::create_dir_all(&folder).map_err(|source| StudyError::Io {
            path: folder.clone(),
            action: "create the folder",
            source,
        })?;
        Ok(Self { folder })
    }

    /// The user's cache folder, where the system has one.
    #[must_use]
    pub fn user_folder() -> Option<PathBuf> {
        directories::ProjectDirs::from("", "", "tyndall").map(|d| d.cache_dir().join("study"))
    }

    /// Where the cache lies.
    #[must_use]
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// The reference of a scene: from the disk, or rendered and kept.
    ///
    /// # Errors
    /// The scene does not fit the device, Vulkan failed, or the file cannot be written.
    pub fn reference(
        &self,
        device: &Device,
        subject: &Subject,
        goal: &ReferenceGoal,
        progress: Progress<'_>,
    ) -> Result<Reference, StudyError> {
        let scene = &subject.scene;
        let key = key::of_reference(&subject.scene_hash(), goal, SEEDS[1]);
        let path = self.folder.join(format!("reference-{key}.exr"));
        if let Some(reference) = read(&path, &key, scene) {
            return Ok(reference);
        }
        let reference = render(device, scene, key, goal, progress)?;
        let about = &reference.about;
        let entries = [
            ("about", serde_json::to_string(about).unwrap_or_default()),
            ("technique", "path_trace".to_owned()),
        ];
        let metadata: Metadata = entries.map(|(k, v)| (k.to_owned(), v)).into();
        exr::write_with_variance(&path, &reference.image, &reference.variance, &metadata)?;
        Ok(reference)
    }
}

/// A kept reference; `None` if there is none, or it is not whole.
fn read(path: &Path, key: &str, scene: &Scene) -> Option<Reference> {
    if !path.is_file() {
        return None;
    }
    let metadata = exr::read_metadata(path).ok()?;
    let about: About = serde_json::from_str(metadata.get("about")?).ok()?;
    let image = exr::read(path).ok()?;
    let variance = exr::read_variance(path).ok()??;
    let fits = (image.width, image.height) == (scene.image.width, scene.image.height)
        && about.key == key
        && variance.pixels.len() == image.pixels.len();
    fits.then_some(Reference {
        image,
        variance,
        about,
        from_cache: true,
    })
}

fn render(
    device: &Device,
    scene: &Scene,
    key: String,
    goal: &ReferenceGoal,
    progress: Progress<'_>,
) -> Result<Reference, StudyError> {
    let start = Instant::now();
    let pilot = PILOT_SAMPLES.min(goal.samples);
    let mut renderer = Renderer::new(device, path_traced(scene, pilot, goal.seconds, SEEDS[0]))?;
    let (image, _) = renderer.render(&mut |_, _, _| {})?;
    let variance = variance(&renderer)?;
    let error = relative_error(&image, &variance);
    let samples = needed(pilot, error, goal);
    let left = (goal.seconds - start.elapsed().as_secs_f64()).max(1e-3);
    renderer.set_scene(path_traced(scene, samples, left, SEEDS[1]))?;
    let (image, frame) = renderer.render(&mut |phase, done, total| {
        if phase == "rendering" {
            progress(done, total);
        }
    })?;
    let variance = self::variance(&renderer)?;
    let about = About {
        key,
        samples: frame.samples.unwrap_or(samples),
        relative_error: relative_error(&image, &variance),
        goal_error: goal.error,
        seconds: start.elapsed().as_secs_f64(),
    };
    Ok(Reference {
        image,
        variance,
        about,
        from_cache: false,
    })
}

/// Samples that bring `error` after `done` samples down to the goal, with a little room.
fn needed(done: u32, error: f64, goal: &ReferenceGoal) -> u32 {
    let needed = 1.02 * f64::from(done) * (error / goal.error).powi(2);
    // `as` saturates.
    (needed.ceil() as u32).clamp(done, goal.samples.max(done))
}

fn path_traced(scene: &Scene, samples: u32, seconds: f64, seed: u32) -> Scene {
    let mut scene = scene.clone();
    // It averages over the pixel's area already.
    scene.image.samples_per_axis = 1;
    scene.technique = TechniqueParams::PathTrace(PathTraceParams {
        samples,
        seconds: Some(seconds),
        target_error: None,
        max_scatter: None,
        seed,
    });
    scene
}

fn variance(renderer: &Renderer) -> Result<Variance, RenderError> {
    let pixels = renderer.variance()?.unwrap_or_default();
    Ok(Variance { pixels })
}

/// Root mean square of the pixels' standard errors as a share of the mean radiance; 0 without noise.
fn relative_error(image: &Image, variance: &Variance) -> f64 {
    let sum = |rgb: &[f32]| rgb.iter().map(|v| f64::from(*v)).sum::<f64>();
    let n = 3.0 * image.pixels.len().max(1) as f64;
    let squares = variance.pixels.iter().map(|v| sum(v)).sum::<f64>() / n;
    let mean = image.pixels.iter().map(|p| sum(&p[..3])).sum::<f64>() / n;
    if squares > 0.0 {
        squares.sqrt() / mean
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_grow_with_the_square_of_the_error() {
        let goal = ReferenceGoal {
            error: 0.01,
            seconds: 1.0,
            samples: 10_000,
        };
        assert_eq!(needed(32, 0.1, &goal), 3264);
        assert_eq!(needed(32, 0.001, &goal), 32);
        assert_eq!(needed(32, 10.0, &goal), 10_000);
        assert_eq!(needed(32, f64::INFINITY, &goal), 10_000);
    }
}
