//! Guessing what kind of scan a volume is.

use super::histogram::{Histogram, Window};
use crate::volume::{ScalarType, Space, Statistics, Volume};

/// Share of voxels at the lowest value from which a volume is sparse: vessels, a mask.
const SPARSE_SHARE: f64 = 0.85;

/// What a volume seems to hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Modality {
    /// CT in Hounsfield units with much air around: a head or a body.
    CtInAir,
    /// CT in Hounsfield units, mostly inside a body.
    CtInside,
    /// A patient's MRI: a noise floor and broad tissue peaks above it.
    Mri,
    /// Few voxels differ from the background: vessels without surroundings, a mask.
    Sparse,
    /// None of these.
    Other,
}

/// The modality that the values, their type and the grid suggest. `window` is the histogram's.
pub(super) fn guess(
    volume: &Volume,
    statistics: &Statistics,
    histogram: &Histogram,
    window: Window,
) -> Modality {
    if is_hounsfield(volume, statistics, histogram) {
        let air = histogram.share(f64::NEG_INFINITY, -500.0);
        return if air >= 0.25 {
            Modality::CtInAir
        } else {
            Modality::CtInside
        };
    }
    if histogram.lowest_share() >= SPARSE_SHARE {
        return Modality::Sparse;
    }
    if is_mri(volume, statistics, histogram, window) {
        return Modality::Mri;
    }
    Modality::Other
}

/// Hounsfield units: air near -1000 stands out, tissue lies about 0 (water), the rest is in range.
fn is_hounsfield(volume: &Volume, statistics: &Statistics, histogram: &Histogram) -> bool {
    let signed = match volume.voxels.scalar_type() {
        ScalarType::U8 | ScalarType::U16 | ScalarType::U32 => volume.rescale.intercept < 0.0,
        ScalarType::I8 => false,
        ScalarType::I16 | ScalarType::I32 | ScalarType::F32 | ScalarType::F64 => true,
    };
    // -3024 is the lowest padding in use; metal ends at 3071 or, on an extended scale, 30710.
    let in_range = (-4100.0..=-500.0).contains(&statistics.min)
        && (300.0..=32_767.0).contains(&statistics.max)
        && histogram.share(5000.0, f64::INFINITY) < 0.001;
    // 300 HU of air against 300 HU that neither air nor tissue has.
    let air = histogram.share(-1150.0, -850.0);
    let between = histogram.share(-600.0, -300.0);
    let tissue = histogram.share(-200.0, 300.0);
    signed && in_range && air > 0.005 && air > 2.0 * between && tissue > 0.01
}

/// MRI is stored in patient space or millimetres, starts at 0, has a quarter or more of tissue, and
/// the tissue has a peak of its own instead of a tail that falls from the background.
fn is_mri(volume: &Volume, statistics: &Statistics, histogram: &Histogram, window: Window) -> bool {
    let medical = volume.grid.space == Space::PatientRas
        || volume.spatial_unit.as_deref().is_some_and(|u| u == "mm");
    let extent = window.high - window.low;
    let foreground = histogram.share(window.low, f64::INFINITY);
    let peak = histogram.mode(window.low, window.high);
    medical
        && statistics.min >= 0.0
        && (0.25..=0.9).contains(&foreground)
        && peak > window.low + 0.1 * extent
}
