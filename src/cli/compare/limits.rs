//! What a comparison must keep to.

use clap::Args;
use serde::Serialize;

use crate::cli::CliError;
use crate::output::metrics::Comparison;

/// One option a limit. All are numbers of 0 or more.
#[derive(Args)]
#[command(next_help_heading = "Limits (exit code 6 where one is exceeded)")]
pub(super) struct LimitArgs {
    /// RMSE of the values: radiance (EXR) or display values (PNG).
    #[arg(long, value_name = "X", allow_hyphen_values = true, value_parser = limit)]
    max_rmse: Option<f64>,
    /// Relative MSE of the radiance.
    #[arg(long, value_name = "X", allow_hyphen_values = true, value_parser = limit)]
    max_relative_mse: Option<f64>,
    /// Absolute mean bias of the channel where it is largest.
    #[arg(long, value_name = "X", allow_hyphen_values = true, value_parser = limit)]
    max_bias: Option<f64>,
    /// The same over the reference's mean of that channel.
    #[arg(long, value_name = "X", allow_hyphen_values = true, value_parser = limit)]
    max_relative_bias: Option<f64>,
    /// Largest difference of any channel of any pixel.
    #[arg(long, value_name = "X", allow_hyphen_values = true, value_parser = limit)]
    max_difference: Option<f64>,
    /// PSNR of the values in dB; the peak of radiance is the reference's largest channel.
    #[arg(long, value_name = "DB", allow_hyphen_values = true, value_parser = limit)]
    min_psnr: Option<f64>,
    /// Mean SSIM as shown.
    #[arg(long, value_name = "X", allow_hyphen_values = true, value_parser = limit)]
    min_ssim: Option<f64>,
    /// Mean LDR-FLIP as shown.
    #[arg(long, value_name = "X", allow_hyphen_values = true, value_parser = limit)]
    max_flip: Option<f64>,
    /// Mean HDR-FLIP of the radiance.
    #[arg(long, value_name = "X", allow_hyphen_values = true, value_parser = limit)]
    max_hdr_flip: Option<f64>,
    /// Largest |z| of any channel of any pixel that has a variance; --max-difference holds the others.
    #[arg(long, value_name = "X", allow_hyphen_values = true, value_parser = limit)]
    max_z: Option<f64>,
    /// Largest |z| of the three channels' means.
    #[arg(long, value_name = "X", allow_hyphen_values = true, value_parser = limit)]
    max_mean_z: Option<f64>,
}

/// A finite number of 0 or more: with NaN no limit would ever be exceeded.
fn limit(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value >= 0.0 => Ok(value),
        _ => Err("expected a finite number of 0 or more".to_owned()),
    }
}

/// A limit beside what was measured.
#[derive(Serialize)]
pub(super) struct Checked {
    option: &'static str,
    limit: f64,
    value: f64,
    kept: bool,
}

impl Checked {
    /// What to tell where the limit is not kept.
    pub(super) fn exceeded(&self) -> Option<String> {
        let Self {
            option,
            limit,
            value,
            kept,
        } = self;
        (!kept).then(|| format!("limit exceeded: {option} {limit}: found {value}"))
    }
}

/// Whether the measure may not be above or not below its limit.
#[derive(Clone, Copy)]
enum Bound {
    Max,
    Min,
}

const NEEDS_RADIANCE: &str = "found two PNGs, expected two EXRs: it is a measure of radiance";
const NEEDS_VARIANCE: &str = "no variance to measure by, expected channels variance.R, variance.G \
     and variance.B that are not 0 everywhere in at least one of two EXRs";
const NEEDS_MEAN: &str = "the reference's mean is 0 in a channel, so there is no relative bias: \
     use --max-bias";
const NEEDS_WINDOW: &str = "a side of the image is shorter than 11 pixels, the window of SSIM";

impl LimitArgs {
    /// Every limit that was given, with the measure; an error where there is no such measure.
    pub(super) fn check(&self, comparison: &Comparison) -> Result<Vec<Checked>, CliError> {
        use Bound::{Max, Min};
        let (e, shown) = (&comparison.errors, &comparison.shown);
        let largest = |values: [f64; 3]| values.into_iter().map(f64::abs).fold(0.0, f64::max);
        let relative = e.relative_channel_bias;
        let relative_bias = relative
            .iter()
            .all(Option::is_some)
            .then(|| largest(relative.map(Option::unwrap_or_default)));
        let hdr_flip = comparison.hdr_flip.map(|f| f.error.mean);
        let z = comparison.z_score.as_ref();
        let max_z = z.and_then(|z| z.largest.as_ref()).map(|l| l.z.abs());
        let means = z.map(|z| z.mean.into_iter().flatten().map(f64::abs));
        let mean_z = means.and_then(|means| means.reduce(f64::max));
        let bias = Some(largest(e.channel_bias));
        let difference = Some(e.largest.difference);
        let rows = [
            ("--max-rmse", self.max_rmse, Max, Some(e.rmse), ""),
            (
                "--max-relative-mse",
                self.max_relative_mse,
                Max,
                e.relative_mse,
                NEEDS_RADIANCE,
            ),
            ("--max-bias", self.max_bias, Max, bias, ""),
            (
                "--max-relative-bias",
                self.max_relative_bias,
                Max,
                relative_bias,
                NEEDS_MEAN,
            ),
            ("--max-difference", self.max_difference, Max, difference, ""),
            ("--min-psnr", self.min_psnr, Min, Some(e.psnr), ""),
            ("--min-ssim", self.min_ssim, Min, shown.ssim, NEEDS_WINDOW),
            ("--max-flip", self.max_flip, Max, Some(shown.flip.mean), ""),
            (
                "--max-hdr-flip",
                self.max_hdr_flip,
                Max,
                hdr_flip,
                NEEDS_RADIANCE,
            ),
            ("--max-z", self.max_z, Max, max_z, NEEDS_VARIANCE),
            ("--max-mean-z", self.max_mean_z, Max, mean_z, NEEDS_VARIANCE),
        ];
        let given = rows
            .into_iter()
            .filter_map(|(option, limit, bound, value, needs)| {
                let limit = limit?;
                Some(checked(option, limit, bound, value, needs))
            });
        given.collect()
    }
}

fn checked(
    option: &'static str,
    limit: f64,
    bound: Bound,
    value: Option<f64>,
    needs: &str,
) -> Result<Checked, CliError> {
    let Some(value) = value else {
        return Err(CliError::Usage(format!("{option}: {needs}")));
    };
    // A value that is NaN keeps no limit.
    let kept = match bound {
        Bound::Max => value <= limit,
        Bound::Min => value >= limit,
    };
    Ok(Checked {
        option,
        limit,
        value,
        kept,
    })
}
