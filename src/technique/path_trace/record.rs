//! The walk: dispatches of a bounded number of scattering events a pixel, until every pixel has its samples.

use std::time::Instant;

use bytemuck::bytes_of;
use glam::UVec3;

use super::{PathTrace, TracePush};
use crate::gpu::{Access, Device, GpuError, Recorder, StageTime};
use crate::scene::PathTraceParams;

/// Samples that speed and error are first judged by.
const FIRST_SAMPLES: u32 = 16;

/// Invocations a tile.
const TILE_INVOCATIONS: u32 = 64;

/// Renders anew until a goal is reached; `progress(done, total)` counts samples of all pixels, or
/// milliseconds where time is the goal.
///
/// # Errors
/// The driver's refusal, a lost device, or a validation message.
pub fn record_trace(
    device: &Device,
    path_trace: &mut PathTrace,
    params: &PathTraceParams,
    progress: &mut dyn FnMut(u64, u64),
) -> Result<Vec<StageTime>, GpuError> {
    let start = Instant::now();
    let name = path_trace.plan.trace().shader.name.to_owned();
    let (mut seconds, mut error) = (0.0, None);
    path_trace.samples = 0;
    loop {
        let elapsed = start.elapsed().as_secs_f64();
        let Some(samples) = next_goal(params, path_trace.samples, elapsed, error) else {
            break;
        };
        let in_all = foreseen(params, path_trace.samples, samples, error);
        let pixels = u64::from(path_trace.plan.image[0]) * u64::from(path_trace.plan.image[1]);
        let mut show = |done: u64| match params.seconds {
            Some(limit) => {
                let spent = start.elapsed().as_secs_f64().min(limit);
                progress((1e3 * spent) as u64, (1e3 * limit) as u64);
            }
            None => progress(done, pixels * u64::from(in_all)),
        };
        seconds += walk_to(device, path_trace, params, samples, &mut show)?;
        path_trace.samples = samples;
        if params.target_error.is_some() {
            error = Some(path_trace.relative_error(device)?);
        }
    }
    Ok(vec![StageTime { name, seconds }])
}

/// Samples that every pixel should have next, if it should have more: `done` took `elapsed` seconds and
/// left the relative `error`.
fn next_goal(params: &PathTraceParams, done: u32, elapsed: f64, error: Option<f64>) -> Option<u32> {
    let reached = |error: f64| params.target_error.is_some_and(|target| error <= target);
    if done >= params.samples || error.is_some_and(reached) {
        return None;
    }
    let mut goal = foreseen(params, done, params.samples, error);
    if params.target_error.is_some() || params.seconds.is_some() {
        // What few samples say of speed and error is uncertain.
        goal = goal.min(done.saturating_mul(4).max(FIRST_SAMPLES));
    }
    if let Some(limit) = params.seconds
        && done > 0
    {
        let affordable = f64::from(done) * (limit - elapsed) / elapsed;
        if affordable < 1.0 {
            return None;
        }
        goal = goal.min(done.saturating_add(affordable as u32));
    }
    Some(goal.min(params.samples))
}

/// Samples it takes to reach the target error, as far as `error` after `done` samples tells; else
/// `unknown`.
fn foreseen(params: &PathTraceParams, done: u32, unknown: u32, error: Option<f64>) -> u32 {
    match (params.target_error, error) {
        (Some(target), Some(error)) => {
            let needed = 1.02 * f64::from(done) * (error / target).powi(2);
            (needed.ceil() as u32).max(done.saturating_add(1))
        }
        _ => unknown,
    }
}

/// Walks until every pixel has `samples`; returns the device's seconds.
fn walk_to(
    device: &Device,
    path_trace: &PathTrace,
    params: &PathTraceParams,
    samples: u32,
    progress: &mut dyn FnMut(u64),
) -> Result<f64, GpuError> {
    let plan = &path_trace.plan;
    let pixels = u64::from(plan.image[0]) * u64::from(plan.image[1]);
    let mut push = TracePush {
        rounds: plan.rounds,
        samples,
        seed: params.seed,
        first: u32::from(path_trace.samples == 0),
    };
    let (mut done, mut seconds) = (pixels * u64::from(path_trace.samples), 0.0);
    let mut before = path_trace.counts();
    loop {
        seconds += walk(device, path_trace, &push)?;
        push.first = 0;
        let after = path_trace.counts();
        let [unfinished, made] = [0, 1].map(|i| after[i].wrapping_sub(before[i]));
        before = after;
        done += u64::from(made);
        progress(done);
        if unfinished == 0 {
            return Ok(seconds);
        }
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    const PARAMS: PathTraceParams = PathTraceParams {
        samples: 1000,
        seconds: None,
        target_error: None,
        max_scatter: None,
        seed: 0,
    };

    #[test]
    fn samples_alone_are_one_goal() {
        assert_eq!(next_goal(&PARAMS, 0, 0.0, None), Some(1000));
        assert_eq!(next_goal(&PARAMS, 1000, 1.0, None), None);
    }

    #[test]
    fn time_affords_what_the_speed_so_far_says() {
        let params = PathTraceParams {
            seconds: Some(10.0),
            ..PARAMS
        };
        assert_eq!(next_goal(&params, 0, 0.0, None), Some(16));
        // 16 a second: 144 more fit, but no more than four times as many at once.
        assert_eq!(next_goal(&params, 16, 1.0, None), Some(64));
        assert_eq!(next_goal(&params, 64, 4.0, None), Some(160));
        assert_eq!(next_goal(&params, 160, 9.99, None), None);
        assert_eq!(next_goal(&params, 160, 11.0, None), None);
    }

    #[test]
    fn the_error_falls_with_the_root_of_samples() {
        let params = PathTraceParams {
            target_error: Some(0.01),
            ..PARAMS
        };
        assert_eq!(next_goal(&params, 100, 1.0, Some(0.02)), Some(400));
        assert_eq!(next_goal(&params, 100, 1.0, Some(0.01)), None);
        assert_eq!(next_goal(&params, 100, 1.0, Some(0.5)), Some(400));
        assert_eq!(next_goal(&params, 100, 1.0, Some(0.011)), Some(124));
        assert_eq!(next_goal(&params, 1000, 1.0, Some(0.011)), None);
    }
}
