//! `tyndall study --extremes`: where each technique stops being trustworthy.

use serde::Serialize;

use super::super::progress::Progress;
use super::super::{CliError, Global, print, print_json};
use crate::stability::{Finding, Subject, examine, extremes, subjects};
use crate::technique::path_trace;

/// A finding, and what it says.
#[derive(Serialize)]
struct Row {
    #[serde(flatten)]
    finding: Finding,
    /// Mean radiance over that of `path_trace` of the same orders of scattering, less 1, and its standard
    /// error.
    beside_reference: Option<[f64; 2]>,
    complaints: Vec<String>,
}

/// Renders every extreme by every technique and prints what was found.
pub(super) fn run(global: &Global, json: bool) -> Result<(), CliError> {
    let device = global.open_device()?;
    let (extremes, subjects) = (extremes(), subjects());
    let mut progress = Progress::new(global.quiet);
    let mut rows = Vec::new();
    for (i, extreme) in extremes.iter().enumerate() {
        progress.update("extremes", i as u64, extremes.len() as u64);
        let mut findings = Vec::new();
        for subject in &subjects {
            findings.push((subject, examine(&device, extreme, subject)?));
        }
        rows.extend(findings.iter().map(|(subject, finding)| Row {
            beside_reference: beside_reference(subject, finding, &findings),
            complaints: finding.complaints(),
            finding: finding.clone(),
        }));
    }
    progress.finish();
    if json {
        return print_json(&rows);
    }
    rows.chunks(subjects.len()).try_for_each(print_extreme)
}

fn beside_reference(
    subject: &Subject,
    finding: &Finding,
    all: &[(&Subject, Finding)],
) -> Option<[f64; 2]> {
    let is_reference = |s: &Subject| s.params.name() == path_trace::NAME;
    let same = |(s, f): &&(&Subject, Finding)| is_reference(s) && f.model == finding.model;
    let (_, reference) = all.iter().find(same)?;
    if is_reference(subject) || reference.mean[0] == 0.0 {
        return None;
    }
    let error = finding.mean[1].hypot(reference.mean[1]);
    Some([
        finding.mean[0] / reference.mean[0] - 1.0,
        error / reference.mean[0],
    ])
}

fn print_extreme(rows: &[Row]) -> Result<(), CliError> {
    if let Some(first) = rows.first() {
        print(&format!("\n{}", first.finding.extreme))?;
    }
    for row in rows {
        print(&format!("  {:<24} {}", row.finding.subject, describe(row)))?;
    }
    Ok(())
}

/// What was found, in a line.
fn describe(row: &Row) -> String {
    let f = &row.finding;
    let mut parts = vec![if row.complaints.is_empty() {
        "holds".to_owned()
    } else {
        format!("FAILS: {}", row.complaints.join("; "))
    }];
    parts.push(format!(
        "brightest {:.2e} of at most {:.2e}",
        f.brightest, f.bound
    ));
    if let Some([found, expected]) = f.alpha {
        parts.push(format!("alpha off by {:.1e}", relative(found, expected)));
    }
    if let Some(l) = &f.limit {
        parts.push(format!(
            "{} limit off by {:.1e}",
            l.name,
            relative(l.found, l.expected)
        ));
    }
    if let Some([difference, error]) = row.beside_reference {
        parts.push(format!(
            "{:+.2} % of path_trace (+- {:.2})",
            100.0 * difference,
            100.0 * error
        ));
    }
    parts.join(", ")
}

fn relative(found: f64, expected: f64) -> f64 {
    if expected == 0.0 {
        found.abs()
    } else {
        (found / expected - 1.0).abs()
    }
}
