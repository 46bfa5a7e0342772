//! Error figures for people and for files.

use std::io::Write;
use std::path::Path;

use serde::Serialize;

use super::super::CliError;
use crate::output::atomic;
use crate::technique::ambient_scattering::table::Sums;
use crate::technique::ambient_scattering::table::equal_error::EqualError;
use crate::technique::ambient_scattering::table::layout::{LANES, PATHS};
use crate::technique::ambient_scattering::table::sums::{Figures, figures};

/// How well tables are known, and what they took.
#[derive(Serialize)]
pub(super) struct Report {
    tables: Vec<Part>,
}

#[derive(Serialize)]
struct Part {
    seed: u32,
    /// Wall seconds of the run that ended the build.
    seconds: f64,
    paths: u64,
    /// By albedo.
    errors: Vec<Errors>,
}

#[derive(Serialize)]
struct Errors {
    albedo: f64,
    /// Relative standard errors of the entries brighter than 1e-4.
    regions: Vec<Figures>,
}

impl Report {
    /// Of sums and the seconds they took.
    pub(super) fn new<'a>(parts: impl IntoIterator<Item = (&'a Sums, f64)>) -> Self {
        let part = |(sums, seconds): (&Sums, f64)| Part {
            seed: sums.request.seed,
            seconds,
            paths: sums.batches.iter().map(|b| u64::from(*b)).sum::<u64>()
                * u64::from(LANES * PATHS),
            errors: (sums.request.albedos.iter().enumerate())
                .map(|(k, albedo)| Errors {
                    albedo: *albedo,
                    regions: figures(sums, k),
                })
                .collect(),
        };
        Self {
            tables: parts.into_iter().map(part).collect(),
        }
    }
}

pub(super) fn write(path: &Path, report: &Report) -> Result<(), CliError> {
    let text = serde_json::to_string_pretty(report).map_err(|e| CliError::Stdout(e.into()))?;
    Ok(atomic::write(path, |file| writeln!(file, "{text}"))?)
}

pub(super) fn text(report: &Report) -> String {
    let mut lines = Vec::new();
    for part in &report.tables {
        lines.push(format!(
            "{:.3e} paths in {:.0} s; relative standard errors of entries brighter than 1e-4, %",
            part.paths as f64, part.seconds
        ));
        for errors in &part.errors {
            let title = format!("albedo {}", errors.albedo);
            lines.push(format!(
                "{title:<26}{:>9}{:>9}{:>9}{:>9}{:>9}",
                "entries", "median", "95 %", "99 %", "largest"
            ));
            lines.extend(errors.regions.iter().map(region));
        }
    }
    lines.join("\n")
}

fn region(f: &Figures) -> String {
    let [median, tail, further, largest] = [f.median, f.percentile_95, f.percentile_99, f.largest]
        .map(|e| format!("{:.2}", 100.0 * e));
    format!(
        "{:<26}{:>9}{median:>9}{tail:>9}{further:>9}{largest:>9}",
        f.region, f.entries
    )
}

pub(super) fn equal_error(found: &[EqualError]) -> String {
    let mut lines = vec![
        "device seconds to 1 % standard error, median over angles of entries brighter than 1e-4"
            .to_owned(),
        format!(
            "{:>6} {:>8} {:>10} {:>8} {:>7} {:>10} {:>10} {:>8}",
            "g", "sigma_t", "theta", "entries", "unseen", "shared", "plain", "ratio"
        ),
    ];
    for e in found {
        let [from, to] = e.angles;
        lines.push(format!(
            "{:>6} {:>8} {:>10} {:>8} {:>7} {:>10.4} {:>10.4} {:>8.1}",
            e.g,
            e.sigma_t,
            format!("{from:.0}-{to:.0}"),
            e.entries,
            e.unseen,
            e.seconds[0],
            e.seconds[1],
            e.ratio
        ));
    }
    for [from, to] in [[0.0, 45.0], [45.0, 135.0], [135.0, 180.1]] {
        let logs: Vec<f64> = (found.iter())
            .filter(|e| e.angles == [from, to])
            .map(|e| e.ratio.ln())
            .collect();
        let mean = (logs.iter().sum::<f64>() / logs.len().max(1) as f64).exp();
        lines.push(format!(
            "theta {from:.0} to {to:.0}: plain takes {mean:.1} times as long (geometric mean)"
        ));
    }
    lines.join("\n")
}
