//! What `ambient_scattering` lets one trade speed for accuracy with.

use crate::technique::{Knob, Knobs};

/// The step, the radius and the rays a pixel.
pub const KNOBS: Knobs = Knobs {
    technique: super::NAME,
    knobs: &[
        Knob::new("technique.ambient_scattering.step", &["4", "2", "1", "0.5"]),
        Knob::new(
            "technique.ambient_scattering.radius",
            &["8", "4", "2", "auto"],
        ),
        Knob::new(Knob::SAMPLES_PER_AXIS, &["1", "2"]),
    ],
    lacks: Some("light that is scattered from far away, other than along a straight line"),
};
