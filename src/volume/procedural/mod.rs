//! Volumes from formulas.

use serde::{Deserialize, Serialize};

use super::Volume;

/// The procedural volumes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Procedural {
    /// The Marschner-Lobb test signal [MarschnerLobb1994].
    MarschnerLobb,
    /// The 3D Shepp-Logan head phantom.
    SheppLogan,
    /// A shell with filaments around a dense core.
    Supernova,
    /// A cumulus-like cloud.
    Cloud,
    /// A machined part built from CSG solids.
    MechanicalPart,
}

impl Procedural {
    /// All procedural volumes.
    pub const ALL: [Self; 5] = [
        Self::MarschnerLobb,
        Self::SheppLogan,
        Self::Supernova,
        Self::Cloud,
        Self::MechanicalPart,
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
        }
    }

    /// Evaluates the formula on `resolution`^3 voxels.
    #[must_use]
    pub fn volume(self, resolution: u32) -> Volume {
        let _ = resolution;
        unimplemented!()
    }
}
