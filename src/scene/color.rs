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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn round_trip_keeps_every_8_bit_level() {
        for level in 0..=255u8 {
            let encoded = f32::from(level) / 255.0;
            let back = srgb_from_linear(linear_from_srgb(encoded));
            assert!((back - encoded).abs() < 1e-6, "{level}: {back}");
        }
    }

    #[test]
    fn known_values_and_symmetry() {
        assert_eq!(linear_from_srgb(0.0), 0.0);
        assert!((linear_from_srgb(1.0) - 1.0).abs() < 1e-6);
        // Photographic middle grey.
        assert!((linear_from_srgb(0.5) - 0.214_041).abs() < 1e-6);
        assert!((srgb_from_linear(0.18) - 0.461_356).abs() < 1e-5);
        assert_eq!(linear_from_srgb(-0.5), -linear_from_srgb(0.5));
        assert_eq!(srgb_from_linear(-0.18), -srgb_from_linear(0.18));
    }

    #[test]
    fn the_two_pieces_of_the_curve_meet() {
        let step = linear_from_srgb(0.040_451) - linear_from_srgb(0.040_449);
        assert!(step.abs() < 1e-6);
        let step = srgb_from_linear(0.003_130_9) - srgb_from_linear(0.003_130_7);
        assert!(step.abs() < 1e-5);
    }
}
