//! `tyndall bench --paper`: a paper's table, its ratios beside those of this machine.

use super::paper::{Row, Table};
use super::report::{self, Report};
use super::stand_in;
use super::turns::{self, Counts};
use super::{BenchArgs, Paper, ament2013, kniss2003, text};
use crate::cli::input::size;
use crate::cli::progress::Progress;
use crate::cli::{CliError, Global, print, print_json};

/// Pixels of the papers' images.
const SIZE: &str = "512x512";

/// What a reader must know of the volumes.
const NOTE: &str = "Data sets are stand-ins: formulas on grids of the sizes in the paper, with transfer \
                    functions and views of their own.\nCompare ratios, not times.";

impl Paper {
    const fn table(self) -> &'static Table {
        match self {
            Self::Ament2013 => &ament2013::TABLE,
            Self::Kniss2003 => &kniss2003::TABLE,
        }
    }
}

pub(super) fn run(global: &Global, args: &BenchArgs, paper: Paper) -> Result<(), CliError> {
    let image = size(args.size.as_deref().unwrap_or(SIZE))?;
    let table = paper.table();
    let rows = chosen(table.rows, &args.rows)?;
    let device = global.open_device()?;
    let counts = Counts {
        frames: args.frames,
        rounds: args.repeat,
    };
    let mut report = Report {
        paper: table.title,
        unlit: table.unlit,
        device: device.info().clone(),
        image: [0; 2],
        frames: args.frames,
        repeat: args.repeat,
        note: format!("{NOTE} {}", table.note),
        rows: Vec::new(),
        summary: Vec::new(),
    };
    let mut progress = Progress::new(global.quiet);
    let mut measured = Vec::new();
    for (n, row) in (1..).zip(&rows) {
        let phase = format!("{} ({n} of {})", row.name, rows.len());
        progress.update(&phase, 0, 1);
        let scene = stand_in::scene(row, &image)?;
        let times = turns::measure(&device, (table, row, &scene), counts, &mut |done, total| {
            progress.update(&phase, done, total);
        })?;
        progress.finish();
        report.image = [scene.image.width, scene.image.height];
        report.rows.push(report::row(table, row, &times));
        measured.push((*row, times));
        if !args.json {
            // A row takes minutes without a GPU: show it once it is there.
            if n == 1 {
                print(&text::head(&report))?;
            }
            report
                .rows
                .last()
                .map_or(Ok(()), |r| print(&text::row(r)))?;
        }
    }
    report.summary = report::summary(table, &measured);
    if args.json {
        print_json(&report)
    } else {
        print(&text::summary(&report.summary))
    }
}

/// The rows that were asked for, in the table's order; all without a wish.
fn chosen<'a>(rows: &'a [Row], wishes: &[String]) -> Result<Vec<&'a Row>, CliError> {
    let fits = |(n, row): &(usize, &Row), wish: &str| {
        let wish = wish.trim().to_lowercase();
        let named = !wish.is_empty() && row.name.to_lowercase().contains(&wish);
        named || wish.parse() == Ok(*n)
    };
    let numbered: Vec<(usize, &Row)> = (1..).zip(rows).collect();
    let unknown = |wish: &&String| !numbered.iter().any(|row| fits(row, wish));
    if let Some(wish) = wishes.iter().find(unknown) {
        let names = numbered.iter().map(|(n, row)| format!("{n} {}", row.name));
        let names: Vec<_> = names.collect();
        return Err(CliError::Usage(format!(
            "--rows {wish}: expected numbers of rows or parts of their names: {}",
            names.join(", ")
        )));
    }
    let wanted = |row: &(usize, &Row)| wishes.is_empty() || wishes.iter().any(|w| fits(row, w));
    let kept = numbered.into_iter().filter(wanted);
    Ok(kept.map(|(_, row)| row).collect())
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may panic")]
mod tests {
    use super::*;

    #[test]
    fn rows_are_chosen_by_number_or_part_of_a_name() {
        let names = |wishes: &[&str]| {
            let wishes: Vec<_> = wishes.iter().map(ToString::to_string).collect();
            let rows = chosen(&ament2013::ROWS, &wishes).unwrap();
            rows.iter().map(|r| r.name).collect::<Vec<_>>()
        };
        assert_eq!(names(&[]).len(), 7);
        assert_eq!(names(&["6", "supernova"]), ["Supernova", "Buoyancy Flow"]);
        assert_eq!(names(&["manix"]), ["Manix (Tiss.)", "Manix (Skel.)"]);
        for wrong in ["8", "0", "engine", ""] {
            let error = chosen(&ament2013::ROWS, &[wrong.to_owned()]).unwrap_err();
            assert!(error.to_string().contains("7 Boundary Layer"), "{error}");
        }
    }
}
