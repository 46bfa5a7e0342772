//! The built-in transfer functions.

use serde::{Deserialize, Serialize};

use super::definition::Definition;
use super::{Quantity, TransferFunction, TransferFunctionError};
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
    /// Land, by the height: from lowlands to snow, over the whole range.
    Terrain,
    /// Anything else, relative to the histogram.
    Generic,
}

impl Preset {
    /// All presets, in order of declaration.
    pub const ALL: [Self; 7] = [
        Self::CtBone,
        Self::CtSkinBone,
        Self::CtSoftTissue,
        Self::Mri,
        Self::Fluorescence,
        Self::Terrain,
        Self::Generic,
    ];

    /// The name used in scene files and on the command line, and the file's in `assets/`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::CtBone => "ct_bone",
            Self::CtSkinBone => "ct_skin_bone",
            Self::CtSoftTissue => "ct_soft_tissue",
            Self::Mri => "mri",
            Self::Fluorescence => "fluorescence",
            Self::Terrain => "terrain",
            Self::Generic => "generic",
        }
    }

    /// What it shows, a sentence or two.
    #[must_use]
    pub fn description(self) -> String {
        Definition::parse(self.text()).map_or_else(|_| String::new(), |d| d.description)
    }

    /// The transfer function for a volume: absolute presets keep their data units (Hounsfield units
    /// and millimetres), relative ones are stretched over the volume's histogram, from the upper
    /// foot of the background's peak to the bright end of the foreground, with an
    /// `opacity_unit_distance` that is a share of the grid's diagonal.
    ///
    /// Empty (fully transparent) where the grid has no finite diagonal.
    #[must_use]
    pub fn transfer_function(self, grid: &Grid, statistics: &Statistics) -> TransferFunction {
        // The files are part of the program and a test resolves each: only an impossible grid or
        // range gets to the empty function.
        self.resolve(grid, statistics)
            .unwrap_or_else(|_| TransferFunction {
                name: self.name().to_owned(),
                points: Vec::new(),
                quantity: Quantity::Opacity,
                primitives: Vec::new(),
                opacity_unit_distance: 1.0,
            })
    }

    fn resolve(
        self,
        grid: &Grid,
        statistics: &Statistics,
    ) -> Result<TransferFunction, TransferFunctionError> {
        Definition::parse(self.text())
            .map_err(|message| TransferFunctionError::new(self.name(), message))?
            .resolve(self.name(), grid, statistics)
    }

    const fn text(self) -> &'static str {
        match self {
            Self::CtBone => include_str!("../../../assets/transfer_functions/ct_bone.toml"),
            Self::CtSkinBone => {
                include_str!("../../../assets/transfer_functions/ct_skin_bone.toml")
            }
            Self::CtSoftTissue => {
                include_str!("../../../assets/transfer_functions/ct_soft_tissue.toml")
            }
            Self::Mri => include_str!("../../../assets/transfer_functions/mri.toml"),
            Self::Fluorescence => {
                include_str!("../../../assets/transfer_functions/fluorescence.toml")
            }
            Self::Terrain => include_str!("../../../assets/transfer_functions/terrain.toml"),
            Self::Generic => include_str!("../../../assets/transfer_functions/generic.toml"),
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use clap::ValueEnum;
    use glam::{DVec3, UVec3};

    #[test]
    fn every_file_parses_and_is_described() {
        let grid = Grid::centred(UVec3::splat(4), DVec3::ONE);
        let volume = crate::volume::Volume {
            name: "ramp".to_owned(),
            grid,
            voxels: crate::volume::Voxels::U8((0..64).collect()),
            rescale: crate::volume::Rescale::IDENTITY,
            spatial_unit: None,
            height_field: None,
        };
        let statistics = Statistics::of(&volume);
        for preset in Preset::ALL {
            assert!(!preset.description().is_empty(), "{}", preset.name());
            let function = preset.resolve(&grid, &statistics).unwrap();
            assert!(function.points.len() > 2, "{}", preset.name());
        }
    }

    #[test]
    fn names_are_those_of_the_command_line() {
        assert_eq!(Preset::value_variants(), Preset::ALL);
        for preset in Preset::ALL {
            let value = preset.to_possible_value().unwrap();
            assert_eq!(value.get_name(), preset.name());
        }
    }
}
