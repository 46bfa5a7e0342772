//! Keeps a scene on the device and re-runs only the stages that a change reaches.

use std::time::Instant;

use serde::Serialize;

use super::medium::{self, MediumPlan};
use super::ray_march::{self, RayMarch, RayMarchPlan};
use super::{Input, Inputs, Plan, PlanError};
use crate::gpu::{Device, GpuError, Recorder, StageTime, download_image};
use crate::output::Image;
use crate::scene::{RayMarchParams, Scene, TechniqueParams};

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
}

/// A scene on a device.
pub struct Renderer {
    device: Device,
    scene: Scene,
    plan: Plan,
    // Stages to run at the next frame because one of these changed.
    dirty: Inputs,
    technique: Option<RayMarch>,
}

/// Counts work done, of how much: bytes while loading, bands while rendering.
pub type Progress<'a> = &'a mut dyn FnMut(&str, u64, u64);

impl Renderer {
    /// Plans the scene and checks that it fits; allocates nothing yet.
    ///
    /// # Errors
    /// The scene exceeds a limit or the device's memory.
    pub fn new(device: &Device, scene: Scene) -> Result<Self, RenderError> {
        let plan = super::plan(&scene, &device.info().limits)?;
        plan.check(&device.info().limits)?;
        Ok(Self {
            device: device.clone(),
            scene,
            plan,
            dirty: Inputs::ALL,
            technique: None,
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
        let plan = super::plan(&scene, &self.device.info().limits)?;
        plan.check(&self.device.info().limits)?;
        self.dirty = self.dirty.union(Inputs::changed(&self.scene, &scene));
        self.scene = scene;
        self.plan = plan;
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
        let TechniqueParams::RayMarch(params) = self.scene.technique;
        let plan = ray_march::plan(&self.scene, &params, &self.device.info().limits)?;
        let mut stages = self.prepare(&plan, &params, progress)?;
        if let Some(technique) = &self.technique {
            if self
                .dirty
                .intersects(self.depends_on(plan.march().shader.name))
            {
                stages.extend(ray_march::record_march(
                    &self.device,
                    technique,
                    &mut |done, total| {
                        progress("rendering", done, total);
                    },
                )?);
                let (image, to) = (technique.radiance(), technique.read_back());
                let stage = ray_march::stage::READ_BACK;
                stages.extend(download_image(&self.device, image, to, stage)?);
            }
            self.device.check_validation()?;
        }
        self.dirty = Inputs::NONE;
        let image = self.image();
        Ok((
            image,
            FrameReport {
                stages,
                wall_seconds: start.elapsed().as_secs_f64(),
            },
        ))
    }

    /// Brings resources, voxels, table and cells up to date.
    fn prepare(
        &mut self,
        plan: &RayMarchPlan,
        params: &RayMarchParams,
        progress: Progress<'_>,
    ) -> Result<Vec<StageTime>, RenderError> {
        // A new medium (other formats or sizes) holds nothing yet, whatever changed.
        let fits = |m: &MediumPlan| *m == plan.medium;
        if !self
            .technique
            .as_ref()
            .is_some_and(|t| fits(&t.medium.plan))
        {
            self.dirty = self.dirty.union(Inputs::of(&[Input::Volume]));
        }
        let old = self.technique.take();
        let technique = RayMarch::new(&self.device, plan, old)?;
        let technique = &*self.technique.insert(technique);
        technique.write_uniforms(&self.scene, params);
        let medium = &technique.medium;
        let mut stages = Vec::new();
        if self.dirty.contains(Input::Volume) {
            stages.extend(
                medium.upload_volume(&self.scene.volume, &mut |done, total| {
                    progress("uploading", done, total);
                })?,
            );
            let mut recorder = Recorder::new(&self.device)?;
            medium::record_ranges(&mut recorder, medium);
            stages.extend(recorder.submit()?);
        }
        if self.dirty.contains(Input::Volume) || self.dirty.contains(Input::TransferFunction) {
            stages.extend(medium.upload_table(&self.scene)?);
            let mut recorder = Recorder::new(&self.device)?;
            medium::record_occupancy(&mut recorder, medium);
            stages.extend(recorder.submit()?);
        }
        Ok(stages)
    }

    fn depends_on(&self, name: &str) -> Inputs {
        self.plan
            .stages
            .iter()
            .find(|s| s.name == name)
            .map_or(Inputs::ALL, |s| s.depends_on)
    }

    /// The last frame, from the read-back buffer.
    fn image(&self) -> Image {
        let (width, height) = (self.scene.image.width, self.scene.image.height);
        let count = width as usize * height as usize;
        let pixels = self.technique.as_ref().map_or_else(Vec::new, |t| {
            t.read_back().with_bytes(|bytes| {
                let texels = bytes.chunks_exact(16).take(count);
                texels
                    .map(bytemuck::pod_read_unaligned::<[f32; 4]>)
                    .collect()
            })
        });
        Image {
            width,
            height,
            pixels,
        }
    }
}
