//! The walk: dispatches of a bounded number of scattering events a pixel, until every pixel has its samples.

use bytemuck::bytes_of;
use glam::UVec3;

use super::{PathTrace, TracePush};
use crate::gpu::{Access, Device, GpuError, Recorder, StageTime};
use crate::scene::PathTraceParams;

/// Invocations a tile.
const TILE_INVOCATIONS: u32 = 64;

/// Renders all samples anew; `progress(done, total)` counts samples of all pixels.
///
/// # Errors
/// The driver's refusal, a lost device, or a validation message.
pub fn record_trace(
    device: &Device,
    path_trace: &PathTrace,
    params: &PathTraceParams,
    progress: &mut dyn FnMut(u64, u64),
) -> Result<Vec<StageTime>, GpuError> {
    let plan = &path_trace.plan;
    let pixels = u64::from(plan.image[0]) * u64::from(plan.image[1]);
    let total = pixels * u64::from(params.samples);
    let name = plan.trace().shader.name;
    let mut push = TracePush {
        rounds: plan.rounds,
        samples: params.samples,
        seed: params.seed,
        first: 1,
    };
    let (mut done, mut seconds) = (0, 0.0);
    let mut before = path_trace.counts();
    loop {
        seconds += walk(device, path_trace, &push)?;
        push.first = 0;
        let after = path_trace.counts();
        let [unfinished, samples] = [0, 1].map(|i| after[i].wrapping_sub(before[i]));
        before = after;
        done += u64::from(samples);
        progress(done, total);
        if unfinished == 0 {
            break;
        }
    }
    Ok(vec![StageTime {
        name: name.to_owned(),
        seconds,
    }])
}

/// One dispatch; returns the device's seconds.
fn walk(device: &Device, path_trace: &PathTrace, push: &TracePush) -> Result<f64, GpuError> {
    let (plan, b) = (&path_trace.plan, &path_trace.buffers);
    let mut recorder = Recorder::new(device)?;
    // RAW and WAW: a dispatch goes on from what the one before wrote.
    recorder.image_barrier(
        &path_trace.radiance,
        Access::ComputeWrite,
        Access::ComputeReadWrite,
    );
    let before = if push.first > 0 {
        // The old contents are of another image.
        Access::Undefined
    } else {
        Access::ComputeReadWrite
    };
    for image in [&b.moments, &b.walkers] {
        recorder.image_barrier(image, before, Access::ComputeReadWrite);
    }
    recorder.compute_stage(plan.trace().shader.name, |r| {
        let domain = UVec3::new(plan.groups * TILE_INVOCATIONS, 1, 1);
        let (pipeline, binding) = (&path_trace.pipeline, &path_trace.binding);
        r.dispatch(pipeline, binding, bytes_of(push), domain);
    });
    // RAW: the copy reads what the walk added.
    recorder.image_barrier(&b.counters, Access::ComputeReadWrite, Access::CopyRead);
    recorder.copy_to_buffer(&b.counters, &b.counters_read_back);
    // RAW: the host reads what the copy wrote.
    recorder.buffer_barrier(&b.counters_read_back, Access::CopyWrite, Access::HostRead);
    // WAR: the next dispatch adds to what the copy read.
    recorder.image_barrier(&b.counters, Access::CopyRead, Access::ComputeReadWrite);
    Ok(recorder.submit()?.iter().map(|t| t.seconds).sum())
}

impl PathTrace {
    /// Pixels found unfinished and samples made, since the counters exist, both modulo 2^32.
    fn counts(&self) -> [u32; 2] {
        self.buffers
            .counters_read_back
            .with_bytes(|bytes| bytemuck::pod_read_unaligned(&bytes[..8]))
    }
}
