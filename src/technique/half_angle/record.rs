//! Sweeps: slice by slice into the eye buffer and on to the next light buffer; then into the image.

use bytemuck::bytes_of;
use glam::UVec3;

use super::layout::{ComposePush, SlicePush};
use super::plan::MAX_INVOCATIONS;
use super::sweep::{Rect, Slice};
use super::{HalfAngle, stage};
use crate::gpu::{Access, Device, GpuError, Recorder, StageTime};

/// Renders every sub-sample by every sweep; `progress(done, total)` counts them.
///
/// # Errors
/// The driver's refusal, a lost device, or a validation message.
pub fn record_sweeps(
    device: &Device,
    half_angle: &HalfAngle,
    progress: &mut dyn FnMut(u64, u64),
) -> Result<Vec<StageTime>, GpuError> {
    let plan = &half_angle.plan;
    let sweeps = plan.sweeps.len();
    let total = u64::from(plan.sub_samples) * sweeps as u64;
    let mut seconds = [0.0, 0.0];
    for sub_sample in 0..plan.sub_samples {
        for (index, sweep) in plan.sweeps.iter().enumerate() {
            half_angle.write_block(index);
            let slices: Vec<_> = (0..).zip(sweep.schedule(&plan.lens)).collect();
            let last = slices.len() as u32 - 1;
            let mut current = 0;
            for batch in batches(&slices) {
                let mut recorder = Recorder::new(device)?;
                recorder.compute_stage(stage::SWEEP, |r| {
                    if batch.first().is_some_and(|(i, _)| *i == 0) {
                        clear(r, half_angle);
                    }
                    for (i, slice) in batch {
                        let is_last = *i == last;
                        record_slice(
                            r,
                            half_angle,
                            (*i, slice, is_last),
                            sub_sample,
                            &mut current,
                        );
                    }
                });
                let is_done = batch.last().is_some_and(|(i, _)| *i == last);
                if is_done {
                    let push = ComposePush {
                        sub_sample,
                        sweep: index as u32,
                    };
                    record_compose(&mut recorder, half_angle, push);
                }
                for time in recorder.submit()? {
                    seconds[usize::from(time.name == stage::COMPOSE)] += time.seconds;
                }
            }
            let done = u64::from(sub_sample) * sweeps as u64 + index as u64 + 1;
            progress(done, total);
        }
    }
    let time = |(name, seconds): (&str, f64)| StageTime {
        name: name.to_owned(),
        seconds,
    };
    let names = [stage::SWEEP, stage::COMPOSE];
    Ok(names.into_iter().zip(seconds).map(time).collect())
}

/// Slices in runs, none of them a long submission.
fn batches(slices: &[(u32, Slice)]) -> Vec<&[(u32, Slice)]> {
    let mut runs = Vec::new();
    let (mut first, mut work) = (0, 0);
    for (i, (_, slice)) in slices.iter().enumerate() {
        let [a, b] = [slice.pixels, slice.texels].map(|r| r.size().as_u64vec2().element_product());
        if work > 0 && work + a + b > MAX_INVOCATIONS {
            runs.push(&slices[first..i]);
            (first, work) = (i, 0);
        }
        work += a + b;
    }
    runs.push(&slices[first..]);
    runs
}

/// Nothing was seen yet, and all light is ahead.
fn clear<'a>(r: &mut Recorder<'a>, half_angle: &'a HalfAngle) {
    let [ping, pong] = &half_angle.light_buffers;
    for image in [ping, pong, &half_angle.eye] {
        // WAR: the sweep before, or its compose, read what is cleared.
        r.image_barrier(image, Access::ComputeReadWrite, Access::Clear);
        r.clear_image(image);
        // RAW and WAW: the slices read and write what was cleared.
        r.image_barrier(image, Access::Clear, Access::ComputeReadWrite);
    }
}

/// Two passes of [Kniss2003, Fig. 3]: the viewer's, by light as it enters the slice; the light's, to where it leaves.
fn record_slice<'a>(
    r: &mut Recorder<'a>,
    half_angle: &'a HalfAngle,
    (index, slice, is_last): (u32, &Slice, bool),
    sub_sample: u32,
    current: &mut usize,
) {
    if !slice.pixels.is_empty() {
        let push = SlicePush::shade(slice, index, sub_sample);
        r.labelled(half_angle.shade.name(), |r| {
            let binding = &half_angle.shade_bindings[*current];
            let domain = domain(half_angle, &slice.pixels);
            r.dispatch(&half_angle.shade, binding, bytes_of(&push), domain);
        });
        // RAW and WAW: the next slice, or compose, adds to what this one left in the eye buffer.
        r.image_barrier(
            &half_angle.eye,
            Access::ComputeReadWrite,
            Access::ComputeReadWrite,
        );
    }
    let Some((pipeline, bindings)) = &half_angle.propagate else {
        return;
    };
    if is_last || slice.texels.is_empty() {
        return;
    }
    let push = SlicePush::propagate(slice, index);
    r.labelled(pipeline.name(), |r| {
        let domain = domain(half_angle, &slice.texels);
        r.dispatch(pipeline, &bindings[*current], bytes_of(&push), domain);
    });
    // WAR: the next slice writes what both passes of this one read.
    r.image_barrier(
        &half_angle.light_buffers[*current],
        Access::ComputeRead,
        Access::ComputeWrite,
    );
    *current = 1 - *current;
    // RAW: both passes of the next slice read what this one wrote.
    r.image_barrier(
        &half_angle.light_buffers[*current],
        Access::ComputeWrite,
        Access::ComputeRead,
    );
}

/// Invocations along x and y, each of which goes through some rows.
fn domain(half_angle: &HalfAngle, rect: &Rect) -> UVec3 {
    let size = rect.size();
    UVec3::new(size.x, size.y.div_ceil(half_angle.plan.rows), 1)
}

fn record_compose<'a>(r: &mut Recorder<'a>, half_angle: &'a HalfAngle, push: ComposePush) {
    // RAW and WAW: sweeps and sub-samples add to what the ones before wrote.
    r.image_barrier(
        &half_angle.radiance,
        Access::ComputeWrite,
        Access::ComputeReadWrite,
    );
    let [width, height] = half_angle.plan.image;
    r.compute_stage(stage::COMPOSE, |r| {
        r.dispatch(
            &half_angle.compose,
            &half_angle.compose_binding,
            bytes_of(&push),
            UVec3::new(width, height, 1),
        );
    });
}
