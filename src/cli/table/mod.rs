//! `tyndall table`.

mod check;
mod figures;
mod plot;
mod ship;

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use clap::Args;

use super::progress::Progress;
use super::{CliError, Global, print, print_json};
use crate::technique::ambient_scattering::table::build::build;
use crate::technique::ambient_scattering::table::{
    Grid, Request, Shipped, Sums, Table, TableError, equal_error, format, shipped,
};

/// Build, check, plot and convert the preintegration table of `ambient_scattering`.
///
/// The table holds the radiance out of a unit sphere that a front of light crosses, over the angle to the light,
/// extinction and anisotropy. Those that come with the program give any albedo: nobody needs to build one to
/// render. What is built goes on where it was interrupted.
#[derive(Args)]
#[command(after_help = "Examples:\n  \
    tyndall table --plot table.svg --check points.json     of the shipped table\n  \
    tyndall table --albedo 0.99 -o out/table               build, write slice files and errors.json\n  \
    tyndall table --from published/ --plot published.svg   of the authors' files\n  \
    tyndall table --from published/ -o out/converted       read and write anew\n  \
    tyndall table --equal-error\n  \
    tyndall table --ship assets/tables/ambient_scattering.tynpack")]
pub(super) struct TableArgs {
    /// Folder of slice files, one a g, in the format of the paper's authors. Without --from: build them.
    #[arg(long, short, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Use a slice file or a folder of them instead of building, or instead of the shipped table.
    #[arg(long, value_name = "FILE|DIR", conflicts_with_all = ["albedo", "error", "seed"])]
    from: Option<PathBuf>,
    /// Single-scattering albedo of what is built.
    #[arg(long, value_name = "0..1", default_value = "0.9", value_parser = albedo, requires = "output")]
    albedo: f64,
    /// Relative standard error that half of the entries of each column (a sigma_t and g) keep to; 98 of 100 keep
    /// to 2.5 times as much.
    #[arg(long, value_name = "SHARE", default_value = "0.02", value_parser = share)]
    error: f64,
    /// Seed of the random numbers: the same one gives the same bits.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u32,
    /// Hold the table to the CPU's plain estimate at some entries and to independent values in a JSON file.
    #[arg(long, value_name = "POINTS.json", num_args = 0..=1, default_missing_value = "")]
    check: Option<PathBuf>,
    /// Plot the radiance over angle and extinction for g = -0.8, 0 and 0.8, as the paper's Fig. 5.
    #[arg(long, value_name = "FILE.svg")]
    plot: Option<PathBuf>,
    /// Run this and the paper's estimator beside each other: variance times time, by extinction, g and angle.
    #[arg(long)]
    equal_error: bool,
    /// Build the tables that the program ships (for developers): the paper's grid at albedo 0.9 and, coarser,
    /// seven other albedos. Error figures go to FILE.json.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["output", "from"])]
    ship: Option<PathBuf>,
    /// Print results as JSON.
    #[arg(long)]
    json: bool,
}

/// The table that the other options are about.
enum Source {
    Shipped,
    Table(Box<Table>),
}

pub(super) fn run(global: &Global, args: &TableArgs) -> Result<(), CliError> {
    if let Some(path) = &args.ship {
        return ship::run(global, path, args.json);
    }
    let asked = args.output.is_some() || args.check.is_some() || args.plot.is_some();
    if !asked && !args.equal_error {
        let message =
            "nothing to do: give -o DIR, --check, --plot FILE, --equal-error or --ship FILE";
        return Err(CliError::Usage(message.to_owned()));
    }
    let source = source(global, args)?;
    if let Some(path) = &args.plot {
        plot::write(path, &source)?;
    }
    if args.equal_error {
        compare_estimators(global, args)?;
    }
    match &args.check {
        Some(path) => check::run(path, &source, args.json),
        None => Ok(()),
    }
}

fn source(global: &Global, args: &TableArgs) -> Result<Source, CliError> {
    let table = match (&args.from, &args.output) {
        (Some(from), output) => {
            let table = format::read(from)?;
            if let Some(folder) = output {
                format::write(folder, &table)?;
            }
            table
        }
        (None, Some(folder)) => build_into(global, args, folder)?,
        (None, None) => return Ok(Source::Shipped),
    };
    Ok(Source::Table(Box::new(table)))
}

/// Builds, writes slice files and figures.
fn build_into(global: &Global, args: &TableArgs, folder: &Path) -> Result<Table, CliError> {
    std::fs::create_dir_all(folder).map_err(|source| TableError::Io {
        path: folder.to_owned(),
        action: "make the folder",
        source,
    })?;
    let request = Request {
        seed: args.seed,
        median_error: args.error,
        tail_error: 2.5 * args.error,
        ..Request::new(vec![args.albedo], Grid::PAPER)
    };
    let state = folder.join("state.sums");
    let (sums, seconds) = build_shown(global, &request, &state, "table")?;
    let table = Table::new(&sums, 0);
    format::write(folder, &table)?;
    let report = figures::Report::new([(&sums, seconds)]);
    figures::write(&folder.join("errors.json"), &report)?;
    if args.json {
        print_json(&report)?;
    } else {
        print(&figures::text(&report))?;
    }
    Ok(table)
}

/// Builds with a progress bar; seconds are those of this run.
fn build_shown(
    global: &Global,
    request: &Request,
    state: &Path,
    name: &str,
) -> Result<(Sums, f64), CliError> {
    let device = global.open_device()?;
    let mut progress = Progress::new(global.quiet);
    let begun = std::time::Instant::now();
    let sums = build(&device, request, Some(state), &mut |done, total| {
        progress.update(name, done, total);
        ControlFlow::Continue(())
    })?;
    progress.finish();
    // Nothing above breaks a build off.
    let sums = sums.ok_or_else(|| CliError::Usage("the build was broken off".to_owned()))?;
    Ok((sums, begun.elapsed().as_secs_f64()))
}

fn compare_estimators(global: &Global, args: &TableArgs) -> Result<(), CliError> {
    let device = global.open_device()?;
    let mut progress = Progress::new(global.quiet);
    let found = equal_error::measure(&device, args.albedo, &mut |done, total| {
        progress.update("equal error", done, total);
    })?;
    progress.finish();
    if args.json {
        return print_json(&found);
    }
    print(&figures::equal_error(&found))
}

impl Source {
    /// The shipped tables.
    fn shipped() -> Result<&'static Shipped, CliError> {
        shipped().map_err(|e| CliError::Usage(e.to_string()))
    }
}

fn albedo(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(albedo) if (0.0..=1.0).contains(&albedo) => Ok(albedo),
        _ => Err("expected 0 to 1, for example 0.9".to_owned()),
    }
}

fn share(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(share) if share > 0.0 && share <= 1.0 => Ok(share),
        _ => Err("expected a number above 0 and at most 1, for example 0.01".to_owned()),
    }
}
