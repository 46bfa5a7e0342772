//! All settings of a scene.

use std::path::{Path, PathBuf};

use super::measure::{Rendered, measure};
use super::{Journal, Record, Reference, StudyError, Subject, fitting, key, shrink};
use crate::gpu::Device;
use crate::output::metrics::flip;
use crate::output::png::{self, BitDepth};
use crate::output::tone_map::{Alpha, ToneMapping, expose, to_display};
use crate::output::{Display, Image, Metadata};
use crate::scene::Scene;

/// Pixels along the longest side of a thumbnail.
const THUMBNAIL: u32 = 192;

/// Characters of a key that name a picture.
const SHORT_KEY: usize = 16;

/// How a study measures.
#[derive(Clone, Copy, Debug)]
pub struct Settings<'a> {
    /// Frames that times are the medians of, at least 1.
    pub frames: u32,
    /// Where thumbnails go, if they are wanted.
    pub pictures: Option<&'a Pictures>,
}

/// A folder of thumbnails.
#[derive(Clone, Debug)]
pub struct Pictures {
    folder: PathBuf,
}

/// Measures every setting that `journal` does not hold yet; `progress(done)` counts settings.
///
/// # Errors
/// Vulkan failed, or a file cannot be written. What was measured until then is in the journal.
pub fn run_scene(
    device: &Device,
    subject: &Subject,
    reference: &Reference,
    journal: &mut Journal,
    settings: &Settings,
    progress: &mut dyn FnMut(f64),
) -> Result<Vec<Record>, StudyError> {
    let mut records = Vec::new();
    for (i, variant) in subject.variants.iter().enumerate() {
        let scene = variant.apply(&subject.scene);
        let frames = settings.frames.max(1);
        let key = key::of_measurement(&scene, &reference.about.key, frames, device.info());
        let known = journal.get(&key).filter(|record| {
            let missing = |p: &Pictures| record.outcome.measured().is_some() && !p.has(&key);
            !settings.pictures.is_some_and(missing)
        });
        let record = if let Some(known) = known {
            // The same scene may go by another name now.
            Record {
                scene: subject.name.clone(),
                ..known.clone()
            }
        } else {
            let mut share = |share: f64| progress(i as f64 + share);
            let (outcome, rendered) = measure(device, &scene, reference, frames, &mut share)?;
            if let (Some(pictures), Some(rendered)) = (settings.pictures, rendered) {
                pictures.write(&key, &rendered)?;
            }
            let record = Record {
                key,
                scene: subject.name.clone(),
                device: device.info().name.clone(),
                image: [scene.image.width, scene.image.height],
                frames,
                configuration: variant.configuration.clone(),
                outcome,
            };
            journal.push(record.clone())?;
            record
        };
        records.push(record);
        progress((i + 1) as f64);
    }
    Ok(records)
}

impl Pictures {
    /// Puts thumbnails into `folder`, which is made if need be.
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

    /// Thumbnail of what is filed under `key`.
    #[must_use]
    pub fn image(&self, key: &str) -> PathBuf {
        self.path(key, "png")
    }

    /// Thumbnail of its FLIP map.
    #[must_use]
    pub fn error(&self, key: &str) -> PathBuf {
        self.path(key, "flip.png")
    }

    /// Writes the thumbnail of a reference, shown as the scene asks.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write_reference(&self, reference: &Reference, scene: &Scene) -> Result<(), StudyError> {
        let mapping = ToneMapping {
            stops: expose(&reference.image, scene.image.exposure),
            operator: scene.image.tone_map,
        };
        let path = self.image(&reference.about.key);
        write(&path, &thumbnail(&reference.image, &mapping))
    }

    fn has(&self, key: &str) -> bool {
        self.image(key).is_file() && self.error(key).is_file()
    }

    fn path(&self, key: &str, ending: &str) -> PathBuf {
        let short = key.get(..SHORT_KEY).unwrap_or(key);
        self.folder.join(format!("{short}.{ending}"))
    }

    fn write(&self, key: &str, rendered: &Rendered) -> Result<(), StudyError> {
        let shown = &rendered.comparison.shown;
        let mapping = ToneMapping {
            stops: shown.stops.unwrap_or(0.0),
            operator: shown.tone_map.unwrap_or_default(),
        };
        let image = thumbnail(&rendered.image, &mapping);
        write(&self.image(key), &image)?;
        let map = flip::picture(&small_map(&rendered.comparison.flip_map));
        write(&self.error(key), &map)
    }
}

fn thumbnail(image: &Image, mapping: &ToneMapping) -> Display {
    let size = fitting([image.width, image.height], THUMBNAIL);
    to_display(&shrink(image, size), mapping, Alpha::Opaque)
}

/// The map at a thumbnail's size; its mean stays.
fn small_map(map: &flip::ErrorMap) -> flip::ErrorMap {
    let image = Image {
        width: map.width,
        height: map.height,
        pixels: map.values.iter().map(|v| [*v; 4]).collect(),
    };
    let small = shrink(&image, fitting([map.width, map.height], THUMBNAIL));
    flip::ErrorMap {
        width: small.width,
        height: small.height,
        values: small.pixels.iter().map(|p| p[0]).collect(),
    }
}

fn write(path: &Path, display: &Display) -> Result<(), StudyError> {
    png::write_display(path, display, BitDepth::Eight, false, &Metadata::new())?;
    Ok(())
}
