//! Single scattering from every light, through a cache of the depths to them.
//!
//! Paper, symbols, stages and deviations: `README.md` in this folder.

mod cache;
mod knobs;
mod layout;
mod plan;
mod record;
pub mod reference;
mod resources;

pub use cache::CachePlan;
pub use knobs::KNOBS;
pub use layout::{CacheLightPush, LAYOUTS, ScatterMarchPush, ScatterUniform};
pub use plan::{CACHE_CONSTANTS, MARCH_CONSTANTS, SingleScatterPlan, plan, stage};
pub use record::{record_light_cache, record_march};
pub use resources::SingleScatter;

/// The technique's name everywhere.
pub const NAME: &str = "single_scatter";
