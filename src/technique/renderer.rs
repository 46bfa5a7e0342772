//! Keeps a scene on the device and re-runs only the stages that a change reaches.

use std::time::Instant;

use serde::Serialize;

use super::medium::{self, Medium};
use super::target::Target;
use super::{Input, Inputs, Plan, PlanError, Technique, TechniquePlan};
use crate::gpu::{Device, GpuError, Recorder, StageTime};
use crate::output::Image;
use crate::scene::Scene;

/// A scene that cannot be rendered here.
#[derive(Debug, thiserror::Error)]
pub enum RenderError {
    /// It does not fit the device.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// Vulkan failed.
    #[error(transparent)]
    Gpu(#[from] GpuError),
}

/// What one frame cost.
#[derive(Clone, Debug, Serialize)]
pub struct FrameReport {
    /// Stages that ran, in order, with their device times.
    pub stages: Vec<StageTime>,
    /// Host seconds from the call to the finished image.
    pub wall_seconds: f64,
    /// Samples a pixel, where the technique draws any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub samples: Option<u32>,
}

/// A scene on a device.
pub struct Renderer {
    device: Device,
    scene: Scene,
    technique_plan: TechniquePlan,
    plan: Plan,
    // Stages to run at the next frame because one of these changed.
    dirty: Inputs,
    state: Option<State>,
}

/// What lives on the device between frames.
struct State {
    medium: Medium,
    target: Target,
    technique: Technique,
}

/// Counts work done, of how much: bytes while loading, bands while rendering.
pub type Progress<'a> = &'a mut dyn FnMut(&str, u64, u64);

impl Renderer {
    /// Plans the scene and checks that it fits; allocates nothing yet.
    ///
    /// # Errors
    /// The scene exceeds a limit or the device's memory.
    pub fn new(device: &Device, scene: Scene) -> Result<Self, RenderError> {
        let (technique_plan, plan) = checked(device, &scene)?;
        Ok(Self {
            device: device.clone(),
            scene,
            technique_plan,
            plan,
            dirty: Inputs::ALL,
            state: None,
        })
    }

    /// The plan of the current scene.
    #[must_use]
    pub const fn plan(&self) -> &Plan {
        &self.plan
    }

    /// The current scene.
    #[must_use]
    pub const fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Replaces the scene. The next frame runs the stages that depend on what changed, no others.
    ///
    /// # Errors
    /// As [`Renderer::new`]; the old scene stays then.
    pub fn set_scene(&mut self, scene: Scene) -> Result<(), RenderError> {
        let (technique_plan, plan) = checked(&self.device, &scene)?;
        self.dirty = self.dirty.union(Inputs::changed(&self.scene, &scene));
        self.scene = scene;
        (self.technique_plan, self.plan) = (technique_plan, plan);
        Ok(())
    }

    /// Makes the next frame run every stage that depends on `inputs`, as if they had changed.
    pub const fn invalidate(&mut self, inputs: Inputs) {
        self.dirty = self.dirty.union(inputs);
    }

    /// Renders the scene and reads the image back.
    ///
    /// # Errors
    /// The driver's refusal, no memory, or a validation message.
    pub fn render(&mut self, progress: Progress<'_>) -> Result<(Image, FrameReport), RenderError> {
        let start = Instant::now();
        let (mut stages, mut state) = self.prepare(progress)?;
        let image_stage = self.technique_plan.image_stage();
        if self.dirty.intersects(self.depends_on(image_stage)) {
            let mut progress = |done, total| progress("rendering", done, total);
            stages.extend(state.technique.record(&self.device, &mut progress)?);
            let read_back = self.technique_plan.read_back_stage();
            stages.extend(state.target.download(&self.device, read_back)?);
        }
        self.device.check_validation()?;
        self.dirty = Inputs::NONE;
        let image = state.target.image();
        let samples = state.technique.samples();
        self.state = Some(state);
        let wall_seconds = start.elapsed().as_secs_f64();
        let report = FrameReport {
            stages,
            wall_seconds,
            samples,
        };
        Ok((image, report))
    }

    /// Squared standard error of every pixel of the last image, RGB, if the technique estimates it
    /// and took more than one sample.
    ///
    /// # Errors
    /// The driver's refusal or no memory.
    pub fn variance(&self) -> Result<Option<Vec<[f32; 3]>>, RenderError> {
        let Some(state) = &self.state else {
            return Ok(None);
        };
        Ok(state.technique.variance(&self.device)?)
    }

    /// Brings resources, voxels, table and cells up to date.
    fn prepare(&mut self, progress: Progress<'_>) -> Result<(Vec<StageTime>, State), RenderError> {
        let plan = &self.technique_plan;
        let (mut medium, mut target, mut technique) = (None, None, None);
        if let Some(old) = self.state.take() {
            medium = (old.medium.plan == *plan.medium()).then_some(old.medium);
            target = Some(old.target);
            // The bindings of a technique would keep a medium alive that the new one replaces.
            technique = medium.is_some().then_some(old.technique);
        }
        if medium.is_none() {
            // A new medium (other formats or sizes) holds nothing yet, whatever changed.
            let all = Inputs::of(&[Input::Volume, Input::TransferFunction]);
            self.dirty = self.dirty.union(all);
        }
        let medium = medium.map_or_else(|| Medium::new(&self.device, plan.medium()), Ok)?;
        let size = [self.scene.image.width, self.scene.image.height];
        let target = Target::new(&self.device, size, target)?;
        let mut technique = plan.create(&self.device, &medium, &target, technique)?;
        target.write_view(&self.scene);
        medium.write_uniforms(&self.scene);
        technique.write_uniforms(&self.scene, &medium);
        let mut stages = Vec::new();
        if self.dirty.contains(Input::Volume) {
            stages.extend(
                medium.upload_volume(&self.scene.volume, &mut |done, total| {
                    progress("uploading", done, total);
                })?,
            );
            let mut recorder = Recorder::new(&self.device)?;
            medium::record_ranges(&mut recorder, &medium, &self.scene.volume);
            stages.extend(recorder.submit()?);
        }
        if self.dirty.contains(Input::TransferFunction) {
            stages.extend(medium.upload_table(&self.scene)?);
        }
        if self.dirty.contains(Input::Volume) || self.dirty.contains(Input::TransferFunction) {
            let mut recorder = Recorder::new(&self.device)?;
            medium::record_occupancy(&mut recorder, &medium);
            stages.extend(recorder.submit()?);
        }
        stages.extend(technique.upload(
            &self.device,
            (&self.scene, &medium, &target),
            self.dirty,
            &mut |done, total| progress("lighting", done, total),
        )?);
        let state = State {
            medium,
            target,
            technique,
        };
        Ok((stages, state))
    }

    fn depends_on(&self, name: &str) -> Inputs {
        self.plan
            .stages
            .iter()
            .find(|s| s.name == name)
            .map_or(Inputs::ALL, |s| s.depends_on)
    }
}

/// The scene's plan, found to fit the device.
fn checked(device: &Device, scene: &Scene) -> Result<(TechniquePlan, Plan), PlanError> {
    let limits = &device.info().limits;
    let technique_plan = TechniquePlan::new(scene, limits)?;
    let plan = technique_plan.summary(scene);
    plan.check(limits)?;
    Ok((technique_plan, plan))
}
