//! In which of two forms running sums are made: pure data.

use glam::UVec3;

use super::stage;
use crate::gpu::Limits;

/// How the lines of a table are summed. Both forms give the same bits: sums of whole numbers are exact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ScanForm {
    /// One invocation a line along any axis, as suits software drivers.
    Serial,
    /// Many invocations a line, as fills a GPU: a subgroup along x, segments along y and z.
    Parallel,
}

/// Invocations a line along x in the parallel form. Any number is right; this one gives most GPUs a subgroup a line.
const INVOCATIONS_A_LINE: u32 = 32;

impl ScanForm {
    /// The form that is fastest on a device.
    #[must_use]
    pub const fn new(limits: &Limits) -> Self {
        if limits.prefers_subgroups {
            Self::Parallel
        } else {
            Self::Serial
        }
    }

    /// The stages in order, with the axes that each sums along.
    #[must_use]
    pub const fn stages(self) -> &'static [(&'static str, &'static [usize])] {
        match self {
            Self::Serial => &[(stage::SCAN, &[0, 1, 2])],
            Self::Parallel => &[
                (stage::SCAN_SUBGROUP, &[0]),
                (stage::SCAN_SEGMENTS, &[1, 2]),
            ],
        }
    }

    /// Invocations of one dispatch that sums the lines along `axis` (0, 1, 2) of a table of `cells`.
    #[must_use]
    pub const fn domain(self, axis: usize, cells: UVec3) -> UVec3 {
        match (self, axis) {
            (Self::Serial, 0) => UVec3::new(cells.y, cells.z, 1),
            (Self::Serial, 1) => UVec3::new(cells.x, cells.z, 1),
            (Self::Serial, _) => UVec3::new(cells.x, cells.y, 1),
            (Self::Parallel, 0) => UVec3::new(INVOCATIONS_A_LINE * cells.y, cells.z, 1),
            (Self::Parallel, 1) => UVec3::new(cells.x, 1, cells.z),
            (Self::Parallel, _) => UVec3::new(cells.x, 1, cells.y),
        }
    }
}
