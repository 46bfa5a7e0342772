//! The techniques: each turns a scene into a plan, the plan into resources, those into an image.
//!
//! One technique is one folder, with the same name here, in `glsl/`, `spirv/` and `tests/goldens/`.
//! [`medium`] is what they share on the device: the volume, the transfer function and the cells that
//! say where the medium is empty; [`summed_area`] what those share that look at neighbourhoods.

mod albedo_volume;
pub mod ambient_occlusion;
pub mod ambient_scattering;
pub mod half_angle;
mod inputs;
mod knob;
mod lights;
pub mod medium;
mod nodes;
pub mod path_trace;
mod phase;
mod plan;
pub mod ray_march;
mod reference_medium;
mod reference_ray;
mod renderer;
mod seen;
pub mod single_scatter;
mod spread;
pub mod summed_area;
mod target;
mod techniques;
mod tiles;
mod view;

pub use inputs::{Input, Inputs};
pub use knob::{Knob, Knobs};
pub use lights::{LightUniform, MAX_LIGHTS};
pub use phase::phase_hg;
pub(crate) use plan::size;
pub use plan::{Omission, Plan, PlanError, ResourceKind, ResourcePlan, StagePlan};
pub use renderer::{FrameReport, Progress, RenderError, Renderer};
pub use spread::{Spread, StageSpread, stage_spreads};
pub use techniques::{KNOBS, NAMES, Technique, TechniquePlan};
pub use tiles::{TilePush, Tiles};
pub use view::ViewUniform;

use crate::gpu::Limits;
use crate::scene::Scene;

/// What the scene's technique would do on a device with these limits: pure data, no Vulkan.
///
/// # Errors
/// The scene exceeds a limit; the message names it and what would help.
pub fn plan(scene: &Scene, limits: &Limits) -> Result<Plan, PlanError> {
    Ok(TechniquePlan::new(scene, limits)?.summary(scene))
}
