//! The medium on the device: voxels, transfer function, and where it is empty.
//!
//! Shared by all techniques. Stages, formats and reasons: `README.md` in this folder.

mod encoding;
mod material;
mod plan;
mod plan_resources;
mod record;
mod resources;
mod table;

pub use encoding::Encoding;
pub use material::{CONSTANTS, MATERIAL, MaterialUniform, with_material};
pub use plan::{CellsPlan, MediumPlan, reach_of_noise, stage};
pub use record::{record_occupancy, record_ranges};
pub(super) use resources::sampler;
pub use resources::{LAYOUTS, Medium, OccupancyPush};
pub use table::Table;
