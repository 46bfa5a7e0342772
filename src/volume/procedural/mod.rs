//! Volumes from formulas, at any resolution and without a file.
//!
//! Each is a pure function over the box [-1, 1]^3, z up, with values in [0, 1].

mod cloud;
mod height;
mod marschner_lobb;
mod mechanical_part;
mod noise;
mod shepp_logan;
mod supernova;

pub use height::HeightFormula;

use glam::{DVec3, UVec3};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::{Grid, Rescale, Volume, Voxels};

/// The largest stored value, for data value 1.
const U16_MAX: f64 = 65535.0;

/// The procedural volumes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Procedural {
    /// The Marschner-Lobb test signal `[MarschnerLobb1994]`.
    MarschnerLobb,
    /// The 3D Shepp-Logan head phantom.
    SheppLogan,
    /// A shell with filaments around a dense core.
    Supernova,
    /// A cumulus-like cloud.
    Cloud,
    /// A machined part built from CSG solids.
    MechanicalPart,
    /// The coarse body of a cloud, to be given detail by noise.
    Cumulus,
}

impl Procedural {
    /// All procedural volumes.
    pub const ALL: [Self; 6] = [
        Self::MarschnerLobb,
        Self::SheppLogan,
        Self::Supernova,
        Self::Cloud,
        Self::MechanicalPart,
        Self::Cumulus,
    ];

    /// The name used in scene files and on the command line (`snake_case`).
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::MarschnerLobb => "marschner_lobb",
            Self::SheppLogan => "shepp_logan",
            Self::Supernova => "supernova",
            Self::Cloud => "cloud",
            Self::MechanicalPart => "mechanical_part",
            Self::Cumulus => "cumulus",
        }
    }

    /// The formula at a world position in [-1, 1]^3 (z up); in [0, 1]. Pure: the same position
    /// gives the same value, whatever the resolution of a volume made from it.
    #[must_use]
    pub fn evaluate(self, p: DVec3) -> f64 {
        match self {
            Self::MarschnerLobb => marschner_lobb::evaluate(p),
            Self::SheppLogan => shepp_logan::evaluate(p),
            Self::Supernova => supernova::evaluate(p),
            Self::Cloud => cloud::evaluate(p),
            Self::MechanicalPart => mechanical_part::evaluate(p),
            Self::Cumulus => cloud::coarse(p),
        }
    }

    /// [`Self::evaluate`] at the centres of `resolution`^3 voxels (0 is taken as 1) that fill the
    /// box [-1, 1]^3: voxel `i` of `n` is at `2 (i + 1/2) / n - 1`.
    ///
    /// Stored as u16 with a rescale to [0, 1]; the Marschner-Lobb signal, whose purpose is to
    /// measure reconstruction, as f32.
    ///
    /// # Panics
    /// If the voxels do not fit into the address space.
    #[must_use]
    pub fn volume(self, resolution: u32) -> Volume {
        self.volume_of(UVec3::splat(resolution))
    }

    /// As [`Self::volume`] on a grid of any `dims`: the formula's box is stretched over it, voxel `i` of
    /// the `n` along an axis being at `2 (i + 1/2) / n - 1`. Voxels are cubes, and the longest side is 2.
    ///
    /// # Panics
    /// If the voxels do not fit into the address space.
    #[must_use]
    pub fn volume_of(self, dims: UVec3) -> Volume {
        let dims = dims.max(UVec3::ONE);
        let (voxels, rescale) = match self {
            Self::MarschnerLobb => {
                let voxels = Voxels::F32(sample(dims, |p| self.evaluate(p) as f32));
                (voxels, Rescale::IDENTITY)
            }
            _ => {
                let quantised = |p| (self.evaluate(p) * U16_MAX).round() as u16;
                let rescale = Rescale {
                    slope: 1.0 / U16_MAX,
                    intercept: 0.0,
                };
                (Voxels::U16(sample(dims, quantised)), rescale)
            }
        };
        Volume {
            name: self.name().to_owned(),
            grid: Grid::centred(dims, DVec3::splat(2.0 / f64::from(dims.max_element()))),
            voxels,
            rescale,
            spatial_unit: None,
            height_field: None,
        }
    }
}

/// A value for every voxel of a grid over [-1, 1]^3, in storage order.
fn sample<T>(dims: UVec3, value: impl Fn(DVec3) -> T + Sync) -> Vec<T>
where
    T: Copy + Default + Send,
{
    let [nx, ny, nz] = dims.to_array().map(|n| n as usize);
    let count = nx.saturating_mul(ny).saturating_mul(nz);
    let centre = |i: usize, n: usize| 2.0 * (i as f64 + 0.5) / n as f64 - 1.0;
    let mut voxels = vec![T::default(); count];
    voxels.par_chunks_mut(nx).enumerate().for_each(|(i, row)| {
        let (y, z) = (centre(i % ny, ny), centre(i / ny, nz));
        for (x, voxel) in row.iter_mut().enumerate() {
            *voxel = value(DVec3::new(centre(x, nx), y, z));
        }
    });
    voxels
}
