//! Peak signal-to-noise ratio.

/// `20 log10(peak / rmse)` in dB; infinite for equal images, minus infinity for a peak of 0.
///
/// `peak` is in the units of `rmse`: 1 for display values, for radiance the largest channel of the
/// reference ([`super::Errors::peak`]), since radiance has no largest value of its own.
#[must_use]
pub fn psnr(rmse: f64, peak: f64) -> f64 {
    if rmse == 0.0 {
        return f64::INFINITY;
    }
    20.0 * (peak / rmse).log10()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decibels_by_hand() {
        assert_eq!(psnr(0.1, 1.0), 20.0);
        assert_eq!(psnr(0.5, 50.0), 40.0);
        assert_eq!(psnr(0.0, 1.0), f64::INFINITY);
        assert_eq!(psnr(0.0, 0.0), f64::INFINITY);
        assert_eq!(psnr(1.0, 0.0), f64::NEG_INFINITY);
    }
}
