//! Summed-area tables of the medium's extinction and its square: sums over boxes at a cost that does not depend
//! on their size. Shared by the techniques that look at neighbourhoods.
//!
//! Stages, formats and reasons: `README.md` in this folder.

mod field;
mod layout;
mod plan;
mod probe;
mod record;
pub mod reference;
mod resources;
mod scan;
mod scan_form;

pub use field::{Field, FieldKind, FieldPlan, occlusion_radius};
pub use layout::{AreaUniform, BoxPush, ExtinctionPush, LAYOUTS, OcclusionPush};
pub use plan::{CONSTANTS, SummedAreaPlan, box_side, stage, summable_radius};
#[doc(hidden)]
pub use probe::{probe, probe_scan};
pub use record::record_sums;
pub use resources::{SummedArea, Sums};
pub use scan_form::ScanForm;
