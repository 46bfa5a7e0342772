//! Runs jobs of a stage, so many a submission, and hands back what they found.

use std::sync::Arc;

use bytemuck::bytes_of;
use glam::UVec3;

use super::layout::{ANGLES, Job, LANE_BYTES, LANES, LAYOUTS, PreintegratePush, constants};
use crate::gpu::{
    Access, Binding, Buffer, BufferUse, ComputePipeline, Device, GpuError, Recorder, Resource,
};

/// Jobs a submission, at most: tenths of a second to some seconds on two cores.
pub const JOBS: usize = 256;
/// lavapipe ends a shader after 65,535 loop rounds, of which each of ours has 88.
const ROUNDS: u32 = 640;
/// Dispatches of the same jobs, at most: thousands of scatterings more than a path has that leads anywhere.
const DISPATCHES: u32 = 100;

/// Which estimator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Estimator {
    /// One path for all angles, scored at every vertex.
    Shared,
    /// One path an angle, scored where it leaves; absorbed by chance.
    Plain,
}

/// A pipeline with the buffers of one submission.
pub struct Preintegrator {
    device: Device,
    pipeline: ComputePipeline,
    binding: Binding,
    jobs: Arc<Buffer>,
    means: Arc<Buffer>,
    unfinished: Arc<Buffer>,
    // Only of the shared estimator.
    lanes: Option<Arc<Buffer>>,
    albedos: Vec<f64>,
    seed: u32,
    rounds: u32,
}

impl Preintegrator {
    /// Compiles the stage for these albedos, the largest first, at most
    /// [`MAX_ALBEDOS`](super::layout::MAX_ALBEDOS); the plain estimator takes the first of them.
    ///
    /// # Errors
    /// The driver's refusal or no memory.
    pub fn new(
        device: &Device,
        estimator: Estimator,
        albedos: &[f64],
        seed: u32,
    ) -> Result<Self, GpuError> {
        let constants = constants(albedos.len() as u32);
        let (layout, constants) = match estimator {
            Estimator::Shared => (LAYOUTS[0], constants.as_slice()),
            Estimator::Plain => (LAYOUTS[1], [].as_slice()),
        };
        let pipeline = ComputePipeline::new(device, layout, constants)?;
        let buffer = |name, bytes, usage| {
            Buffer::new(device, name, (JOBS * bytes) as u64, usage).map(Arc::new)
        };
        let jobs = buffer("jobs", size_of::<Job>(), BufferUse::StorageUpload)?;
        let bytes = albedos.len() * ANGLES * size_of::<f32>();
        let means = buffer("means", bytes, BufferUse::StorageReadback)?;
        let unfinished = buffer("unfinished", size_of::<u32>(), BufferUse::StorageReadback)?;
        let bytes = LANES as usize * LANE_BYTES;
        let lanes = match estimator {
            Estimator::Shared => Some(buffer("lanes", bytes, BufferUse::StorageReadback)?),
            Estimator::Plain => None,
        };
        let list = [&jobs, &means, &unfinished].into_iter().chain(&lanes);
        let list = list.map(|b| Resource::StorageBuffer(b.clone())).collect();
        Ok(Self {
            device: device.clone(),
            binding: pipeline.bind(list)?,
            pipeline,
            jobs,
            means,
            unfinished,
            lanes,
            albedos: albedos.to_vec(),
            seed,
            rounds: ROUNDS,
        })
    }

    /// With shorter dispatches, so with more of them. What jobs find does not depend on it.
    #[must_use]
    pub const fn with_rounds(mut self, rounds: u32) -> Self {
        self.rounds = rounds;
        self
    }

    /// Runs at most [`JOBS`] jobs; `found(job, means)` gets each one's means, angles fastest, then
    /// albedos. Returns the device's seconds.
    ///
    /// # Errors
    /// The driver's refusal, a lost device, a validation message, or paths that did not end.
    pub fn run(&self, jobs: &[Job], mut found: impl FnMut(usize, &[f32])) -> Result<f64, GpuError> {
        let list: &[u8] = bytemuck::cast_slice(jobs);
        self.jobs
            .with_bytes(|bytes| bytes[..list.len()].copy_from_slice(list));
        // Plain jobs do not say that they have ended.
        self.unfinished.with_bytes(|bytes| bytes.fill(0));
        let mut push =
            PreintegratePush::new(self.seed, jobs.len() as u32, self.rounds, &self.albedos);
        let mut seconds = self.dispatch(&push)?;
        push.resumed = 1;
        for _ in 1..DISPATCHES {
            if self.lanes.is_none() || self.first_unfinished(jobs).is_none() {
                break;
            }
            seconds += self.dispatch(&push)?;
        }
        if let Some(job) = self.first_unfinished(jobs) {
            return Err(self.refusal(job));
        }
        let values = self.albedos.len() * ANGLES;
        self.means.with_bytes(|bytes| {
            let all: &[f32] = bytemuck::cast_slice(bytes);
            for (i, means) in all.chunks_exact(values).take(jobs.len()).enumerate() {
                found(i, means);
            }
        });
        Ok(seconds)
    }

    /// One submission; returns the device's seconds.
    fn dispatch(&self, push: &PreintegratePush) -> Result<f64, GpuError> {
        let mut recorder = Recorder::new(&self.device)?;
        let kept = [
            Some(&self.means),
            self.lanes.as_ref(),
            Some(&self.unfinished),
        ];
        for buffer in kept.into_iter().flatten() {
            // RAW, WAW: jobs go on with what they kept in the submission before.
            recorder.buffer_barrier(buffer, Access::ComputeWrite, Access::ComputeReadWrite);
        }
        recorder.compute_stage(self.pipeline.name(), |r| {
            let domain = UVec3::new(push.job_count * LANES, 1, 1);
            r.dispatch(&self.pipeline, &self.binding, bytes_of(push), domain);
        });
        // RAW: the host reads what the jobs wrote.
        recorder.buffer_barrier(&self.means, Access::ComputeWrite, Access::HostRead);
        recorder.buffer_barrier(&self.unfinished, Access::ComputeWrite, Access::HostRead);
        Ok(recorder.submit()?.iter().map(|t| t.seconds).sum())
    }

    fn first_unfinished<'a>(&self, jobs: &'a [Job]) -> Option<&'a Job> {
        self.unfinished.with_bytes(|bytes| {
            let flags: &[u32] = bytemuck::cast_slice(bytes);
            let mut pairs = jobs.iter().zip(flags);
            pairs.find(|(_, flag)| **flag != 0).map(|(job, _)| job)
        })
    }

    /// An error, since leaving paths out would be a bias.
    fn refusal(&self, job: &Job) -> GpuError {
        let dispatches = if self.lanes.is_some() { DISPATCHES } else { 1 };
        GpuError::Shader {
            name: self.pipeline.name().to_owned(),
            message: format!(
                "paths at sigma_t = {}, g = {} had not ended after {dispatches} dispatches, expected fewer",
                job.sigma_t, job.g
            ),
        }
    }
}
