//! `tyndall plan`.

use clap::Args;

use super::input::SceneArgs;
use super::{CliError, Global, print, print_json};
use crate::technique;

/// Show stages, resources and bytes of a scene, and what it does not need.
#[derive(Args)]
pub(super) struct PlanArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

pub(super) fn run(global: &Global, args: &PlanArgs) -> Result<(), CliError> {
    let (_, scene) = args.scene.load(global)?;
    let device = global.open_device()?;
    let plan = technique::plan(&scene, &device.info().limits)?;
    if args.json {
        print_json(&plan)?;
    } else {
        print(plan.to_string().trim_end())?;
    }
    Ok(plan.check(&device.info().limits)?)
}
