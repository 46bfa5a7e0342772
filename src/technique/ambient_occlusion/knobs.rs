//! What `ambient_occlusion` lets one trade speed for accuracy with.

use crate::technique::{Knob, Knobs};

/// The step, the radius and the rays a pixel.
pub const KNOBS: Knobs = Knobs {
    technique: super::NAME,
    knobs: &[
        Knob::new("technique.ambient_occlusion.step", &["4", "2", "1", "0.5"]),
        Knob::new("technique.ambient_occlusion.radius", &["4", "8", "14"]),
        Knob::new(Knob::SAMPLES_PER_AXIS, &["1", "2"]),
    ],
    lacks: Some(
        "light of directional and point sources, and light that is scattered more than once",
    ),
};
