//! The cells' stages, in order, with their barriers.

use bytemuck::bytes_of;

use super::resources::Cells;
use super::{Medium, OccupancyPush, stage};
use crate::gpu::{Access, Recorder};
use crate::volume::Volume;

/// `cell_min_max`: after a change of the volume.
pub fn record_ranges<'a>(recorder: &mut Recorder<'a>, medium: &'a Medium, volume: &Volume) {
    let Some(cells) = &medium.cells else { return };
    let (pipeline, binding) = &cells.min_max_stage;
    let field = volume.height_field.as_ref();
    let faces = field.map_or([0.0; 2], |f| [f.bottom as f32, f.top as f32]);
    // The old contents are of another volume.
    recorder.image_barrier(&cells.min_max, Access::Undefined, Access::ComputeWrite);
    recorder.compute_stage(stage::CELL_MIN_MAX, |r| {
        r.dispatch(pipeline, binding, bytes_of(&faces), cells.plan.dims);
    });
    // RAW: cell_occupancy reads what cell_min_max wrote.
    recorder.image_barrier(&cells.min_max, Access::ComputeWrite, Access::ComputeSampled);
}

/// `cell_occupancy` and `cell_distance`: after a change of volume or transfer function.
pub fn record_occupancy<'a>(recorder: &mut Recorder<'a>, medium: &'a Medium) {
    let Some(cells) = &medium.cells else { return };
    let (table_min, table_scale) = medium.table_mapping();
    let push = OccupancyPush {
        table_min,
        table_scale,
    };
    let (pipeline, binding) = &cells.occupancy_stage;
    // The old contents are of another transfer function.
    recorder.image_barrier(&cells.distance, Access::Undefined, Access::ComputeWrite);
    recorder.compute_stage(stage::CELL_OCCUPANCY, |r| {
        r.dispatch(pipeline, binding, bytes_of(&push), cells.plan.dims);
    });
    let after = medium.plan.reading();
    recorder.compute_stage(stage::CELL_DISTANCE, |r| record_distance(r, cells, after));
}

/// One dispatch an axis, alternating between the two images; the result ends in `pong`.
fn record_distance<'a>(r: &mut Recorder<'a>, cells: &'a Cells, after: Access) {
    let pipeline = &cells.distance_pipeline;
    let (image, pong, dims) = (&*cells.distance, &*cells.pong, cells.plan.dims);
    // RAW: the pass along x reads what cell_occupancy wrote.
    r.image_barrier(image, Access::ComputeWrite, Access::ComputeSampled);
    r.image_barrier(pong, Access::Undefined, Access::ComputeWrite);
    r.dispatch(pipeline, &cells.to_pong, bytes_of(&0u32), dims);
    // WAR and RAW: the pass along y writes what x read, and reads what x wrote.
    r.image_barrier(image, Access::ComputeSampled, Access::ComputeWrite);
    r.image_barrier(pong, Access::ComputeWrite, Access::ComputeSampled);
    r.dispatch(pipeline, &cells.from_pong, bytes_of(&1u32), dims);
    // WAR and RAW: likewise for z.
    r.image_barrier(pong, Access::ComputeSampled, Access::ComputeWrite);
    r.image_barrier(image, Access::ComputeWrite, Access::ComputeSampled);
    r.dispatch(pipeline, &cells.to_pong, bytes_of(&2u32), dims);
    // RAW: the techniques read what z wrote.
    r.image_barrier(pong, Access::ComputeWrite, after);
}
