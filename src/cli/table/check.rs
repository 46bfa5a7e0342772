//! `tyndall table --check`.

use std::path::Path;

use super::super::{CliError, print, print_json};
use super::Source;
use crate::technique::ambient_scattering::table::check::{
    Comparison, Point, agrees, chi_squared, compare, read,
};
use crate::technique::ambient_scattering::table::reference::entry;

/// Paths of the CPU's estimate of an entry.
const PATHS: u32 = 100_000;
/// Entries that the CPU estimates: angle in degrees, extinction, g.
const ENTRIES: [[f64; 3]; 8] = [
    [180.0, 0.5, -0.8],
    [90.0, 3.0, -0.4],
    [0.0, 2.0, 0.0],
    [90.0, 10.0, 0.0],
    [180.0, 20.0, 0.0],
    [45.0, 2.0, 0.4],
    [0.0, 5.0, 0.8],
    [135.0, 1.0, 0.8],
];
/// Relative error of a table that states none.
const ASSUMED_ERROR: f64 = 0.01;

/// `path` is empty where only the CPU is asked.
pub(super) fn run(path: &Path, source: &Source, json: bool) -> Result<(), CliError> {
    let albedo = match source {
        Source::Shipped => 0.9,
        Source::Table(table) => table.albedo,
    };
    let mut points: Vec<Point> = (1..)
        .zip(ENTRIES)
        .map(|(seed, [theta, sigma_t, g])| {
            entry(theta.to_radians(), sigma_t, g, albedo, PATHS, seed)
        })
        .collect();
    if !path.as_os_str().is_empty() {
        points.extend(read(path)?);
    }
    let comparisons = match source {
        Source::Shipped => {
            let shipped = Source::shipped()?;
            compare(&points, |p| {
                shipped.entry(p.theta, p.sigma_t, p.g, p.albedo)
            })
        }
        Source::Table(table) => {
            let span = table.grid.gs;
            let within = |p: &Point| {
                (p.albedo - table.albedo).abs() < 1e-6
                    && (span.min - 1e-6..=span.max + 1e-6).contains(&p.g)
                    && p.sigma_t <= table.grid.sigmas.max
            };
            points.retain(within);
            compare(&points, |p| {
                let radiance = table.slice(p.g).radiance(p.theta, p.sigma_t);
                [
                    radiance,
                    table
                        .error_near(p.theta, p.sigma_t, p.g)
                        .unwrap_or(ASSUMED_ERROR * radiance),
                ]
            })
        }
    };
    if json {
        print_json(&comparisons)?;
    } else {
        print(&text(&comparisons))?;
    }
    if agrees(&comparisons) {
        return Ok(());
    }
    let [sum, limit] = chi_squared(&comparisons);
    Err(CliError::Limits(vec![format!(
        "the table does not agree: chi^2 is {sum:.1} of {} points, expected at most {limit:.1} and no |z| of 4",
        comparisons.len()
    )]))
}

fn text(comparisons: &[Comparison]) -> String {
    let title = format!(
        "{:>6} {:>6} {:>8} {:>7} {:>12} {:>8} {:>12} {:>8} {:>7}",
        "albedo", "g", "sigma_t", "theta", "table", "+- %", "point", "+- %", "z"
    );
    let mut lines = vec![title];
    for c in comparisons {
        let p = &c.point;
        lines.push(format!(
            "{:>6} {:>6} {:>8} {:>7.2} {:>12.4e} {:>8.2} {:>12.4e} {:>8.2} {:>7.2}",
            p.albedo,
            p.g,
            p.sigma_t,
            p.theta.to_degrees(),
            c.found[0],
            100.0 * c.found[1] / c.found[0],
            p.radiance,
            100.0 * p.standard_error / p.radiance,
            c.z
        ));
    }
    let [sum, limit] = chi_squared(comparisons);
    lines.push(format!(
        "chi^2 {sum:.1} of {} points (at most {limit:.1} in 999 of 1000 cases)",
        comparisons.len()
    ));
    lines.join("\n")
}
