//! The running sums on the device: pipelines, what they are bound to, and their order.

use std::sync::Arc;

use bytemuck::bytes_of;
use glam::UVec3;

use super::ScanForm;
use super::layout::{SCAN, SCAN_SEGMENTS, SCAN_SUBGROUP};
use crate::gpu::{Access, Binding, ComputePipeline, Device, GpuError, Image, Recorder, Resource};

/// The stages of one form.
pub(super) struct Scan {
    pub(super) form: ScanForm,
    along_x: Arc<ComputePipeline>,
    // Along y and z.
    across: Arc<ComputePipeline>,
}

/// A table with what scans it.
pub(super) struct Table {
    pub(super) image: Arc<Image>,
    along_x: Binding,
    across: Binding,
}

impl Scan {
    pub(super) fn new(device: &Device, form: ScanForm) -> Result<Self, GpuError> {
        let pipeline = |layout| ComputePipeline::new(device, layout, &[]).map(Arc::new);
        let (along_x, across) = match form {
            ScanForm::Serial => {
                let scan = pipeline(SCAN)?;
                (scan.clone(), scan)
            }
            ScanForm::Parallel => (pipeline(SCAN_SUBGROUP)?, pipeline(SCAN_SEGMENTS)?),
        };
        Ok(Self {
            form,
            along_x,
            across,
        })
    }

    pub(super) fn bind(&self, image: Arc<Image>) -> Result<Table, GpuError> {
        let table = || vec![Resource::Storage(image.clone())];
        Ok(Table {
            along_x: self.along_x.bind(table())?,
            across: self.across.bind(table())?,
            image,
        })
    }

    /// Sums along x, y and z, in place. The tables take turns at each axis, so that they fill the device together.
    pub(super) fn record<'a>(
        &'a self,
        recorder: &mut Recorder<'a>,
        tables: &'a [Table],
        cells: UVec3,
    ) {
        for (name, axes) in self.form.stages() {
            recorder.compute_stage(name, |r| {
                for &axis in *axes {
                    let earlier = if axis == 0 {
                        Access::ComputeWrite
                    } else {
                        Access::ComputeReadWrite
                    };
                    for table in tables {
                        // RAW and WAW: the lines along x add up what the extinction stage wrote, those along y
                        // and z what the lines along the axis before wrote.
                        r.image_barrier(&table.image, earlier, Access::ComputeReadWrite);
                    }
                    for table in tables {
                        self.dispatch(r, table, axis, cells);
                    }
                }
            });
        }
        for table in tables {
            // RAW: what reads boxes finds the finished table.
            recorder.image_barrier(&table.image, Access::ComputeReadWrite, Access::ComputeRead);
        }
    }

    fn dispatch<'a>(&'a self, r: &mut Recorder<'a>, table: &'a Table, axis: usize, cells: UVec3) {
        let (pipeline, binding) = if axis == 0 {
            (&self.along_x, &table.along_x)
        } else {
            (&self.across, &table.across)
        };
        let axis_push = axis as u32;
        let push = match (self.form, axis) {
            // Knows no axis but x.
            (ScanForm::Parallel, 0) => &[],
            _ => bytes_of(&axis_push),
        };
        r.dispatch(pipeline, binding, push, self.form.domain(axis, cells));
    }
}
