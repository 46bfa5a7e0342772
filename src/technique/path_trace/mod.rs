//! The unbiased reference: multiple scattering along random paths.
//!
//! Papers, symbols, stages and deviations: `README.md` in this folder.

mod environment;
mod knobs;
mod layout;
pub mod leaves;
mod plan;
mod record;
pub mod reference;
mod resources;

pub use knobs::KNOBS;
pub use layout::{LAYOUTS, TracePush, TraceUniform};
pub use plan::{CONSTANTS, PathTracePlan, plan, stage};
pub use record::record_trace;
pub use resources::PathTrace;

/// The technique's name everywhere.
pub const NAME: &str = "path_trace";
