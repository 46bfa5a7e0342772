//! First the cells, slab by slab; then running sums along x, y and z, table by table.

use bytemuck::bytes_of;
use glam::UVec3;

use super::{ExtinctionPush, SummedArea, Sums};
use crate::gpu::{Device, GpuError, Recorder, StageTime};

/// Fills the tables; `progress(done, total)` counts submissions.
///
/// # Errors
/// The driver's refusal, a lost device, or a validation message.
pub fn record_sums(
    device: &Device,
    area: &SummedArea,
    sums: &Sums,
    progress: &mut dyn FnMut(u64, u64),
) -> Result<Vec<StageTime>, GpuError> {
    let plan = &area.plan;
    let name = plan.extinction().shader.name;
    let total = plan.submissions() + 1;
    let mut seconds = 0.0;
    for index in 0..plan.submissions() {
        let first_slice = index * plan.slices_per_submission;
        let slice_count = plan.slices_per_submission.min(plan.cells.z - first_slice);
        let push = ExtinctionPush {
            first_slice,
            slice_count,
        };
        let mut recorder = Recorder::new(device)?;
        recorder.compute_stage(name, |r| {
            let domain = UVec3::new(plan.cells.x, plan.cells.y, slice_count);
            r.dispatch(&area.extinction, &sums.extinction, bytes_of(&push), domain);
        });
        seconds += recorder.submit()?.iter().map(|t| t.seconds).sum::<f64>();
        progress(u64::from(index) + 1, u64::from(total));
    }
    let mut recorder = Recorder::new(device)?;
    area.scan.record(&mut recorder, &sums.tables, plan.cells);
    let mut times = vec![StageTime {
        name: name.to_owned(),
        seconds,
    }];
    times.extend(recorder.submit()?);
    progress(u64::from(total), u64::from(total));
    Ok(times)
}
