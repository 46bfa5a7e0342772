//! Emission-absorption and gradient shading along camera rays.
//!
//! Paper, symbols, stages and deviations: `README.md` in this folder.

mod knobs;
mod layout;
mod plan;
mod record;
pub mod reference;
mod resources;

pub use knobs::KNOBS;
pub use layout::{LAYOUTS, MarchUniform};
pub use plan::{CONSTANTS, RayMarchPlan, plan, stage};
pub use record::record_march;
pub use resources::RayMarch;

/// The technique's name everywhere.
pub const NAME: &str = "ray_march";
