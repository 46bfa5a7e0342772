//! Choosing a transfer function from the data.

use super::{Preset, TransferFunction};
use crate::volume::{Space, Statistics, Volume};

/// Data values of air in Hounsfield units, with the noise of real scanners.
const AIR: (f64, f64) = (-1100.0, -850.0);

/// Chooses a transfer function from the histogram and the guessed modality; its name says why.
///
/// Values that reach from below -500 to bone, with a peak at air's -1000, are Hounsfield units;
/// other data in a patient's space are taken for MRI; the rest is generic.
#[must_use]
pub fn automatic(volume: &Volume, statistics: &Statistics) -> TransferFunction {
    let s = statistics;
    let range = format!("{} ... {}", s.min, s.max);
    let air = s.share(AIR.0, AIR.1);
    let (preset, why) = if s.min <= -500.0 && (300.0..10_000.0).contains(&s.max) && air > 0.02 {
        if air > 0.3 {
            (
                Preset::CtSkinBone,
                format!("Hounsfield units ({range}) with much air around"),
            )
        } else {
            (Preset::CtBone, format!("Hounsfield units ({range})"))
        }
    } else if volume.grid.space == Space::PatientRas && s.background_share() < 0.9 {
        (
            Preset::Mri,
            format!("patient's axes, no Hounsfield units ({range})"),
        )
    } else {
        (Preset::Generic, format!("no modality recognised ({range})"))
    };
    let mut tf = preset.transfer_function(&volume.grid, statistics);
    tf.name = format!("automatic: {}, {why}", preset.name());
    tf
}
