//! The comparison with a paper for people.

use super::paper::Column;
use super::report::{ModelReport, Pair, Report, RowReport, Summary, Time};
use crate::technique::size;

/// What was measured, and how.
pub(super) fn head(report: &Report) -> String {
    [
        format!(
            "{} on {} ({})",
            report.paper, report.device.name, report.device.driver
        ),
        format!(
            "{} x {} pixels; frames of the orbit: {}; rounds, models in turns: {}; medians of device times",
            report.image[0], report.image[1], report.frames, report.repeat
        ),
        report.note.clone(),
    ]
    .join("\n")
}

/// One row of the paper's table.
pub(super) fn row(r: &RowReport) -> String {
    let [x, y, z] = r.dims;
    let lights: Vec<_> = r.lights.iter().map(|spot| spot.name()).collect();
    let radius = r.radius_voxels;
    let radius = radius.map_or_else(String::new, |r| format!("radius {r} voxels, "));
    let mut lines = vec![
        String::new(),
        format!(
            "{}, {x} x {y} x {z}; stand-in: {}; {radius}g = {}, light {}",
            r.name,
            r.stand_in,
            r.phase_g,
            lights.join(" and ")
        ),
    ];
    if !r.remark.is_empty() {
        lines.push(format!("the paper: {}", r.remark));
    }
    lines.push(format!(
        "{:<20} {:<6} {:<18} {:>10} {:>10} {:>8}   {:<18} {:>8} {:>8}",
        "model", "figure", "time of", "ms", "/ unlit", "paper", "beside", "ratio", "paper"
    ));
    for model in &r.models {
        lines.extend(model.times.iter().map(|t| time(model, t)));
    }
    lines.extend(r.models.iter().map(memory));
    lines.join("\n")
}

fn time(model: &ModelReport, t: &Time) -> String {
    let Pair { here, paper } = t.over_unlit;
    let rival = t.over_rival.as_ref();
    let (name, over) = rival.map_or(("", String::new()), |r| {
        let ratios = format!("{:>8} {:>8}", number(r.ratio.here), number(r.ratio.paper));
        (r.model.name(), ratios)
    });
    let line = format!(
        "{:<20} {:<6} {:<18} {:>10.3} {:>10} {:>8}   {:<18} {over}",
        model.model.name(),
        model.figure.unwrap_or("-"),
        t.what.name(),
        1e3 * t.device_seconds.median,
        number(here),
        number(paper),
        name,
    );
    line.trim_end().to_owned()
}

/// What a model keeps; what takes less than a hundredth of it is summed up.
fn memory(model: &ModelReport) -> String {
    let large = |bytes: u64| bytes >= model.bytes / 100;
    let list = model.resources.iter();
    let mut parts: Vec<_> = list
        .clone()
        .filter(|r| large(r.bytes))
        .map(|r| format!("{} {}", r.name, size(r.bytes)))
        .collect();
    let small = list.map(|r| r.bytes).filter(|bytes| !large(*bytes));
    let small: u64 = small.sum();
    if small > 0 {
        parts.push(format!("others {}", size(small)));
    }
    format!(
        "{:<20} {} at rest beside volume and image: {}",
        model.model.name(),
        size(model.bytes),
        parts.join(", ")
    )
}

/// The ratios that the project aims at.
pub(super) fn summary(list: &[Summary]) -> String {
    let mut lines = vec![
        String::new(),
        format!(
            "{:<64} {:>8} {:>6} {:>8} {:>6} {:>6}",
            "medians over rows", "here", "rows", "paper", "rows", "goal"
        ),
    ];
    for s in list {
        let (what, over) = match s.what {
            Column::Rendering => (s.what.name().to_owned(), s.over.name()),
            change => (format!("{} change", change.name()), s.over.name()),
        };
        let goal = s
            .goal
            .map_or_else(|| "-".to_owned(), |goal| number(Some(goal)));
        let verdict = match s.reached {
            Some(true) => "   reached",
            Some(false) => "   not reached",
            None => "",
        };
        let name = format!("{}: {what} / {over}", s.model.name());
        lines.push(format!(
            "{name:<64} {:>8} {:>6} {:>8} {:>6} {goal:>6}{verdict}",
            number(Some(s.here)),
            s.rows,
            number(s.paper),
            s.paper_rows,
        ));
    }
    lines.join("\n")
}

/// Three digits, or a dash where there is no number.
fn number(value: Option<f64>) -> String {
    value.map_or_else(
        || "-".to_owned(),
        |v| {
            let digits = 2 - v.abs().max(f64::MIN_POSITIVE).log10().floor().max(-3.0) as i32;
            format!("{v:.*}", digits.max(0) as usize)
        },
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_three_digits() {
        let shown = [3.2, 31.36, 490.4, 1.0, 0.1, 0.015_686, 0.0].map(|v| number(Some(v)));
        assert_eq!(
            shown,
            ["3.20", "31.4", "490", "1.00", "0.100", "0.0157", "0.00000"]
        );
        assert_eq!(number(None), "-");
    }
}
