//! The participating medium.

use std::sync::Arc;

use super::{Perturbation, TransferFunction};
use crate::volume::ColorVolume;

/// How data values become extinction, albedo and phase.
#[derive(Clone, Debug, PartialEq)]
pub struct Medium {
    /// Data value to colour and opacity.
    pub transfer_function: TransferFunction,
    /// Factor on `sigma_t`, >= 0.
    pub density_scale: f64,
    /// Factor on the colour that gives `albedo_rgb`, in [0, 1]. Not used by emission-absorption.
    pub albedo: f64,
    /// Noise that moves what is looked up, and varies what is found.
    pub perturbation: Option<Perturbation>,
    /// Colours that take the place of the transfer function's in `albedo_rgb`, over the same box.
    pub albedo_volume: Option<Arc<ColorVolume>>,
    /// Factor on the colour that gives the radiance that the medium emits where it is opaque, >= 0:
    /// its source term is `sigma_t * emission * colour`. Emission-absorption has this term with
    /// factor 1 instead.
    pub emission: f64,
    /// Mean cosine of the Henyey-Greenstein phase function, in [-0.99, 0.99]; > 0 is forward.
    /// Not used by emission-absorption.
    pub phase_g: f64,
}
