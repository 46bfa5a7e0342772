//! Error figures for people and for files.

use std::io::Write;
use std::path::Path;

use serde::Serialize;

use super::super::CliError;
use crate::output::atomic;
use crate::technique::ambient_scattering::table::Sums;
use crate::technique::ambient_scattering::table::equal_error::EqualError;
use crate::technique::ambient_scattering::table::layout::LANES;
use crate::technique::ambient_scattering::table::sums::{Figures, figures};

/// How well tables are known, and what they took.
#[derive(Serialize)]
pub(super) struct Report {
    tables: Vec<Part>,
}

#[derive(Serialize)]
struct Part {
    name: String,
    albedos: Vec<f64>,
    seed: u32,
    /// Wall seconds of the run that ended the build.
    seconds: f64,
    paths: u64,
    /// Relative standard errors of the entries brighter than 1e-4, at the first albedo.
    errors: Vec<Figures>,
}

impl Report {
    pub(super) fn new(parts: Vec<(&str, &Sums, f64)>) -> Self {
        let part = |(name, sums, seconds): (&str, &Sums, f64)| Part {
            name: name.to_owned(),
            albedos: sums.request.albedos.clone(),
            seed: sums.request.seed,
            seconds,
            paths: sums.batches.iter().map(|b| u64::from(*b)).sum::<u64>()
                * u64::from(LANES * sums.request.paths()),
            errors: figures(sums),
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
            "{}: {:.3e} paths in {:.0} s; relative standard errors of entries brighter than 1e-4, %",
            part.name, part.paths as f64, part.seconds
        ));
        let title = ["region", "entries", "median", "99 %", "largest"];
        let [region, entries, median, tail, largest] = title;
        lines.push(format!(
            "{region:<26}{entries:>9}{median:>9}{tail:>9}{largest:>9}"
        ));
        lines.extend(part.errors.iter().map(|f| {
            let [median, tail, largest] =
                [f.median, f.percentile_99, f.largest].map(|e| format!("{:.2}", 100.0 * e));
            format!(
                "{:<26}{:>9}{median:>9}{tail:>9}{largest:>9}",
                f.region, f.entries
            )
        }));
    }
    lines.join("\n")
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
