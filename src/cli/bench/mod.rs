//! `tyndall bench`: what each stage costs over a camera orbit, and what each kind of change costs.

mod scene;

use clap::Args;

use super::input::SceneArgs;
use super::{CliError, Global};

/// Measure each stage over a camera orbit, and what each kind of change costs.
#[derive(Args)]
pub(super) struct BenchArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Frames of the orbit, evenly over 360 degrees.
    #[arg(long, default_value_t = 16, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    frames: u32,
    /// Frames before the orbit that are not counted (drivers compile at the first).
    #[arg(long, default_value_t = 2)]
    warmup: u32,
    /// Repetitions of each kind of change.
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=1000))]
    repeat: u32,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

pub(super) fn run(global: &Global, args: &BenchArgs) -> Result<(), CliError> {
    scene::run(global, args)
}
