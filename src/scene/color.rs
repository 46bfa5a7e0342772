//! The sRGB transfer curve (IEC 61966-2-1). All work is done on linear values with sRGB primaries.

/// Linear value of an sRGB-encoded one, both in [0, 1]; odd-symmetric outside.
#[must_use]
pub fn linear_from_srgb(encoded: f32) -> f32 {
    let a = encoded.abs();
    let linear = if a <= 0.04045 {
        a / 12.92
    } else {
        ((a + 0.055) / 1.055).powf(2.4)
    };
    linear.copysign(encoded)
}

/// sRGB encoding of a linear value, both in [0, 1]; odd-symmetric outside.
#[must_use]
pub fn srgb_from_linear(linear: f32) -> f32 {
    let a = linear.abs();
    let encoded = if a <= 0.003_130_8 {
        a * 12.92
    } else {
        1.055 * a.powf(1.0 / 2.4) - 0.055
    };
    encoded.copysign(linear)
}
