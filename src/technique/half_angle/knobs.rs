//! What `half_angle` lets one trade speed for accuracy with.

use crate::scene::{Lighting, TechniqueParams};
use crate::technique::{Knob, Knobs};

/// Slices, texels of the light buffer, how scattered light spreads, and the rays a pixel.
pub const KNOBS: Knobs = Knobs {
    technique: super::NAME,
    knobs: &[
        Knob::new(
            "technique.half_angle.slice_spacing",
            &["4", "2", "1", "0.5"],
        ),
        Knob {
            key: "technique.half_angle.light_buffer",
            values: &["128", "256", "512"],
            applies: is_shadowed,
        },
        Knob {
            key: "technique.half_angle.blur_angle_deg",
            values: &["30", "60", "120"],
            applies: is_spread,
        },
        Knob {
            key: "technique.half_angle.blur_samples",
            values: &["4", "8", "16"],
            applies: is_spread,
        },
        Knob::new(Knob::SAMPLES_PER_AXIS, &["1", "2"]),
    ],
    lacks: Some("light that is scattered back or aside, and that of environments"),
};

const fn is_shadowed(params: &TechniqueParams) -> bool {
    matches!(params, TechniqueParams::HalfAngle(p)
        if matches!(p.lighting, Lighting::Direct | Lighting::Indirect))
}

const fn is_spread(params: &TechniqueParams) -> bool {
    matches!(params, TechniqueParams::HalfAngle(p) if matches!(p.lighting, Lighting::Indirect))
}
