//! What of `L_o` is known in closed form.

use crate::technique::phase_hg;

/// Radiance out of the sphere that has not collided within it: the front's own light, straight through
/// the centre. Per unit irradiance of the front, 1 / sr.
///
/// `theta` is the angle between the outgoing direction and the light's, radians; `sigma_t` is extinction
/// times radius. `[Ament2013, Eq. 11]` at the far end of the eye's diameter.
#[must_use]
pub fn unscattered(theta: f64, sigma_t: f64, g: f64) -> f64 {
    let height = (-theta.cos()).max(0.0);
    (-2.0 * sigma_t * (1.0 + height)).exp() * phase_hg(theta.cos(), g)
}

/// The share of light along a diameter that collides, `1 - exp(-2 sigma_t)`.
#[must_use]
pub fn colliding(sigma_t: f64) -> f64 {
    -(-2.0 * sigma_t).exp_m1()
}

/// What [`collided`](super::Sums) radiance is in thin media: light that the front scatters with `g`, and a
/// collision once more, is Henyey-Greenstein with `g^2`, 1 / sr.
#[must_use]
pub fn thin_collided(theta: f64, g: f64) -> f64 {
    phase_hg(theta.cos(), g * g)
}

/// How fast radiance falls off in a dense medium, per mean free path: diffusion's
/// `sqrt(3 (1 - albedo) (1 - albedo g))`, at most 0.95. Only where samples go depends on it, no result.
#[must_use]
pub fn decay(albedo: f64, g: f64) -> f64 {
    (3.0 * (1.0 - albedo) * (1.0 - albedo * g)).sqrt().min(0.95)
}
