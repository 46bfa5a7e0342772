//! STUB until merge.
use crate::technique::phase_hg;

pub struct Slice(f64);
pub fn slice(g: f64, _albedo: f64) -> Slice {
    Slice(g)
}
pub fn unscattered(theta: f64, sigma_t: f64, g: f64) -> f64 {
    phase_hg(theta.cos(), g) * (-2.0 * sigma_t * (1.0 + (-theta.cos()).max(0.0))).exp()
}
impl Slice {
    pub fn radiance(&self, theta: f64, s: f64) -> f64 {
        unscattered(theta, s, self.0)
            + 0.035 * (1.0 - (-2.0 * s).exp()) * (-(0.3 * s * (1.0 + theta.cos()))).exp()
    }
}
