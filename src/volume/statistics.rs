//! What is in a volume: range, histogram, non-finite voxels.

use serde::Serialize;

use super::Volume;

/// Statistics of the finite data values (rescaled) of a volume.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Statistics {
    /// Smallest finite data value; 0 if there is none.
    pub min: f64,
    /// Largest finite data value; 0 if there is none.
    pub max: f64,
    /// Mean of the finite data values.
    pub mean: f64,
    /// Number of NaN voxels.
    pub nan: u64,
    /// Number of infinite voxels.
    pub infinite: u64,
    /// Voxel counts in equal bins from `min` to `max`.
    pub histogram: Vec<u64>,
}

impl Statistics {
    /// Bins of the histogram.
    pub const BINS: usize = 1024;

    /// Gathers the statistics of a volume.
    #[must_use]
    pub fn of(_volume: &Volume) -> Self {
        Self {
            min: 0.0,
            max: 0.0,
            mean: 0.0,
            nan: 0,
            infinite: 0,
            histogram: vec![0; Self::BINS],
        }
    }
}
