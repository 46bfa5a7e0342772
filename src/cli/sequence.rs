//! `tyndall render --time FIRST..LAST`: steps of a time-dependent volume through one renderer.
//!
//! Range, transfer function, camera and exposure are those of the whole sequence, so that from step
//! to step only the stages run that depend on the voxels. No more than two steps are in memory.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use serde_json::{Value, json};

use super::progress::Progress;
use super::render::{self, RenderArgs, Shot};
use super::time::Steps;
use super::{CliError, Global, print, print_json};
use crate::gpu::Device;
use crate::output::json as json_file;
use crate::output::tone_map::expose;
use crate::scene::Scene;
use crate::scene::file::SceneFile;
use crate::technique::{FrameReport, Renderer};
use crate::volume::{PLACE, Statistics};

/// One rendered step.
struct Step {
    number: u32,
    files: Vec<PathBuf>,
    read_seconds: f64,
    frame: FrameReport,
    report: Value,
}

/// What stays while the steps go by.
struct Run<'a> {
    global: &'a Global,
    args: &'a RenderArgs,
    file: SceneFile,
    outputs: Vec<PathBuf>,
    device: Device,
    // How many steps the volume has, and the last one rendered.
    count: u32,
    last: u32,
}

/// Renders the steps one after the other.
pub(super) fn run(global: &Global, args: &RenderArgs, steps: Steps) -> Result<(), CliError> {
    let start = Instant::now();
    let outputs = places(render::outputs(args, true)?)?;
    let file = args.scene.open(&render::overrides(args)?)?;
    let count = file.time_steps()?;
    let steps = steps.of(count);
    let mut progress = Progress::new(global.quiet);
    let scene = file.resolve_steps(steps.clone(), &mut |phase, done, total| {
        progress.update(phase, done, total);
    });
    progress.finish();
    let scene = scene?;
    args.scene.check(global, &scene)?;
    let run = Run {
        global,
        args,
        file,
        outputs,
        device: global.open_device()?,
        // Names have room for the last step, where steps are endless.
        count: count.max(steps.end().saturating_add(1)),
        last: *steps.end(),
    };
    let mut renderer = Renderer::new(&run.device, scene)?;
    let mut done = Vec::new();
    let mut stops = None;
    for number in steps {
        let step = run.render(&mut renderer, number, &mut stops)?;
        run.tell(&step)?;
        done.push(step);
    }
    run.finish(&done, start)
}

impl Run<'_> {
    /// Reads a step, except the first, which the renderer has; renders and writes it. `stops` is the
    /// exposure, which the first step decides.
    fn render(
        &self,
        renderer: &mut Renderer,
        number: u32,
        stops: &mut Option<f32>,
    ) -> Result<Step, CliError> {
        let mut progress = Progress::new(self.global.quiet);
        let mut show = |phase: &str, done, total| {
            let phase = format!("step {number} of {}, {phase}", self.last);
            progress.update(&phase, done, total);
        };
        let read = Instant::now();
        if stops.is_some() {
            let next = self.file.at_step(renderer.scene(), number, &mut show)?;
            renderer.set_scene(next)?;
        }
        let read_seconds = read.elapsed().as_secs_f64();
        let (image, frame) = renderer.render(&mut show)?;
        progress.finish();
        let exposure = renderer.scene().image.exposure;
        let stops = *stops.get_or_insert_with(|| expose(&image, exposure));
        let mut report = render::report(renderer, &self.device, &image, &frame, stops);
        report["time_step"] = json!(number);
        let pictures = self.outputs.iter().filter(|p| has_place(p));
        let files: Vec<_> = pictures.map(|p| filled(p, number, self.count)).collect();
        let shot = Shot {
            renderer,
            image: &image,
            stops,
            report: &report,
        };
        render::write(self.args, &files, &shot, &self.device, Some(number))?;
        Ok(Step {
            number,
            files,
            read_seconds,
            frame,
            report,
        })
    }

    /// A line for every step.
    fn tell(&self, step: &Step) -> Result<(), CliError> {
        if self.global.quiet || self.args.json {
            return Ok(());
        }
        let names: Vec<_> = step.files.iter().map(|p| p.display().to_string()).collect();
        let device: f64 = step.frame.stages.iter().map(|s| s.seconds).sum();
        print(&format!(
            "step {}: {} in {:.3} s (device {device:.3} s), read in {:.3} s",
            step.number,
            names.join(", "),
            step.frame.wall_seconds,
            step.read_seconds
        ))
    }

    /// Reports of all steps, and a last line.
    fn finish(&self, steps: &[Step], start: Instant) -> Result<(), CliError> {
        let Some(first) = steps.first() else {
            return Ok(());
        };
        let report = of_all(first, steps);
        for path in self.outputs.iter().filter(|p| !has_place(p)) {
            json_file::write(path, &report)?;
        }
        if self.args.json {
            return print_json(&report);
        }
        if self.global.quiet {
            return Ok(());
        }
        print(&format!(
            "{} steps in {:.2} s, exposed by {:.2} stops as step {}, on {}",
            steps.len(),
            start.elapsed().as_secs_f64(),
            report["exposure_stops"].as_f64().unwrap_or(0.0),
            first.number,
            self.device.info().name
        ))
    }
}

/// What all steps have in common, and of each which stages ran and for how long.
fn of_all(first: &Step, steps: &[Step]) -> Value {
    let mut report = first.report.clone();
    if let Some(fields) = report.as_object_mut() {
        for of_one_step in ["frame", "time_step", "non_finite_pixels"] {
            fields.remove(of_one_step);
        }
    }
    let step = |s: &Step| {
        json!({
            "time_step": s.number,
            "volume": s.report["scene"]["volume"]["name"],
            "files": s.files,
            "read_seconds": s.read_seconds,
            "frame": s.frame,
            "non_finite_pixels": s.report["non_finite_pixels"],
        })
    };
    report["steps"] = steps.iter().map(step).collect();
    report
}

/// Every picture needs a place for the number of its step; a report without one is of all steps.
fn places(outputs: Vec<PathBuf>) -> Result<Vec<PathBuf>, CliError> {
    for path in outputs.iter().filter(|p| !has_place(p)) {
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        let ending = render::ending(path);
        if ending != "json" {
            return Err(CliError::Usage(format!(
                "--output {}: found no place for the number of the step, expected {PLACE} in the name, as in \
                 {stem}_{PLACE}.{ending}",
                path.display()
            )));
        }
    }
    Ok(outputs)
}

/// Whether a file's name has a place for a number.
pub(super) fn has_place(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default();
    name.to_string_lossy().contains(PLACE)
}

/// The file of one step of `count`: the number takes as many digits as the last step's.
pub(super) fn filled(path: &Path, step: u32, count: u32) -> PathBuf {
    let width = count.saturating_sub(1).to_string().len();
    let number = format!("{step:0width$}");
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    path.with_file_name(name.replace(PLACE, &number))
}

/// The time step that a scene shows and one beside it, alike but for the voxels; nothing where there is
/// but one.
pub(super) fn neighbours(
    file: &SceneFile,
    scene: &Scene,
    progress: &mut Progress,
) -> Result<Option<[Scene; 2]>, CliError> {
    let (here, count) = (file.time(), file.time_steps()?);
    if count < 2 {
        return Ok(None);
    }
    let beside = if here + 1 < count { here + 1 } else { here - 1 };
    let next = file.at_step(scene, beside, &mut |phase, done, total| {
        progress.update(phase, done, total);
    })?;
    let statistics = Arc::new(scene.statistics.union(&Statistics::of(&next.volume)));
    let alike = |s| Scene {
        statistics: statistics.clone(),
        ..s
    };
    Ok(Some([alike(scene.clone()), alike(next)]))
}
