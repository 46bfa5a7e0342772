//! Interpolation between two sRGB-encoded colours in the spaces that colour maps name.

use glam::Vec3;

use crate::scene::{linear_from_srgb, srgb_from_linear};

/// Where a colour map interpolates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Space {
    Rgb,
    Hsv,
    Lab,
    /// Moreland's Msh: through white between saturated colours.
    Diverging,
    Step,
}

impl Space {
    pub(super) fn parse(name: &str) -> Result<Self, String> {
        match name.to_lowercase().as_str() {
            "" | "rgb" | "linear" => Ok(Self::Rgb),
            "hsv" => Ok(Self::Hsv),
            "lab" | "cielab" | "lab/ciede2000" => Ok(Self::Lab),
            "diverging" => Ok(Self::Diverging),
            "step" => Ok(Self::Step),
            _ => Err(format!(
                "ColorSpace: found {name}, expected RGB, HSV, Lab, Diverging or Step"
            )),
        }
    }
}

/// The colour at `s` in [0, 1] from `a` to `b`, all sRGB-encoded.
pub(super) fn between(a: Vec3, b: Vec3, s: f32, space: Space) -> Vec3 {
    match space {
        Space::Rgb => a.lerp(b, s),
        Space::Step => a,
        Space::Hsv => {
            let (mut x, mut y) = (hsv(a), hsv(b));
            // The shorter way around the circle.
            if y.x - x.x > 0.5 {
                x.x += 1.0;
            } else if x.x - y.x > 0.5 {
                y.x += 1.0;
            }
            rgb_from_hsv(x.lerp(y, s))
        }
        Space::Lab => rgb_from_lab(lab(a).lerp(lab(b), s)),
        Space::Diverging => diverging(a, b, s),
    }
}

fn hsv(c: Vec3) -> Vec3 {
    let (max, min) = (c.max_element(), c.min_element());
    let chroma = max - min;
    let hue = if chroma <= 0.0 {
        0.0
    } else if max == c.x {
        ((c.y - c.z) / chroma).rem_euclid(6.0)
    } else if max == c.y {
        (c.z - c.x) / chroma + 2.0
    } else {
        (c.x - c.y) / chroma + 4.0
    };
    Vec3::new(hue / 6.0, if max > 0.0 { chroma / max } else { 0.0 }, max)
}

fn rgb_from_hsv(c: Vec3) -> Vec3 {
    let channel = |n: f32| {
        let k = (n + 6.0 * c.x).rem_euclid(6.0);
        c.z * (1.0 - c.y * k.min(4.0 - k).clamp(0.0, 1.0))
    };
    Vec3::new(channel(5.0), channel(3.0), channel(1.0))
}

/// D65 white.
const WHITE: Vec3 = Vec3::new(0.950_47, 1.0, 1.088_83);

fn lab(c: Vec3) -> Vec3 {
    let l = Vec3::from(c.to_array().map(linear_from_srgb));
    let xyz = Vec3::new(
        l.dot(Vec3::new(0.412_456, 0.357_576, 0.180_437)),
        l.dot(Vec3::new(0.212_673, 0.715_152, 0.072_175)),
        l.dot(Vec3::new(0.019_334, 0.119_192, 0.950_304)),
    ) / WHITE;
    let f = Vec3::from(xyz.to_array().map(|t| {
        if t > 216.0 / 24389.0 {
            t.cbrt()
        } else {
            (24389.0 / 27.0 * t + 16.0) / 116.0
        }
    }));
    Vec3::new(116.0 * f.y - 16.0, 500.0 * (f.x - f.y), 200.0 * (f.y - f.z))
}

fn rgb_from_lab(c: Vec3) -> Vec3 {
    let y = (c.x + 16.0) / 116.0;
    let f = [y + c.y / 500.0, y, y - c.z / 200.0];
    let xyz = Vec3::from(f.map(|t| {
        let cube = t * t * t;
        if cube > 216.0 / 24389.0 {
            cube
        } else {
            (116.0 * t - 16.0) * 27.0 / 24389.0
        }
    })) * WHITE;
    let linear = [
        xyz.dot(Vec3::new(3.240_454, -1.537_139, -0.498_531)),
        xyz.dot(Vec3::new(-0.969_266, 1.876_011, 0.041_556)),
        xyz.dot(Vec3::new(0.055_643, -0.204_026, 1.057_225)),
    ];
    Vec3::from(linear.map(|v| srgb_from_linear(v.clamp(0.0, 1.0))))
}

/// Moreland 2009: magnitude, saturation and hue angle of Lab; white in the middle of two saturated
/// colours, the hue of an unsaturated end turned to keep the map smooth.
fn diverging(a: Vec3, b: Vec3, s: f32) -> Vec3 {
    let (mut x, mut y) = (msh(a), msh(b));
    let mut s = s;
    let apart = (x.z - y.z).abs();
    let apart = apart.min(std::f32::consts::TAU - apart);
    if x.y > 0.05 && y.y > 0.05 && apart > std::f32::consts::FRAC_PI_3 {
        let middle = x.x.max(y.x).max(88.0);
        if s < 0.5 {
            y = Vec3::new(middle, 0.0, 0.0);
            s *= 2.0;
        } else {
            x = Vec3::new(middle, 0.0, 0.0);
            s = 2.0 * s - 1.0;
        }
    }
    if x.y < 0.05 && y.y > 0.05 {
        x.z = spun(y, x.x);
    } else if y.y < 0.05 && x.y > 0.05 {
        y.z = spun(x, y.x);
    }
    let m = x.lerp(y, s);
    rgb_from_lab(m.x * Vec3::new(m.y.cos(), m.y.sin() * m.z.cos(), m.y.sin() * m.z.sin()))
}

fn msh(c: Vec3) -> Vec3 {
    let l = lab(c);
    let m = l.length();
    let s = if m > 0.001 {
        (l.x / m).clamp(-1.0, 1.0).acos()
    } else {
        0.0
    };
    Vec3::new(m, s, if s > 0.001 { l.z.atan2(l.y) } else { 0.0 })
}

/// The hue an unsaturated colour of magnitude `m` takes on next to `saturated`.
fn spun(saturated: Vec3, m: f32) -> f32 {
    if saturated.x >= m - 0.1 {
        return saturated.z;
    }
    let spin = saturated.y * (m * m - saturated.x * saturated.x).sqrt()
        / (saturated.x * saturated.y.sin());
    if saturated.z > -std::f32::consts::FRAC_PI_3 {
        saturated.z + spin
    } else {
        saturated.z - spin
    }
}
