//! Light propagated slice by slice, half way between light and view: shadows and translucency.
//!
//! Paper, symbols, stages and deviations: `README.md` in this folder.

mod frustum;
mod knobs;
mod layout;
mod plan;
mod record;
pub mod reference;
mod resources;
mod sweep;
mod tables;

pub use frustum::{LightFrustum, Place, frusta};
pub use knobs::KNOBS;
pub use layout::{ComposePush, LAYOUTS, SlicePush, SweepUniform};
pub use plan::{HalfAnglePlan, PROPAGATE_CONSTANTS, SHADE_CONSTANTS, plan, stage};
pub use record::record_sweeps;
pub use resources::HalfAngle;
pub use sweep::{Lens, Rect, Slice, Sweep};

/// The technique's name everywhere.
pub const NAME: &str = "half_angle";
