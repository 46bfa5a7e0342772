//! The 3D Shepp-Logan head phantom.

use glam::DVec3;

/// One ellipsoid of the phantom.
struct Ellipsoid {
    /// Added to the value inside.
    value: f64,
    centre: DVec3,
    /// Inverse squares of the half axes.
    inverse_squares: DVec3,
    /// Cosine and sine of the rotation about z.
    rotation: (f64, f64),
}

const COS_18: f64 = 0.951_056_516_295_153_5;
const SIN_18: f64 = 0.309_016_994_374_947_45;
const UPRIGHT: (f64, f64) = (1.0, 0.0);
const BY_72: (f64, f64) = (SIN_18, COS_18);
const BY_90: (f64, f64) = (0.0, 1.0);
const BY_108: (f64, f64) = (-SIN_18, COS_18);

const fn ellipsoid(
    value: f64,
    [a, b, c]: [f64; 3],
    [x, y, z]: [f64; 3],
    rotation: (f64, f64),
) -> Ellipsoid {
    Ellipsoid {
        value,
        centre: DVec3::new(x, y, z),
        inverse_squares: DVec3::new(1.0 / (a * a), 1.0 / (b * b), 1.0 / (c * c)),
        rotation,
    }
}

/// Skull, brain, two ventricles, a large tumour, five small ones. In tenths, so that the sums of
/// overlapping ellipsoids are exact.
const ELLIPSOIDS: [Ellipsoid; 10] = [
    ellipsoid(10.0, [0.69, 0.92, 0.9], [0.0, 0.0, 0.0], UPRIGHT),
    ellipsoid(-8.0, [0.6624, 0.874, 0.88], [0.0, 0.0, 0.0], UPRIGHT),
    ellipsoid(-2.0, [0.41, 0.16, 0.21], [-0.22, 0.0, -0.25], BY_108),
    ellipsoid(-2.0, [0.31, 0.11, 0.22], [0.22, 0.0, -0.25], BY_72),
    ellipsoid(2.0, [0.21, 0.25, 0.5], [0.0, 0.35, -0.25], UPRIGHT),
    ellipsoid(2.0, [0.046, 0.046, 0.046], [0.0, 0.1, -0.25], UPRIGHT),
    ellipsoid(1.0, [0.046, 0.023, 0.02], [-0.08, -0.65, -0.25], UPRIGHT),
    ellipsoid(1.0, [0.046, 0.023, 0.02], [0.06, -0.65, -0.25], BY_90),
    ellipsoid(2.0, [0.056, 0.04, 0.1], [0.06, -0.105, 0.625], BY_90),
    ellipsoid(-2.0, [0.056, 0.056, 0.1], [0.0, 0.1, 0.625], UPRIGHT),
];

/// The sum of ten ellipsoids: outside 0, skull 1, brain 0.2, ventricles 0, tumours 0.3 and 0.4.
///
/// The ellipsoids are those of A. C. Kak and M. Slaney, Principles of Computerized Tomographic
/// Imaging, 1988, p. 102, where tissues differ by 1 % of the skull's value. The values here are
/// those of the usual high-contrast phantom: P. Toft's (The Radon Transform, 1996), in 3D by
/// H. Yu, Y. Ye and G. Wang, Katsevich-Type Algorithms for Variable Radius Spiral Cone-Beam CT,
/// SPIE 5535, 2004. x is to the side, y to the face, z to the top of the head. Each ellipsoid is
/// turned about its own centre. Edges are sharp, as the phantom demands.
pub(super) fn evaluate(p: DVec3) -> f64 {
    let tenths: f64 = ELLIPSOIDS
        .iter()
        .filter(|e| e.contains(p))
        .map(|e| e.value)
        .sum();
    tenths / 10.0
}

impl Ellipsoid {
    fn contains(&self, p: DVec3) -> bool {
        let d = p - self.centre;
        let (cos, sin) = self.rotation;
        let along = DVec3::new(cos * d.x + sin * d.y, cos * d.y - sin * d.x, d.z);
        (along * along).dot(self.inverse_squares) <= 1.0
    }
}
