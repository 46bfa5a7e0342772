//! A machined part: solids combined by CSG.

use glam::{DVec2, DVec3};

use super::noise::smoothstep;

/// Value of the aluminium body.
const ALUMINIUM: f64 = 0.45;
/// Value of the steel bushing and screws.
const STEEL: f64 = 0.85;
/// Width of a material's edge: 2 voxels at 128^3, enough for smooth gradients.
const EDGE: f64 = 0.032;

/// Height of the flange's lower and upper face.
const FLANGE: (f64, f64) = (-0.62, -0.36);
/// Height of the hub's upper face.
const HUB_TOP: f64 = 0.42;
/// Radius of the hub.
const HUB_RADIUS: f64 = 0.43;
/// Inner and outer radius of the bushing.
const BUSHING: (f64, f64) = (0.17, 0.26);
/// Distance of the bolt holes from the axis.
const BOLT_CIRCLE: f64 = 0.66;
/// Directions of the six bolt holes, from +x in steps of 60 degrees, turned by 30.
const BOLTS: [DVec2; 6] = [
    DVec2::new(0.866_025_403_784_438_6, 0.5),
    DVec2::new(0.0, 1.0),
    DVec2::new(-0.866_025_403_784_438_6, 0.5),
    DVec2::new(-0.866_025_403_784_438_6, -0.5),
    DVec2::new(0.0, -1.0),
    DVec2::new(0.866_025_403_784_438_6, -0.5),
];
/// The bolt holes that hold a screw.
const SCREWS: [usize; 2] = [1, 3];
/// Directions of the three ribs, between bolt holes.
const RIBS: [DVec2; 3] = [
    DVec2::new(0.5, 0.866_025_403_784_438_6),
    DVec2::new(-1.0, 0.0),
    DVec2::new(0.5, -0.866_025_403_784_438_6),
];

/// A hub on a flange, axis along z: air 0, aluminium 0.45, steel 0.85, edges ramps 0.032 wide.
///
/// The aluminium body has a fillet between flange and hub, three ribs, six counterbored bolt
/// holes and an oil port at +y; a steel bushing lines the bore and two steel screws sit in the
/// bolt holes at +y and at -x -y. Three features tell a mirrored or turned picture: the bushing's
/// keyway at +x, an arrow engraved into the flange at +x that points to +y, and the screws.
/// As in a CT scan, the ramp from air to steel passes through aluminium's value.
pub(super) fn evaluate(p: DVec3) -> f64 {
    let radial = p.truncate().length();
    if radial > 0.9 || p.z < FLANGE.0 - 0.05 || p.z > HUB_TOP + 0.15 {
        return 0.0;
    }
    let aluminium = body(p, radial);
    let steel = bushing(p, radial).min(screws(p));
    let inside = |distance: f64| smoothstep(0.5 * EDGE, -0.5 * EDGE, distance);
    let base = ALUMINIUM * inside(aluminium.min(steel));
    base + (STEEL - base) * inside(steel)
}

/// Signed distance (bound) to the aluminium body.
fn body(p: DVec3, radial: f64) -> f64 {
    let flange = rounded_cylinder(radial, p.z, 0.86, FLANGE, 0.03);
    let hub = rounded_cylinder(radial, p.z, HUB_RADIUS, (FLANGE.0, HUB_TOP), 0.03);
    let solid = smooth_union(smooth_union(flange, hub, 0.12), ribs(p, radial), 0.05);
    let solid = smooth_union(solid, port_boss(p), 0.05);
    let bore = radial - BUSHING.1;
    let cuts = bore.min(bolt_holes(p)).min(port_hole(p)).min(arrow(p));
    solid.max(-cuts)
}

/// Three walls that slope from the hub down to the flange.
fn ribs(p: DVec3, radial: f64) -> f64 {
    let across = RIBS
        .iter()
        .map(|&d| {
            let along = d.dot(p.truncate());
            let side = d.perp_dot(p.truncate()).abs();
            (side - 0.065).max(-along)
        })
        .fold(f64::INFINITY, f64::min);
    // The slope's normal, (0.72, 0.694), is a unit vector.
    let slope = (radial - 0.84) * 0.72 + (p.z - FLANGE.1) * 0.694;
    let height = (FLANGE.0 - p.z).max(p.z - 0.28);
    across.max(slope).max(radial - 0.82).max(height)
}

/// A boss on the hub towards +y for the oil port.
fn port_boss(p: DVec3) -> f64 {
    let across = DVec2::new(p.x, p.z - 0.16).length() - 0.11;
    across.max(p.y - 0.56).max(-p.y)
}

fn port_hole(p: DVec3) -> f64 {
    let across = DVec2::new(p.x, p.z - 0.16).length() - 0.05;
    across.max(-p.y)
}

/// Through holes with a counterbore for the screws' heads.
fn bolt_holes(p: DVec3) -> f64 {
    let nearest = BOLTS
        .iter()
        .map(|&d| (p.truncate() - d * BOLT_CIRCLE).length_squared())
        .fold(f64::INFINITY, f64::min)
        .sqrt();
    let counterbore = (nearest - 0.115).max(FLANGE.1 - 0.07 - p.z);
    (nearest - 0.065).min(counterbore)
}

/// A groove 0.05 deep in the flange's upper face: a shaft and a triangular head.
fn arrow(p: DVec3) -> f64 {
    let (x, y) = (p.x - 0.66, p.y);
    let shaft = (x.abs() - 0.022).max((y + 0.05).abs() - 0.10);
    // A triangle with its tip at y = 0.16; the flanks' normals are (0.8, 0.6).
    let head = (0.8 * x.abs() + 0.6 * (y - 0.16)).max(0.03 - y);
    shaft.min(head).max(FLANGE.1 - 0.05 - p.z)
}

/// A tube that stands out of the hub, with a keyway at +x.
fn bushing(p: DVec3, radial: f64) -> f64 {
    let tube = rounded_cylinder(radial, p.z, BUSHING.1, (FLANGE.0, HUB_TOP + 0.08), 0.015);
    let keyway = (p.y.abs() - 0.055).max((p.x - 0.17).abs() - 0.055);
    tube.max(BUSHING.0 - radial).max(-keyway)
}

/// Hexagon socket head screws.
fn screws(p: DVec3) -> f64 {
    SCREWS
        .iter()
        .map(|&i| {
            let at = (p.truncate() - BOLTS[i] * BOLT_CIRCLE).abs();
            let radial = at.length();
            let bottom = FLANGE.1 - 0.07;
            let head = rounded_cylinder(radial, p.z, 0.10, (bottom, bottom + 0.13), 0.015);
            let shank = rounded_cylinder(radial, p.z, 0.065, (FLANGE.0 + 0.02, bottom), 0.01);
            let hexagon = at.y.max(0.866_025_403_784_438_6 * at.x + 0.5 * at.y) - 0.05;
            let socket = hexagon.max(bottom + 0.06 - p.z);
            head.min(shank).max(-socket)
        })
        .fold(f64::INFINITY, f64::min)
}

/// Signed distance to a cylinder about z between two heights with rounded edges.
fn rounded_cylinder(
    radial: f64,
    z: f64,
    radius: f64,
    (bottom, top): (f64, f64),
    rounding: f64,
) -> f64 {
    let (half, middle) = (0.5 * (top - bottom), 0.5 * (top + bottom));
    let d = DVec2::new(
        radial - radius + rounding,
        (z - middle).abs() - half + rounding,
    );
    d.max_element().min(0.0) + d.max(DVec2::ZERO).length() - rounding
}

/// Union with a fillet where the surfaces are closer than `fillet`.
fn smooth_union(a: f64, b: f64, fillet: f64) -> f64 {
    let overlap = (fillet - (a - b).abs()).max(0.0) / fillet;
    a.min(b) - overlap * overlap * fillet * 0.25
}
