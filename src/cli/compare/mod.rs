//! `tyndall compare`.

mod input;
mod limits;
mod table;

use std::path::{Path, PathBuf};

use clap::Args;
use serde_json::{Value, json};

use self::input::Picture;
use self::limits::{Checked, LimitArgs};
use super::{CliError, print, print_json};
use crate::output::metrics::{
    CompareError, CompareOptions, Comparison, Estimate, Side, compare_displays, compare_images,
    flip,
};
use crate::output::png::BitDepth;
use crate::output::{Metadata, atomic, png};
use crate::scene::{Exposure, ToneMap};

/// Measure how far an image is from a reference, and hold it to limits.
///
/// Two EXRs are compared as radiance, and as shown with the reference's exposure; two PNGs as the
/// display values they hold. A variance layer (channels variance.R, .G, .B) in either EXR gives
/// z-scores: what of the difference noise explains. A limit that is exceeded ends with exit code 6.
#[derive(Args)]
#[command(
    after_help = "Example:\n  tyndall compare fast.exr reference.exr --diff flip.png --max-relative-mse 0.01 \
                  --max-flip 0.05\n\
                  Exit codes: 0 measured, and every limit is kept; 1 a file cannot be read or the two cannot \
                  be compared; 2 wrong usage, or a limit on what cannot be measured here; 6 a limit is exceeded."
)]
pub(super) struct CompareArgs {
    /// The image to judge, EXR or PNG.
    #[arg(value_name = "A")]
    found: PathBuf,
    /// The reference, of the same kind and size.
    #[arg(value_name = "B")]
    reference: PathBuf,
    /// Write the LDR-FLIP error of each pixel as a picture, black (none) over red to pale yellow.
    #[arg(long, value_name = "FILE.png")]
    diff: Option<PathBuf>,
    /// Exposure of both images in stops, or `auto`: the reference's. For EXRs.
    #[arg(long, value_name = "STOPS|auto", allow_hyphen_values = true, value_parser = exposure)]
    exposure: Option<Exposure>,
    /// Tone map of both images. For EXRs.
    #[arg(long)]
    tone_map: Option<ToneMap>,
    #[command(flatten)]
    limits: LimitArgs,
    /// Print all numbers as JSON.
    #[arg(long)]
    json: bool,
}

pub(super) fn run(args: &CompareArgs) -> Result<(), CliError> {
    check_diff(args)?;
    let found = input::read(&args.found)?;
    let reference = input::read(&args.reference)?;
    let comparison = compare(args, &found, &reference)?;
    let checked = args.limits.check(&comparison)?;
    if let Some(path) = &args.diff {
        let picture = flip::picture(&comparison.flip_map);
        png::write_display(path, &picture, BitDepth::Eight, false, &Metadata::new())?;
    }
    if args.json {
        print_json(&report(args, &comparison, &checked))?;
    } else {
        print(&table::table(&args.found, &args.reference, &comparison))?;
    }
    let exceeded: Vec<String> = checked.iter().filter_map(Checked::exceeded).collect();
    if exceeded.is_empty() {
        Ok(())
    } else {
        Err(CliError::Limits(exceeded))
    }
}

/// `auto` or a finite number of stops.
fn exposure(text: &str) -> Result<Exposure, String> {
    if text == "auto" {
        return Ok(Exposure::Auto);
    }
    match text.parse::<f32>() {
        Ok(stops) if stops.is_finite() => Ok(Exposure::Stops(stops)),
        _ => Err("expected a number of stops or `auto`".to_owned()),
    }
}

/// Refuses a difference picture that could not be written, before any work is done.
fn check_diff(args: &CompareArgs) -> Result<(), CliError> {
    let Some(path) = &args.diff else {
        return Ok(());
    };
    let is_png = path
        .extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("png"));
    if !is_png {
        return Err(CliError::Usage(format!(
            "--diff {}: expected a file ending in .png",
            path.display()
        )));
    }
    atomic::check(path)?;
    Ok(())
}

fn compare(
    args: &CompareArgs,
    found: &Picture,
    reference: &Picture,
) -> Result<Comparison, CliError> {
    let defaults = CompareOptions::default();
    let options = CompareOptions {
        exposure: args.exposure.unwrap_or(defaults.exposure),
        tone_map: args.tone_map.unwrap_or(defaults.tone_map),
        ..defaults
    };
    let compared = match (found, reference) {
        (Picture::Radiance(a, a_variance), Picture::Radiance(b, b_variance)) => {
            let estimate = |image, variance| Estimate { image, variance };
            compare_images(
                estimate(a, a_variance.as_ref()),
                estimate(b, b_variance.as_ref()),
                &options,
            )
        }
        (Picture::Display(a), Picture::Display(b)) => {
            if args.exposure.is_some() || args.tone_map.is_some() {
                return Err(CliError::Usage(
                    "--exposure and --tone-map are for radiance: found two PNGs, which are \
                     display values already, expected two EXRs"
                        .to_owned(),
                ));
            }
            compare_displays(a, b, &options)
        }
        _ => return Err(mixed(args, found, reference)),
    };
    compared.map_err(|error| named(args, &error))
}

fn mixed(args: &CompareArgs, found: &Picture, reference: &Picture) -> CliError {
    CliError::Usage(format!(
        "{} is {}, {} is {}: expected two EXRs or two PNGs; render both to the same kind of file",
        args.found.display(),
        found.kind(),
        args.reference.display(),
        reference.kind()
    ))
}

/// The error with the file or files it is about.
fn named(args: &CompareArgs, error: &CompareError) -> CliError {
    let name = |path: &Path| path.display().to_string();
    let about = match error.side() {
        Some(Side::Found) => name(&args.found),
        Some(Side::Reference) => name(&args.reference),
        None => format!("{} beside {}", name(&args.found), name(&args.reference)),
    };
    CliError::Compare(format!("{about}: {error}"))
}

fn report(args: &CompareArgs, comparison: &Comparison, checked: &[Checked]) -> Value {
    json!({
        "tyndall": env!("CARGO_PKG_VERSION"),
        "found": args.found,
        "reference": args.reference,
        "comparison": comparison,
        "limits": checked,
    })
}
