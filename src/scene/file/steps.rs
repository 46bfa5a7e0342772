//! Time steps: one chosen, or several that look alike.

use std::ops::RangeInclusive;
use std::sync::Arc;

use glam::Vec3;

use super::resolve::{Progress, raw_layout};
use super::{SceneError, SceneFile};
use crate::scene::transfer_function::Quantity;
use crate::scene::{ControlPoint, Scene, TransferFunction};
use crate::volume::{self, ReadOptions, Statistics};

impl SceneFile {
    /// The time step that the scene shows, from 0.
    #[must_use]
    pub fn time(&self) -> u32 {
        self.spec.volume.time.unwrap_or(0)
    }

    /// Shows another time step.
    ///
    /// # Errors
    /// The volume comes from a formula, which knows no time, and no noise moves.
    pub fn set_time(&mut self, step: u32) -> Result<(), SceneError> {
        if self.spec.volume.file.is_none() && !self.moves() {
            return Err(SceneError::plain(
                "volume: found a formula or a map of heights, expected a file or a series of files, which have time steps, or noise \
                 that moves (medium.perturbation.octaves.velocity)",
            ));
        }
        self.spec.volume.time = Some(step);
        Ok(())
    }

    /// Whether noise changes what there is from step to step, without end.
    fn moves(&self) -> bool {
        self.perturbation(0).is_some_and(|p| p.moves())
    }

    /// How many time steps the volume has; noise that moves has as many as are asked for.
    ///
    /// # Errors
    /// Its header cannot be read.
    pub fn time_steps(&self) -> Result<u32, SceneError> {
        let v = &self.spec.volume;
        let Some(file) = &v.file else { return Ok(1) };
        let options = ReadOptions {
            raw: v.raw.as_ref().map(raw_layout),
            time: 0,
        };
        Ok(volume::read_header(&self.folder.join(file), &options)?.time_steps)
    }

    /// As [`SceneFile::resolve`] for the first of some time steps, to suit all: with the statistics of
    /// all, of which range and transfer function are chosen, and a camera, where that is chosen, that
    /// shows the whole box, since what is visible moves.
    ///
    /// Reads every step once and keeps the first.
    ///
    /// # Errors
    /// A step cannot be read, or there is none.
    pub fn resolve_steps(
        &self,
        steps: RangeInclusive<u32>,
        progress: Progress<'_>,
    ) -> Result<Scene, SceneError> {
        let (first, last) = (*steps.start(), *steps.end());
        let count = self.time_steps()?;
        let endless = self.spec.volume.file.is_none() && self.moves();
        if first > last || (last >= count && !endless) {
            let file = self.spec.volume.file.as_deref().unwrap_or("volume");
            return Err(SceneError::plain(format!(
                "{file}: found {count} time step(s), counted from 0, expected steps {first} to {last}"
            )));
        }
        let mut shown = |step: u32, phase: &str, done, total| {
            progress(&format!("step {step} of {last}, {phase}"), done, total);
        };
        let volume = self.volume(first, &mut |phase, done, total| {
            shown(first, phase, done, total);
        })?;
        let mut statistics = Statistics::of(&volume);
        for step in steps.skip(1).filter(|_| !endless) {
            let next = self.volume(step, &mut |phase, done, total| {
                shown(step, phase, done, total);
            })?;
            statistics = statistics.union(&Statistics::of(&next));
        }
        let statistics = Arc::new(statistics);
        let mut scene = self.resolve_framed(Arc::new(volume), statistics, Some(&opaque()))?;
        scene.medium.perturbation = self.perturbation(first);
        Ok(scene)
    }

    /// `scene` at another time step: only the voxels change, and where noise lies that moves.
    ///
    /// # Errors
    /// The step cannot be read.
    pub fn at_step(
        &self,
        scene: &Scene,
        step: u32,
        progress: Progress<'_>,
    ) -> Result<Scene, SceneError> {
        let mut scene = scene.clone();
        if self.spec.volume.file.is_some() {
            scene.volume = Arc::new(self.volume(step, progress)?);
        }
        // Noise at rest is the same at all times, and nothing is made anew for it.
        if self.moves() {
            scene.medium.perturbation = self.perturbation(step);
        }
        Ok(scene)
    }
}

/// Makes every voxel visible.
fn opaque() -> TransferFunction {
    TransferFunction {
        name: "opaque".to_owned(),
        points: vec![ControlPoint {
            value: 0.0,
            color: Vec3::ONE,
            opacity: 1.0,
        }],
        quantity: Quantity::Opacity,
        primitives: Vec::new(),
        opacity_unit_distance: 1.0,
    }
}
