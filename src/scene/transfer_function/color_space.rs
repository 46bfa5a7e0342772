//! The colour spaces in which colour-map files interpolate, and their way to linear RGB.
//!
//! All start from sRGB-encoded control points. Lab is CIELAB under D65; Msh is its polar form
//! `[Moreland2009]`, in which diverging maps go through a bright, unsaturated middle.

use glam::{DMat3, DVec3};

use super::nodes::Nodes;

/// Straight pieces that a whole map may be cut into, shared by its segments.
const PIECES: usize = 256;
/// Most pieces of one segment.
const PIECES_PER_SEGMENT: usize = 64;

/// D65, as VTK has it.
const WHITE: DVec3 = DVec3::new(0.9505, 1.0, 1.089);

/// Below this saturation a colour has no hue `[Moreland2009]`.
const UNSATURATED: f64 = 0.05;

/// `ColorSpace` of a colour-map file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ColorSpace {
    /// Straight in encoded sRGB.
    Rgb,
    /// Hue, saturation, value; `wrap` takes the shorter way around the hue circle.
    Hsv { wrap: bool },
    /// CIELAB.
    Lab,
    /// Msh with white between two saturated ends of different hue.
    Diverging,
    /// Every interval has the colour of its upper end.
    Step,
}

impl ColorSpace {
    /// The space that a file names; `None` for an unknown word.
    pub(super) fn from_name(name: &str, wrap: bool) -> Option<Self> {
        match name.to_ascii_lowercase().as_str() {
            "rgb" => Some(Self::Rgb),
            "hsv" => Some(Self::Hsv { wrap }),
            // A path of constant CIEDE2000 speed keeps close to the straight one in Lab.
            "lab" | "cielab" | "lab/ciede2000" => Some(Self::Lab),
            "diverging" => Some(Self::Diverging),
            "step" => Some(Self::Step),
            _ => None,
        }
    }

    /// The curve through sRGB-encoded `nodes` (ascending) as straight pieces in linear RGB.
    pub(super) fn linear_nodes(self, nodes: &[(f64, DVec3)]) -> Nodes<DVec3> {
        let pieces = (PIECES / nodes.len().max(1)).clamp(1, PIECES_PER_SEGMENT);
        let mut linear = Vec::with_capacity(nodes.len() * 2);
        for pair in nodes.windows(2) {
            let ((a, from), (b, to)) = (pair[0], pair[1]);
            linear.push((a, linear_from_encoded(from)));
            if from == to || a == b {
                continue;
            }
            if self == Self::Step {
                linear.push((a, linear_from_encoded(to)));
                continue;
            }
            linear.extend((1..pieces).map(|i| {
                let s = i as f64 / pieces as f64;
                (a + s * (b - a), linear_from_encoded(self.mix(from, to, s)))
            }));
        }
        if let Some(&(value, color)) = nodes.last() {
            linear.push((value, linear_from_encoded(color)));
        }
        linear
    }

    /// The encoded colour at `s` in [0, 1] between two encoded colours.
    fn mix(self, from: DVec3, to: DVec3, s: f64) -> DVec3 {
        let mixed = match self {
            Self::Rgb => from.lerp(to, s),
            Self::Hsv { wrap } => mix_hsv(from, to, s, wrap),
            Self::Lab => encoded_from_lab(lab_from_encoded(from).lerp(lab_from_encoded(to), s)),
            Self::Diverging => mix_diverging(from, to, s),
            Self::Step => to,
        };
        // A straight line in Lab can leave the gamut of sRGB.
        mixed.clamp(DVec3::ZERO, DVec3::ONE)
    }
}

/// Linear RGB of an sRGB-encoded colour.
pub(super) fn linear_from_encoded(encoded: DVec3) -> DVec3 {
    map(encoded, |v| {
        if v <= 0.04045 {
            v / 12.92
        } else {
            ((v + 0.055) / 1.055).powf(2.4)
        }
    })
}

fn encoded_from_linear(linear: DVec3) -> DVec3 {
    map(linear, |v| {
        if v <= 0.003_130_8 {
            v * 12.92
        } else {
            1.055 * v.powf(1.0 / 2.4) - 0.055
        }
    })
}

fn map(v: DVec3, f: impl Fn(f64) -> f64) -> DVec3 {
    DVec3::new(f(v.x), f(v.y), f(v.z))
}

fn mix_hsv(from: DVec3, to: DVec3, s: f64, wrap: bool) -> DVec3 {
    let (mut a, mut b) = (hsv_from_rgb(from), hsv_from_rgb(to));
    if wrap && (a.x - b.x).abs() > 0.5 {
        if a.x > b.x {
            a.x -= 1.0;
        } else {
            b.x -= 1.0;
        }
    }
    rgb_from_hsv(a.lerp(b, s))
}

/// Hue in turns, saturation and value in [0, 1].
fn hsv_from_rgb(rgb: DVec3) -> DVec3 {
    let (low, high) = (rgb.min_element(), rgb.max_element());
    let chroma = high - low;
    if chroma <= 0.0 {
        return DVec3::new(0.0, 0.0, high);
    }
    let sextant = if high == rgb.x {
        (rgb.y - rgb.z) / chroma
    } else if high == rgb.y {
        2.0 + (rgb.z - rgb.x) / chroma
    } else {
        4.0 + (rgb.x - rgb.y) / chroma
    };
    DVec3::new((sextant / 6.0).rem_euclid(1.0), chroma / high, high)
}

fn rgb_from_hsv(hsv: DVec3) -> DVec3 {
    let ramp = |offset: f64| {
        let k = (hsv.x * 6.0 + offset).rem_euclid(6.0);
        hsv.z - hsv.z * hsv.y * k.min(4.0 - k).clamp(0.0, 1.0)
    };
    DVec3::new(ramp(5.0), ramp(3.0), ramp(1.0))
}

/// XYZ of linear RGB with sRGB primaries (IEC 61966-2-1), columns red, green, blue.
const XYZ_FROM_RGB: DMat3 = DMat3::from_cols(
    DVec3::new(0.4124, 0.2126, 0.0193),
    DVec3::new(0.3576, 0.7152, 0.1192),
    DVec3::new(0.1805, 0.0722, 0.9505),
);

fn lab_from_encoded(encoded: DVec3) -> DVec3 {
    let f = map(XYZ_FROM_RGB * linear_from_encoded(encoded) / WHITE, |t| {
        if t > 0.008_856 {
            t.cbrt()
        } else {
            7.787 * t + 16.0 / 116.0
        }
    });
    DVec3::new(116.0 * f.y - 16.0, 500.0 * (f.x - f.y), 200.0 * (f.y - f.z))
}

fn encoded_from_lab(lab: DVec3) -> DVec3 {
    let y = (lab.x + 16.0) / 116.0;
    let f = DVec3::new(lab.y / 500.0 + y, y, y - lab.z / 200.0);
    let xyz = map(f, |t| {
        let cube = t * t * t;
        if cube > 0.008_856 {
            cube
        } else {
            (t - 16.0 / 116.0) / 7.787
        }
    }) * WHITE;
    let linear = XYZ_FROM_RGB.inverse() * xyz;
    encoded_from_linear(linear.max(DVec3::ZERO))
}

/// Magnitude, saturation angle, hue angle.
fn msh_from_lab(lab: DVec3) -> DVec3 {
    let magnitude = lab.length();
    let saturation = if magnitude > 0.001 {
        (lab.x / magnitude).clamp(-1.0, 1.0).acos()
    } else {
        0.0
    };
    let hue = if saturation > 0.001 {
        lab.z.atan2(lab.y)
    } else {
        0.0
    };
    DVec3::new(magnitude, saturation, hue)
}

fn lab_from_msh(msh: DVec3) -> DVec3 {
    let chroma = msh.x * msh.y.sin();
    DVec3::new(
        msh.x * msh.y.cos(),
        chroma * msh.z.cos(),
        chroma * msh.z.sin(),
    )
}

/// The interpolation of diverging colour maps `[Moreland2009, Fig. 8]`.
fn mix_diverging(from: DVec3, to: DVec3, s: f64) -> DVec3 {
    let mut a = msh_from_lab(lab_from_encoded(from));
    let mut b = msh_from_lab(lab_from_encoded(to));
    let mut s = s;
    let turn = (a.z - b.z).abs();
    let hue_difference = turn.min(std::f64::consts::TAU - turn);
    if a.y > UNSATURATED && b.y > UNSATURATED && hue_difference > std::f64::consts::FRAC_PI_3 {
        let middle = DVec3::new(a.x.max(b.x).max(88.0), 0.0, 0.0);
        if s < 0.5 {
            b = middle;
            s *= 2.0;
        } else {
            a = middle;
            s = 2.0 * s - 1.0;
        }
    }
    if a.y < UNSATURATED && b.y > UNSATURATED {
        a.z = adjusted_hue(b, a.x);
    } else if b.y < UNSATURATED && a.y > UNSATURATED {
        b.z = adjusted_hue(a, b.x);
    }
    encoded_from_lab(lab_from_msh(a.lerp(b, s)))
}

/// A hue for the unsaturated end that keeps the perceived hue of the saturated one constant.
fn adjusted_hue(saturated: DVec3, unsaturated_magnitude: f64) -> f64 {
    if saturated.x >= unsaturated_magnitude - 0.1 {
        return saturated.z;
    }
    let spin = saturated.y * (unsaturated_magnitude.powi(2) - saturated.x.powi(2)).sqrt()
        / (saturated.x * saturated.y.sin());
    // Away from purple.
    if saturated.z > -0.3 * std::f64::consts::PI {
        saturated.z + spin
    } else {
        saturated.z - spin
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BLUE: DVec3 = DVec3::new(0.23, 0.299, 0.754);
    const RED: DVec3 = DVec3::new(0.706, 0.016, 0.15);

    fn assert_mix(space: ColorSpace, from: DVec3, s: f64, expected: [f64; 3]) {
        let mixed = space.mix(from, RED, s);
        let difference = (mixed - DVec3::from(expected)).abs().max_element();
        assert!(difference < 5e-4, "{space:?} at {s}: {mixed}");
    }

    /// Values by VTK 9's `vtkColorTransferFunction` between the same two colours.
    #[test]
    fn agrees_with_vtk() {
        assert_mix(ColorSpace::Rgb, BLUE, 0.25, [0.349, 0.22825, 0.603]);
        let hsv = ColorSpace::Hsv { wrap: true };
        assert_mix(hsv, BLUE, 0.25, [0.3743, 0.17396, 0.742]);
        assert_mix(hsv, BLUE, 0.75, [0.718, 0.06696, 0.50874]);
        assert_mix(ColorSpace::Lab, BLUE, 0.25, [0.46652, 0.25393, 0.59617]);
        assert_mix(ColorSpace::Lab, BLUE, 0.75, [0.65395, 0.13918, 0.29694]);
        let diverging = ColorSpace::Diverging;
        assert_mix(diverging, BLUE, 0.25, [0.55319, 0.68904, 0.99544]);
        assert_mix(diverging, BLUE, 0.5, [0.8654, 0.86541, 0.8654]);
        assert_mix(diverging, BLUE, 0.75, [0.95827, 0.60301, 0.48193]);
        let gray = DVec3::splat(0.1);
        assert_mix(diverging, gray, 0.5, [0.49279, 0.30185, 0.28651]);
    }

    #[test]
    fn every_space_returns_its_ends() {
        for name in ["RGB", "HSV", "Lab", "CIELAB", "Diverging", "Step"] {
            let space = ColorSpace::from_name(name, true).unwrap_or(ColorSpace::Rgb);
            let nodes = space.linear_nodes(&[(0.0, BLUE), (2.0, RED)]);
            assert_eq!(nodes.first(), Some(&(0.0, linear_from_encoded(BLUE))));
            assert_eq!(nodes.last(), Some(&(2.0, linear_from_encoded(RED))));
        }
        assert_eq!(ColorSpace::from_name("Oklab", true), None);
    }

    #[test]
    fn lab_of_white_and_hsv_of_primaries() {
        let white = lab_from_encoded(DVec3::ONE);
        assert!((white - DVec3::new(100.0, 0.0, 0.0)).abs().max_element() < 0.02);
        assert_eq!(hsv_from_rgb(DVec3::Y), DVec3::new(1.0 / 3.0, 1.0, 1.0));
        assert_eq!(
            rgb_from_hsv(DVec3::new(0.5, 1.0, 1.0)),
            DVec3::new(0.0, 1.0, 1.0)
        );
    }
}
