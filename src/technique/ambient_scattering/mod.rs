//! Ambient volume scattering `[Ament2013]`: light scattered any number of times within a sphere about every
//! sample, from a table, and light dimmed on its way to the sphere along a tube.
//!
//! Paper, symbols, stages and deviations: `README.md` in this folder.

mod cache;
mod choice;
mod gather;
mod knobs;
mod layout;
mod lookup;
mod plan;
mod record;
pub mod reference;
mod resources;
pub mod slab;
pub mod table;

pub use cache::CachePlan;
pub use choice::{albedo, radius};
pub use gather::GatherPlan;
pub use knobs::KNOBS;
pub use layout::{AmbientUniform, GatherPush, LAYOUTS, TubePush};
pub use plan::{
    AmbientScatteringPlan, CACHE_CONSTANTS, GATHER_CONSTANTS, MARCH_CONSTANTS, plan, stage,
};
pub use record::{record_march, record_radiance_cache};
pub use resources::AmbientScattering;

/// The technique's name everywhere.
pub const NAME: &str = "ambient_scattering";
