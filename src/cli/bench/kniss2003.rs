//! Section IV and Figure 14 of `[Kniss2003]`: volume shading beside volume rendering without any, of the CT of a carp.
//!
//! The text gives shares alone: frame rates with volume shading are 50 to 60 percent below those without, so that
//! a frame takes 2 to 2.5 times as long, and are comparable to those with surface shading. 55 percent stand here.

use super::paper::{Aim, Column, Model, Printed, Row, Spot, Table};
use super::stand_in;
use crate::volume::procedural::Procedural;

/// Frames with volume shading in the time of one without.
const SHARE: f64 = 0.45;

pub(super) const TABLE: Table = Table {
    title: "[Kniss2003, Section IV]",
    rows: &ROWS,
    models: stand_in::SLICES,
    unlit: Model::SlicesUnlit,
    changes: &[],
    times: false,
    aims: &AIMS,
    note: "All by half_angle, a slice a voxel; it keeps nothing from frame to frame.",
};

const AIMS: [Aim; 5] = {
    const fn aim(model: Model, over: Model, goal: Option<f64>) -> Aim {
        Aim {
            model,
            column: Column::Rendering,
            over,
            goal,
        }
    }
    use Model::{SlicesDirect, SlicesIndirect, SlicesNoise, SlicesSurface, SlicesUnlit};
    [
        aim(SlicesSurface, SlicesUnlit, None),
        aim(SlicesDirect, SlicesUnlit, None),
        aim(SlicesIndirect, SlicesUnlit, Some(1.6)),
        aim(SlicesIndirect, SlicesSurface, None),
        aim(SlicesNoise, SlicesIndirect, None),
    ]
};

const ROWS: [Row; 1] = [Row {
    name: "CT carp",
    dims: [256, 256, 512],
    stand_in: Procedural::SheppLogan,
    lights: &[Spot::UpperLeft],
    radius: None,
    g: 0.0,
    remark: "\"frame rates which are only 50 to 60 percent slower than volume rendering with no shading at all\",\n\
             2 to 2.5 times the time of an unlit frame, 2.22 as ratios here; \"comparable to\" surface shading",
    printed: &[
        printed(Model::SlicesUnlit, 1.0),
        printed(Model::SlicesSurface, SHARE),
        printed(Model::SlicesIndirect, SHARE),
    ],
}];

const fn printed(model: Model, fps: f64) -> Printed {
    Printed {
        model,
        figure: "14",
        changes_ms: [None; 3],
        fps,
    }
}
