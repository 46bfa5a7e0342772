//! Tables against independent values with standard errors.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::TableError;

/// Largest deviation of a point, in standard errors.
pub const MAX_Z: f64 = 4.0;
/// Radiance that a few million analog paths cannot see, as no path happens to bring it: a point's standard
/// error says nothing of it.
pub const UNSEEN: f64 = 1e-8;
/// Bytes of a file of points, at most.
const MAX_BYTES: u64 = 1 << 24;

/// An entry's independently known value.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
pub struct Point {
    /// Single-scattering albedo, 0 to 1.
    pub albedo: f64,
    /// Mean cosine of the phase function.
    pub g: f64,
    /// Extinction times radius.
    pub sigma_t: f64,
    /// Angle to the light, radians.
    pub theta: f64,
    /// Radiance, 1 / sr.
    #[serde(rename = "Lo")]
    pub radiance: f64,
    /// Its standard error; 0 if it is exact.
    #[serde(rename = "stderr")]
    pub standard_error: f64,
}

#[derive(Deserialize)]
struct Points {
    points: Vec<Point>,
}

/// A point beside what a table says.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// The point.
    pub point: Point,
    /// The table's radiance and standard error, 1 / sr.
    pub found: [f64; 2],
    /// Their difference in standard errors.
    pub z: f64,
}

/// Reads `{"points": [{"albedo", "g", "sigma_t", "theta", "Lo", "stderr"}, ...]}`.
///
/// # Errors
/// A file that cannot be read or is not that.
pub fn read(path: &Path) -> Result<Vec<Point>, TableError> {
    let failed = |e| TableError::io(path, "read", e);
    let bytes = std::fs::metadata(path).map_err(failed)?.len();
    if bytes > MAX_BYTES {
        let (found, expected) = (format!("{bytes} bytes"), format!("at most {MAX_BYTES}"));
        return Err(TableError::content(path, "the size", found, expected));
    }
    let text = std::fs::read_to_string(path).map_err(failed)?;
    let points: Points = serde_json::from_str(&text).map_err(|e| {
        TableError::content(
            path,
            "the list of points",
            e.to_string(),
            "points with albedo, g, sigma_t, theta, Lo, stderr",
        )
    })?;
    let within = |p: &Point| {
        (0.0..=1.0).contains(&p.albedo)
            && (-0.99..=0.99).contains(&p.g)
            && p.sigma_t >= 0.0
            && p.sigma_t.is_finite()
            && (0.0..=std::f64::consts::PI + 1e-6).contains(&p.theta)
            && p.radiance.is_finite()
            && p.standard_error >= 0.0
    };
    match points.points.iter().find(|p| !within(p)) {
        Some(point) => {
            let expected =
                "albedo 0 to 1, g -0.99 to 0.99, sigma_t and stderr 0 or more, theta 0 to pi";
            Err(TableError::content(
                path,
                "a point",
                format!("{point:?}"),
                expected,
            ))
        }
        None => Ok(points.points),
    }
}

/// Compares; `table(point)` gives radiance and standard error.
#[must_use]
pub fn compare(points: &[Point], table: impl Fn(&Point) -> [f64; 2]) -> Vec<Comparison> {
    let one = |point: &Point| {
        let found = table(point);
        let difference = found[0] - point.radiance;
        // Exact values are compared as 32-bit numbers are.
        let rounding = 1e-6 * point.radiance;
        let uncertain = [found[1], point.standard_error, rounding];
        let unseen = if point.standard_error > 0.0 {
            UNSEEN
        } else {
            0.0
        };
        let error = uncertain
            .iter()
            .fold(unseen * unseen, |sum, e| sum + e * e)
            .sqrt();
        Comparison {
            point: *point,
            found,
            z: if difference == 0.0 {
                0.0
            } else {
                difference / error
            },
        }
    };
    points.iter().map(one).collect()
}

/// Sum of squares, and the largest that 999 of 1000 sets of so many points stay below.
#[must_use]
pub fn chi_squared(comparisons: &[Comparison]) -> [f64; 2] {
    let sum = comparisons.iter().map(|c| c.z * c.z).sum();
    let count = comparisons.len() as f64;
    // [Wilson1931]'s cube root.
    let spread = 2.0 / (9.0 * count.max(1.0));
    [sum, count * (1.0 - spread + 3.09 * spread.sqrt()).powi(3)]
}

/// Whether every point and all together agree.
#[must_use]
pub fn agrees(comparisons: &[Comparison]) -> bool {
    let [sum, limit] = chi_squared(comparisons);
    comparisons.iter().all(|c| c.z.abs() < MAX_Z) && sum <= limit
}
