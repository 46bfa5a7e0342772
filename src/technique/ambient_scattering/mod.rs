//! Ambient scattering: light within a sphere about every sample, preintegrated `[Ament2013]`.
//!
//! Paper, symbols, stages and deviations: `README.md` in this folder.

pub mod table;

/// The technique's name everywhere.
pub const NAME: &str = "ambient_scattering";
