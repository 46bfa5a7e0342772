//! The built-in transfer functions.

use serde::{Deserialize, Serialize};

use super::{TransferFunction, file};
use crate::volume::{Grid, Statistics};

/// The built-in transfer functions, one file each in `assets/transfer_functions/`.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema, clap::ValueEnum,
)]
#[serde(rename_all = "snake_case")]
#[value(rename_all = "snake_case")]
pub enum Preset {
    /// Bone in CT (Hounsfield units).
    CtBone,
    /// Skin over bone in CT (Hounsfield units).
    CtSkinBone,
    /// Soft tissue in CT (Hounsfield units).
    CtSoftTissue,
    /// Magnetic resonance, relative to the histogram.
    Mri,
    /// Fluorescence microscopy, relative to the histogram.
    Fluorescence,
    /// Anything else, relative to the histogram.
    Generic,
}

macro_rules! asset {
    ($name:literal) => {
        include_str!(concat!(
            "../../../assets/transfer_functions/",
            $name,
            ".toml"
        ))
    };
}

impl Preset {
    /// All presets.
    pub const ALL: [Self; 6] = [
        Self::CtBone,
        Self::CtSkinBone,
        Self::CtSoftTissue,
        Self::Mri,
        Self::Fluorescence,
        Self::Generic,
    ];

    /// The name used in scene files and on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::CtBone => "ct_bone",
            Self::CtSkinBone => "ct_skin_bone",
            Self::CtSoftTissue => "ct_soft_tissue",
            Self::Mri => "mri",
            Self::Fluorescence => "fluorescence",
            Self::Generic => "generic",
        }
    }

    const fn text(self) -> &'static str {
        match self {
            Self::CtBone => asset!("ct_bone"),
            Self::CtSkinBone => asset!("ct_skin_bone"),
            Self::CtSoftTissue => asset!("ct_soft_tissue"),
            Self::Mri => asset!("mri"),
            Self::Fluorescence => asset!("fluorescence"),
            Self::Generic => asset!("generic"),
        }
    }

    /// The transfer function for a volume: absolute presets keep their data units, relative ones
    /// are stretched over the histogram's foreground. Transparent if the asset is broken, which a
    /// test excludes.
    #[must_use]
    pub fn transfer_function(self, grid: &Grid, statistics: &Statistics) -> TransferFunction {
        file::parse(self.text(), self.name(), grid, statistics).unwrap_or_else(|error| {
            TransferFunction {
                name: format!("{}: {error}", self.name()),
                points: Vec::new(),
                opacity_unit_distance: 1.0,
            }
        })
    }
}
