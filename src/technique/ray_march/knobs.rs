//! What `ray_march` lets one trade speed for accuracy with.

use crate::scene::TechniqueParams;
use crate::technique::{Knob, Knobs};

/// The step, the rays a pixel and how far neighbours share gradients.
pub const KNOBS: Knobs = Knobs {
    technique: super::NAME,
    knobs: &[
        Knob::new("technique.ray_march.step", &["4", "2", "1", "0.5", "0.25"]),
        Knob::new(Knob::SAMPLES_PER_AXIS, &["1", "2"]),
        Knob {
            key: "technique.ray_march.shading.merge_opacity",
            values: &["1", "0.015625"],
            applies: is_shaded,
        },
    ],
    lacks: Some("shadows and scattering: the colour is source radiance, or is lit at every sample"),
};

/// Without shading there are no gradients, and setting a factor would switch it on.
const fn is_shaded(params: &TechniqueParams) -> bool {
    matches!(params, TechniqueParams::RayMarch(p) if p.shading.is_some())
}
