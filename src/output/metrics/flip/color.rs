//! The colour spaces of FLIP and the distance of two colours.

use glam::{Mat3, Vec3};

/// Compresses large distances of colours `[Andersson2020, Sec. 4.1.3]`.
const EXPONENT: f32 = 0.7;
/// This share of the largest distance ...
const KNEE: f32 = 0.4;
/// ... is mapped to this error; larger ones share what is left up to 1.
const ERROR_AT_KNEE: f32 = 0.95;

/// XYZ of linear RGB, columns red, green and blue: Rec.709 primaries, white (0.3127, 0.3290).
///
/// More digits than the rounded matrix of IEC 61966-2-1, so that greys have no colour left.
const XYZ_FROM_RGB: Mat3 = Mat3::from_cols(
    Vec3::new(0.412_390_8, 0.212_639, 0.019_330_82),
    Vec3::new(0.357_584_33, 0.715_168_7, 0.119_194_78),
    Vec3::new(0.180_480_8, 0.072_192_32, 0.950_532_14),
);

/// Both ways between linear RGB and XYZ relative to white.
#[derive(Clone, Copy)]
pub(super) struct Spaces {
    relative_from_rgb: Mat3,
    rgb_from_relative: Mat3,
}

impl Spaces {
    pub(super) fn new() -> Self {
        let white = XYZ_FROM_RGB * Vec3::ONE;
        let relative_from_rgb = Mat3::from_diagonal(white.recip()) * XYZ_FROM_RGB;
        Self {
            relative_from_rgb,
            rgb_from_relative: relative_from_rgb.inverse(),
        }
    }

    /// The linear opponent space YCxCz: light, red against green, yellow against blue.
    pub(super) fn opponent(&self, rgb: Vec3) -> Vec3 {
        let v = self.relative_from_rgb * rgb;
        Vec3::new(116.0 * v.y - 16.0, 500.0 * (v.x - v.y), 200.0 * (v.y - v.z))
    }

    /// Inverse of [`Spaces::opponent`].
    pub(super) fn rgb_from_opponent(&self, opponent: Vec3) -> Vec3 {
        let y = (opponent.x + 16.0) / 116.0;
        let relative = Vec3::new(opponent.y / 500.0 + y, y, y - opponent.z / 200.0);
        self.rgb_from_relative * relative
    }

    /// CIELAB with the Hunt effect: colours look paler in the dark `[Andersson2020, Sec. 4.1.2]`.
    pub(super) fn hunt_lab(&self, rgb: Vec3) -> Vec3 {
        let f = (self.relative_from_rgb * rgb).map(lab_curve);
        let light = 116.0 * f.y - 16.0;
        let hunt = 0.01 * light;
        Vec3::new(
            light,
            hunt * 500.0 * (f.x - f.y),
            hunt * 200.0 * (f.y - f.z),
        )
    }
}

/// Cube root with a straight start, as CIELAB defines it.
fn lab_curve(t: f32) -> f32 {
    const DELTA: f32 = 6.0 / 29.0;
    if t > DELTA * DELTA * DELTA {
        t.cbrt()
    } else {
        t / (3.0 * DELTA * DELTA) + 4.0 / 29.0
    }
}

/// Distance of large colour differences: city block in light, Euclidean in colour `[Abasi2020]`.
fn hyab(a: Vec3, b: Vec3) -> f32 {
    let d = a - b;
    d.x.abs() + d.y.hypot(d.z)
}

/// Turns distances of colours into errors in [0, 1].
pub(super) struct DistanceScale {
    /// Compressed distance of green and blue, the largest within sRGB.
    largest: f32,
}

impl DistanceScale {
    pub(super) fn new() -> Self {
        let spaces = Spaces::new();
        let distance = hyab(spaces.hunt_lab(Vec3::Y), spaces.hunt_lab(Vec3::Z));
        Self {
            largest: distance.powf(EXPONENT),
        }
    }

    /// Error of two Hunt-adjusted Lab colours `[Andersson2020, Sec. 4.1.3]`.
    pub(super) fn error(&self, a: Vec3, b: Vec3) -> f32 {
        let share = hyab(a, b).powf(EXPONENT) / self.largest;
        let error = if share < KNEE {
            share * ERROR_AT_KNEE / KNEE
        } else {
            ERROR_AT_KNEE + (share - KNEE) / (1.0 - KNEE) * (1.0 - ERROR_AT_KNEE)
        };
        // Green and blue can end a rounding error above 1.
        error.min(1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn opponent_colours_come_back() {
        let spaces = Spaces::new();
        for rgb in [Vec3::ZERO, Vec3::ONE, Vec3::new(0.9, 0.1, 0.4)] {
            let back = spaces.rgb_from_opponent(spaces.opponent(rgb));
            // Factors up to 500 are taken and undone in f32.
            assert!((back - rgb).abs().max_element() < 1e-5, "{rgb} {back}");
        }
    }

    #[test]
    fn greys_have_no_colour() {
        for grey in [0.0, 0.2, 1.0] {
            let lab = Spaces::new().hunt_lab(Vec3::splat(grey));
            assert!(lab.y.abs().max(lab.z.abs()) < 1e-3, "{lab}");
        }
    }
}
