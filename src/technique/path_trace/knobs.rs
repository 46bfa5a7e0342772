//! What `path_trace` lets one trade speed for accuracy with.

use crate::technique::{Knob, Knobs};

/// The samples of a pixel.
pub const KNOBS: Knobs = Knobs {
    technique: super::NAME,
    knobs: &[Knob::new(
        "technique.path_trace.samples",
        &["1", "4", "16", "64", "256"],
    )],
    lacks: None,
};
