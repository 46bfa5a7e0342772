//! A cumulus-like cloud.

use glam::DVec3;

use super::noise::{billow, gradient_noise, smoothstep, vector_noise};

/// Centre and radius of the balls whose blend is the cloud's body: a broad foot, a tower leaning
/// to +x and smaller turrets.
const BALLS: [(DVec3, f64); 13] = [
    (DVec3::new(-0.44, -0.06, -0.28), 0.33),
    (DVec3::new(-0.08, 0.20, -0.24), 0.40),
    (DVec3::new(0.32, -0.04, -0.26), 0.38),
    (DVec3::new(0.62, 0.16, -0.36), 0.24),
    (DVec3::new(-0.68, 0.14, -0.38), 0.20),
    (DVec3::new(0.04, -0.36, -0.30), 0.30),
    (DVec3::new(0.44, -0.36, -0.40), 0.20),
    (DVec3::new(0.10, 0.04, 0.08), 0.38),
    (DVec3::new(0.20, 0.10, 0.34), 0.32),
    (DVec3::new(0.02, 0.00, 0.40), 0.24),
    (DVec3::new(0.26, 0.04, 0.56), 0.23),
    (DVec3::new(-0.30, -0.06, 0.04), 0.25),
    (DVec3::new(-0.34, 0.22, -0.02), 0.22),
];

/// Over this distance the balls melt into each other.
const BLEND: f64 = 0.06;
/// Height of the flat base.
const BASE: f64 = -0.50;
/// Furthest that the billows carry the surface out of the body, and in.
const BULGE: f64 = 0.14;
/// Furthest that the noise moves a point before the body is looked up; three noises of at most
/// 1.04 are 1.8 long.
const BEND: f64 = 0.126;
/// Depth over which the density rises to its inner value.
const EDGE: f64 = 0.05;

/// Density, in [0, 1]: 0 outside, a rise over 0.05 units at the billowed surface, 0.6 to 1 inside,
/// densest in the core and the upper tower. The base is flat, at z = -0.5; the box's faces are
/// in clear air.
pub(super) fn evaluate(p: DVec3) -> f64 {
    // No billow reaches beyond BULGE, so most of the box costs no noise.
    if p.z < BASE || body(p) > BULGE + BEND {
        return 0.0;
    }
    let bent = p + vector_noise(p * 2.3, 11) * (BEND / 1.8);
    let depth = BULGE - body(bent);
    if depth < 0.0 {
        return 0.0;
    }
    let surface = depth - 2.0 * BULGE * (1.0 - billow(bent * 3.4, 5, 37));
    let skin = smoothstep(0.0, EDGE, surface);
    if skin == 0.0 {
        return 0.0;
    }
    let core = smoothstep(0.0, 0.45, surface);
    let variation = 0.5 + 0.5 * gradient_noise(p * 4.0, 23).clamp(-1.0, 1.0);
    let floor = smoothstep(BASE, BASE + 0.07, p.z);
    skin * floor * (0.55 + 0.3 * core + 0.15 * variation)
}

/// Density, in [0, 1], of the cloud's body without the detail: a blend of balls that rises over 0.3 units from 0 to
/// 1, as coarse as a cloud is modelled where noise is to do the rest `[Kniss2003, Fig. 10]`.
pub(super) fn coarse(p: DVec3) -> f64 {
    smoothstep(-0.1, 0.2, -body(p)) * smoothstep(BASE - 0.05, BASE + 0.1, p.z)
}

/// Signed distance (negative inside) to the smoothly blended balls.
fn body(p: DVec3) -> f64 {
    BALLS
        .iter()
        .map(|&(centre, radius)| p.distance(centre) - radius)
        .fold(f64::INFINITY, |a, b| {
            let overlap = (BLEND - (a - b).abs()).max(0.0) / BLEND;
            a.min(b) - overlap * overlap * BLEND * 0.25
        })
}
