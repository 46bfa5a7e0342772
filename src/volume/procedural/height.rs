//! Maps of heights from formulas.

use glam::{DVec3, UVec2};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::noise::{fbm, gradient_noise, ridged, smoothstep, vector_noise};
use crate::volume::{HeightMap, Rescale, Voxels};

/// The procedural maps of heights, over [-1, 1]^2.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum HeightFormula {
    /// A mountain with ridges and valleys in a plain.
    Terrain,
    /// The tops of a field of fair weather clouds; 0 in the clear air between them.
    CumulusField,
}

impl HeightFormula {
    /// The name used in scene files.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Terrain => "terrain",
            Self::CumulusField => "cumulus_field",
        }
    }

    /// The height at a place in [-1, 1]^2; in [0, 1].
    #[must_use]
    pub fn evaluate(self, x: f64, y: f64) -> f64 {
        match self {
            Self::Terrain => terrain(x, y),
            Self::CumulusField => cumulus_field(x, y),
        }
    }

    /// The heights at the centres of `resolution`^2 columns, 16 bits each.
    #[must_use]
    pub fn map(self, resolution: u32) -> HeightMap {
        let n = resolution.max(1) as usize;
        let centre = |i: usize| 2.0 * (i as f64 + 0.5) / n as f64 - 1.0;
        let height = |i: usize| {
            let height = self.evaluate(centre(i % n), centre(i / n));
            (height.clamp(0.0, 1.0) * 65535.0).round() as u16
        };
        HeightMap {
            name: self.name().to_owned(),
            dims: UVec2::splat(resolution.max(1)),
            voxels: Voxels::U16((0..n * n).into_par_iter().map(height).collect()),
            rescale: Rescale {
                slope: 1.0 / 65535.0,
                intercept: 0.0,
            },
            spacing: None,
            spatial_unit: None,
        }
    }
}

/// A cone with ridges that water has cut, and hills about it.
fn terrain(x: f64, y: f64) -> f64 {
    let p = DVec3::new(x, y, 0.37);
    let bent = p + 0.08 * vector_noise(1.7 * p, 5);
    let r = (bent.x - 0.08).hypot(bent.y + 0.05);
    let cone = 0.72 * (-2.6 * r).exp();
    let ridges = ridged(1.9 * bent, 8, 3);
    let hills = 0.5 + 0.5 * fbm(1.4 * bent, 7, 19);
    let flank = smoothstep(1.25, 0.1, r);
    0.02 + cone * (0.8 + 0.2 * ridges) + flank * 0.3 * ridges * ridges + 0.12 * hills * hills
}

/// Heaps where rising air makes clouds, rounded, with turrets on the larger ones.
fn cumulus_field(x: f64, y: f64) -> f64 {
    let p = DVec3::new(x, y, 0.61);
    let bent = p + 0.05 * vector_noise(3.0 * p, 41);
    let rising = 0.5 + 0.5 * fbm(2.1 * bent, 3, 7);
    let body = smoothstep(0.47, 0.78, rising);
    if body <= 0.0 {
        return 0.0;
    }
    // Half balls rather than cones: a heap's edge is steep.
    let heap = (body * (2.0 - body)).sqrt();
    let turrets = 1.0 - (1.5 * gradient_noise(7.0 * bent, 13).abs()).min(1.0);
    let puffs = 1.0 - (1.5 * gradient_noise(17.0 * bent, 29).abs()).min(1.0);
    heap * (0.55 + 0.3 * turrets * turrets + 0.15 * puffs * puffs)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heights_use_their_range_whatever_the_resolution() {
        for formula in [HeightFormula::Terrain, HeightFormula::CumulusField] {
            let map = formula.map(96);
            let heights: Vec<f64> = (0..96 * 96).map(|i| map.voxels.get(i) / 65535.0).collect();
            let highest = heights.iter().copied().fold(0.0, f64::max);
            assert!(
                (0.6..1.0).contains(&highest),
                "{}: {highest}",
                formula.name()
            );
            // Column 10, row 70, has the same centre as a column of three times as many.
            let fine = formula.map(288).voxels.get(31 + 288 * 211) / 65535.0;
            assert!((heights[10 + 96 * 70] - fine).abs() < 1e-4);
        }
        let clear = HeightFormula::CumulusField.map(64);
        let empty = (0..64 * 64).filter(|i| clear.voxels.get(*i) <= 0.0).count();
        assert!((64 * 16..64 * 56).contains(&empty), "{empty} of 4096 clear");
    }
}
