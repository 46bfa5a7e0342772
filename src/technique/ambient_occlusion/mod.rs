//! Ambient occlusion by extinction `[Schlegel2011]`: light from all around, dimmed by the mean extinction of
//! shells about every sample.
//!
//! Paper, symbols, stages and deviations: `README.md` in this folder.

mod knobs;
mod layout;
mod plan;
mod record;
pub mod reference;
mod resources;

pub use knobs::KNOBS;
pub use layout::{LAYOUTS, OccludedUniform};
pub use plan::{AmbientOcclusionPlan, CONSTANTS, plan, stage};
pub use record::{record_march, record_occlusion};
pub use resources::AmbientOcclusion;

/// The technique's name everywhere.
pub const NAME: &str = "ambient_occlusion";
