//! Times the models of a row in turns, so that all meet the same moods of the machine.

use glam::{DQuat, DVec3};

use super::paper::{Column, Model, Row, Table};
use crate::cli::CliError;
use crate::gpu::{Device, StageTime};
use crate::scene::{Light, Scene};
use crate::technique::{Input, Inputs, Plan, Renderer, ResourceKind, Spread};

/// How often.
#[derive(Clone, Copy, Debug)]
pub(super) struct Counts {
    /// Frames of an orbit.
    pub(super) frames: u32,
    /// Rounds, each with every change and an orbit.
    pub(super) rounds: u32,
}

/// What one model cost.
#[derive(Debug)]
pub(super) struct Measured {
    pub(super) model: Model,
    pub(super) technique: &'static str,
    /// Device seconds in the order of [`Column::ALL`]; none where nothing ran.
    pub(super) seconds: [Option<Spread>; 4],
    /// Bytes that the technique keeps on the device beside volume and image, by resource.
    pub(super) memory: Vec<(&'static str, u64)>,
}

/// A model on the device.
struct Turn {
    model: Model,
    renderer: Renderer,
    start: Scene,
    /// Stages of the image; all others are of caches.
    // Those that another camera runs again.
    image_stages: Vec<&'static str>,
    seconds: [Vec<f64>; 4],
}

/// Measures every model on a row's scene; `progress` is told the rounds done.
///
/// # Errors
/// The scene does not fit the device, or Vulkan failed.
pub(super) fn measure(
    device: &Device,
    (table, row, scene): (&Table, &Row, &Scene),
    counts: Counts,
    progress: &mut dyn FnMut(u64, u64),
) -> Result<Vec<Measured>, CliError> {
    let mut turns = Vec::new();
    for (model, setup) in table.models {
        let mut scene = scene.clone();
        setup(row, &mut scene);
        turns.push(Turn::new(device, *model, scene)?);
    }
    let total = u64::from(counts.rounds) * (table.changes.len() as u64 + u64::from(counts.frames));
    let mut done = 0;
    let mut step = || {
        done += 1;
        progress(done, total);
    };
    for round in 0..counts.rounds {
        for &column in table.changes {
            for turn in &mut turns {
                turn.change(column, round)?;
            }
            step();
        }
        // Nothing to go back from where nothing was changed.
        if !table.changes.is_empty() {
            for turn in &mut turns {
                turn.reset()?;
            }
        }
        for frame in 0..counts.frames {
            let degrees = 360.0 * f64::from(frame) / f64::from(counts.frames);
            for turn in &mut turns {
                turn.frame(degrees)?;
            }
            step();
        }
    }
    Ok(turns.into_iter().map(Turn::finish).collect())
}

impl Turn {
    /// Renders once, uncounted: drivers compile at the first frame.
    fn new(device: &Device, model: Model, scene: Scene) -> Result<Self, CliError> {
        let renderer = Renderer::new(device, scene.clone())?;
        let stages = renderer.plan().stages.iter();
        let of_image = stages.filter(|s| s.depends_on.contains(Input::Camera));
        let mut turn = Self {
            model,
            image_stages: of_image.map(|s| s.name).collect(),
            renderer,
            start: scene,
            seconds: Default::default(),
        };
        turn.render()?;
        Ok(turn)
    }

    /// Changes the scene of the last frame and notes what the caches cost.
    fn change(&mut self, column: Column, round: u32) -> Result<(), CliError> {
        let mut scene = self.renderer.scene().clone();
        edit(&mut scene, column, f64::from(round + 1));
        self.renderer.set_scene(scene)?;
        let (caches, _) = self.render()?;
        self.seconds[column as usize].extend(caches);
        Ok(())
    }

    /// Back to the scene of the first frame, uncounted.
    fn reset(&mut self) -> Result<(), CliError> {
        self.renderer.set_scene(self.start.clone())?;
        self.render()?;
        Ok(())
    }

    /// Looks from another side and notes what the image cost.
    fn frame(&mut self, degrees: f64) -> Result<(), CliError> {
        let mut scene = self.start.clone();
        scene.camera = self.start.camera.orbit(degrees);
        self.renderer.set_scene(scene)?;
        // The first frame of an orbit has the camera of the frame before it.
        self.renderer.invalidate(Inputs::of(&[Input::Camera]));
        let (_, image) = self.render()?;
        self.seconds[Column::Rendering as usize].extend(image);
        Ok(())
    }

    /// Device seconds of the caches' stages and of the image's.
    fn render(&mut self) -> Result<(Option<f64>, Option<f64>), CliError> {
        let (_, report) = self.renderer.render(&mut |_, _, _| {})?;
        Ok(split(&report.stages, &self.image_stages))
    }

    fn finish(self) -> Measured {
        let spread = |times: Vec<f64>| (!times.is_empty()).then(|| Spread::of(times));
        Measured {
            model: self.model,
            technique: self.start.technique.name(),
            seconds: self.seconds.map(spread),
            memory: auxiliary(self.renderer.plan()),
        }
    }
}

/// Seconds of all other stages, and of those named; none where no stage ran.
fn split(stages: &[StageTime], image: &[&str]) -> (Option<f64>, Option<f64>) {
    let sum = |of_image: bool| {
        let of = |s: &&StageTime| image.contains(&s.name.as_str()) == of_image;
        let times = stages.iter().filter(of).map(|s| s.seconds);
        times.reduce(|a, b| a + b)
    };
    (sum(false), sum(true))
}

/// What lives beside volume and image, largest first.
fn auxiliary(plan: &Plan) -> Vec<(&'static str, u64)> {
    let kept = plan.resources.iter();
    let kept = kept.filter(|r| r.kind == ResourceKind::Auxiliary);
    let mut list: Vec<_> = kept.map(|r| (r.name, r.bytes)).collect();
    list.sort_by_key(|(_, bytes)| std::cmp::Reverse(*bytes));
    list
}

/// A small change that no other round makes.
fn edit(scene: &mut Scene, column: Column, amount: f64) {
    match column {
        Column::TransferFunction => {
            scene.medium.density_scale *= 1.0 + 1e-3 * amount;
            // Colours decide the mean albedo, and with it tables.
            let function = &mut scene.medium.transfer_function;
            let points = function.points.iter_mut().map(|p| &mut p.color);
            for color in points.chain(function.primitives.iter_mut().map(|p| &mut p.color)) {
                *color /= 1.0 + 1e-3 * amount as f32;
            }
        }
        Column::Phase => scene.medium.phase_g += 1e-4 * amount,
        Column::Light => {
            let step = 0.002 * amount * scene.volume.grid.diagonal();
            for light in &mut scene.lights {
                match light {
                    Light::Point { position, .. } => *position += step * DVec3::X,
                    Light::Directional { direction, .. } => {
                        *direction = DQuat::from_rotation_z(0.01 * amount) * *direction;
                    }
                    Light::Environment { .. } | Light::EnvironmentMap { .. } => {}
                }
            }
        }
        Column::Rendering => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn caches_and_image_are_told_apart() {
        let stage = |name: &str, seconds| StageTime {
            name: name.to_owned(),
            seconds,
        };
        let image = ["t.march", "t.read_back"];
        let all = [
            stage("t.cache", 1.0),
            stage("t.march", 2.0),
            stage("medium.upload_table", 4.0),
            stage("t.read_back", 8.0),
        ];
        assert_eq!(split(&all, &image), (Some(5.0), Some(10.0)));
        assert_eq!(split(&all[1..2], &image), (None, Some(2.0)));
        assert_eq!(split(&[], &image), (None, None));
    }
}
