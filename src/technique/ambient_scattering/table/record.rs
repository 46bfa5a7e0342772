//! Runs jobs of a stage, so many a submission, and hands back what they found.

use std::sync::Arc;

use bytemuck::bytes_of;
use glam::UVec3;

use super::layout::{ANGLES, Job, LANES, LAYOUTS, PreintegratePush, constants};
use crate::gpu::{
    Access, Binding, Buffer, BufferUse, ComputePipeline, Device, GpuError, Recorder, Resource,
};

/// Jobs a submission, at most: fractions of a second on two cores.
pub const JOBS: usize = 256;

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
    ends: Arc<Buffer>,
    albedos: Vec<f64>,
    seed: u32,
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
        let ends = buffer("ends", size_of::<[u32; 2]>(), BufferUse::StorageReadback)?;
        let list = [&jobs, &means, &ends].map(|b| Resource::StorageBuffer(b.clone()));
        Ok(Self {
            device: device.clone(),
            binding: pipeline.bind(list.to_vec())?,
            pipeline,
            jobs,
            means,
            ends,
            albedos: albedos.to_vec(),
            seed,
        })
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
        let push = PreintegratePush::new(self.seed, jobs.len() as u32, &self.albedos);
        let mut recorder = Recorder::new(&self.device)?;
        recorder.compute_stage(self.pipeline.name(), |r| {
            let domain = UVec3::new(jobs.len() as u32 * LANES, 1, 1);
            r.dispatch(&self.pipeline, &self.binding, bytes_of(&push), domain);
        });
        // RAW: the host reads what the jobs wrote.
        recorder.buffer_barrier(&self.means, Access::ComputeWrite, Access::HostRead);
        recorder.buffer_barrier(&self.ends, Access::ComputeWrite, Access::HostRead);
        let seconds = recorder.submit()?.iter().map(|t| t.seconds).sum();
        self.check_ends(jobs)?;
        let values = self.albedos.len() * ANGLES;
        self.means.with_bytes(|bytes| {
            let all: &[f32] = bytemuck::cast_slice(bytes);
            for (i, means) in all.chunks_exact(values).take(jobs.len()).enumerate() {
                found(i, means);
            }
        });
        Ok(seconds)
    }

    /// Rounds each of the last jobs took.
    #[must_use]
    pub fn rounds(&self, jobs: usize) -> Vec<u32> {
        self.ends.with_bytes(|bytes| {
            let ends: &[[u32; 2]] = bytemuck::cast_slice(bytes);
            ends.iter().take(jobs).map(|e| e[0]).collect()
        })
    }

    fn check_ends(&self, jobs: &[Job]) -> Result<(), GpuError> {
        self.ends.with_bytes(|bytes| {
            let ends: &[[u32; 2]] = bytemuck::cast_slice(bytes);
            let unfinished = jobs.iter().zip(ends).find(|(_, end)| end[1] != 0);
            let Some((job, end)) = unfinished else {
                return Ok(());
            };
            Err(GpuError::Shader {
                name: self.pipeline.name().to_owned(),
                message: format!(
                    "paths at sigma_t = {}, g = {} had not ended after {} rounds, expected fewer",
                    job.sigma_t, job.g, end[0]
                ),
            })
        })
    }
}
