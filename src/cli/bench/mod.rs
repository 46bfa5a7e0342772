//! `tyndall bench`: what each stage costs over a camera orbit, and what each kind of change costs; of one
//! scene, or of all rows of a paper's table.

mod ament2013;
mod kniss2003;
mod paper;
mod report;
mod reproduce;
mod scene;
mod stand_in;
mod text;
mod turns;

use clap::{Args, ValueEnum};

use super::input::SceneArgs;
use super::{CliError, Global};

/// What names or changes a scene, which a paper's table does itself.
const SCENE: [&str; 8] = [
    "input",
    "overrides",
    "tf",
    "technique",
    "dims",
    "time",
    "spp",
    "target_error",
];

/// Measure each stage over a camera orbit, and what each kind of change costs.
///
/// With --paper: what a paper timed (ament2013: changes of transfer function, phase and light, rendering;
/// kniss2003: rendering) for each of its optical models in turns, as ratios beside the paper's own.
#[derive(Args)]
#[command(after_help = "Examples:\n  \
    tyndall bench assets/scenes/cloud.toml --frames 32\n  \
    tyndall bench --paper ament2013\n  \
    tyndall bench --paper ament2013 --rows supernova,6 --repeat 3 --json\n  \
    tyndall bench --paper kniss2003 --frames 4 --repeat 1")]
pub(super) struct BenchArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Frames of the orbit, evenly over 360 degrees.
    #[arg(long, default_value_t = 16, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    frames: u32,
    /// Frames before the orbit that are not counted (drivers compile at the first).
    #[arg(long, default_value_t = 2, conflicts_with = "paper")]
    warmup: u32,
    /// Repetitions of each kind of change; with --paper, of the orbit too.
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=1000))]
    repeat: u32,
    /// Instead of a scene: reproduce a paper's table of times, with formulas in place of its data sets.
    #[arg(long, value_name = "PAPER", conflicts_with_all = SCENE)]
    paper: Option<Paper>,
    /// Rows of the paper's table: numbers from 1 or parts of names, separated by commas. Default: all.
    #[arg(
        long,
        value_name = "ROW,...",
        value_delimiter = ',',
        requires = "paper"
    )]
    rows: Vec<String>,
    /// Image size in pixels with --paper. Default: the paper's.
    #[arg(long, value_name = "WxH", requires = "paper")]
    size: Option<String>,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

/// A paper whose table of times is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Paper {
    /// Ament et al. 2013, Ambient Volume Scattering, Table 1.
    Ament2013,
    /// Kniss et al. 2003, A Model for Volume Lighting and Modeling, Section IV and Figure 14.
    Kniss2003,
}

pub(super) fn run(global: &Global, args: &BenchArgs) -> Result<(), CliError> {
    match args.paper {
        Some(paper) => reproduce::run(global, args, paper),
        None => scene::run(global, args),
    }
}
