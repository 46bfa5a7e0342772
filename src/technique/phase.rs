//! The phase function, in double precision.

use std::f64::consts::PI;

/// The Henyey-Greenstein phase function, per steradian, `[Henyey1941]`; a cosine of 1 is straight on.
#[must_use]
pub fn phase_hg(cos_theta: f64, g: f64) -> f64 {
    (1.0 - g * g) / (4.0 * PI * (1.0 + g * g - 2.0 * g * cos_theta).powf(1.5))
}
