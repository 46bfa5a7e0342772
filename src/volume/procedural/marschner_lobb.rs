//! The Marschner-Lobb test signal.

use std::f64::consts::{FRAC_PI_2, TAU};

use glam::DVec3;

/// Frequency of the waves, in cycles a unit of their cosine.
const F_M: f64 = 6.0;
/// Share of the waves in the signal.
const ALPHA: f64 = 0.25;

/// The signal of `[MarschnerLobb1994, Eq. 1-2]`, in [0, 1]:
/// `(1 - sin(pi z / 2) + alpha (1 + rho_r(sqrt(x^2 + y^2)))) / (2 (1 + alpha))` with
/// `rho_r(r) = cos(2 pi f_M cos(pi r / 2))`, `f_M` = 6 and `alpha` = 0.25, over [-1, 1]^3.
///
/// S. Marschner and R. Lobb, An Evaluation of Reconstruction Filters for Volume Rendering,
/// IEEE Visualization 1994. They sample it at 40^3, just above the Nyquist rate, and show the
/// isosurface at 0.5.
pub(super) fn evaluate(p: DVec3) -> f64 {
    let r = p.truncate().length();
    let rho_r = (TAU * F_M * (FRAC_PI_2 * r).cos()).cos();
    let signal = 1.0 - (FRAC_PI_2 * p.z).sin() + ALPHA * (1.0 + rho_r);
    signal / (2.0 * (1.0 + ALPHA))
}
