//! What `single_scatter` lets one trade speed for accuracy with.

use crate::technique::{Knob, Knobs};

/// The step, the cache's resolution and the rays a pixel.
pub const KNOBS: Knobs = Knobs {
    technique: super::NAME,
    knobs: &[
        Knob::new("technique.single_scatter.step", &["4", "2", "1", "0.5"]),
        Knob::new("technique.single_scatter.cache", &["half", "full", "none"]),
        Knob::new(Knob::SAMPLES_PER_AXIS, &["1", "2"]),
    ],
    lacks: Some("light that is scattered more than once, and that of environments"),
};
