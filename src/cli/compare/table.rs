//! The comparison for people: a name and its numbers a line.

use std::path::Path;

use crate::output::metrics::{Comparison, Errors, HdrFlip, Shown, ZScore};

/// Columns that a name takes.
const NAME: usize = 22;

/// All measures, grouped by what they are of.
pub(super) fn table(found: &Path, reference: &Path, c: &Comparison) -> String {
    let mut lines = vec![format!(
        "{} beside {} ({} x {})",
        found.display(),
        reference.display(),
        c.width,
        c.height
    )];
    let values = if c.hdr_flip.is_some() {
        "radiance"
    } else {
        "display values"
    };
    lines.push(values.to_owned());
    lines.extend(errors(&c.errors));
    lines.push(shown_heading(&c.shown));
    lines.extend(shown(&c.shown, c.hdr_flip.is_some()));
    if let Some(hdr_flip) = &c.hdr_flip {
        lines.push(hdr(hdr_flip));
    }
    if let Some(z) = &c.z_score {
        lines.push("z-scores".to_owned());
        lines.extend(scores(z));
    }
    lines.join("\n")
}

fn row(name: &str, value: impl std::fmt::Display) -> String {
    format!("  {name:<NAME$}{value}")
}

/// Five significant digits, so that columns stay readable over all magnitudes.
fn number(value: f64) -> String {
    let magnitude = value.abs();
    if value == 0.0 || (1e-3..1e5).contains(&magnitude) {
        let digits = if value == 0.0 {
            0
        } else {
            (4 - magnitude.log10().floor() as i32).max(0)
        };
        format!("{value:.*}", digits as usize)
    } else {
        format!("{value:.4e}")
    }
}

fn maybe(value: Option<f64>) -> String {
    value.map_or_else(|| "-".to_owned(), number)
}

fn decibels(value: f64) -> String {
    if value == f64::INFINITY {
        return "infinite (equal)".to_owned();
    }
    format!("{value:.2} dB")
}

fn errors(e: &Errors) -> Vec<String> {
    let [r, g, b] = e.channel_bias.map(number);
    let percent = |share: Option<f64>| {
        share.map_or_else(|| "-".to_owned(), |s| format!("{} %", number(100.0 * s)))
    };
    let [rr, rg, rb] = e.relative_channel_bias.map(percent);
    let l = &e.largest;
    let mut rows = vec![row("RMSE", number(e.rmse))];
    if let Some(relative) = e.relative_mse {
        let text = format!("{} (epsilon {})", number(relative), e.relative_epsilon);
        rows.push(row("relative MSE", text));
    }
    rows.extend([
        row("bias", format!("{} (R {r}, G {g}, B {b})", number(e.bias))),
        row(
            "relative bias",
            format!("{} (R {rr}, G {rg}, B {rb})", percent(e.relative_bias)),
        ),
        row(
            "PSNR",
            format!("{} (peak {})", decibels(e.psnr), number(e.peak)),
        ),
        row(
            "largest difference",
            format!(
                "{} in {} of column {}, row {}: {} beside {}",
                number(l.difference),
                l.channel,
                l.x,
                l.y,
                number(l.found),
                number(l.reference)
            ),
        ),
        row("alpha RMSE", number(e.alpha_rmse)),
    ]);
    rows
}

fn shown_heading(s: &Shown) -> String {
    match (s.stops, s.tone_map) {
        (Some(stops), Some(map)) => {
            format!("as shown at {stops:+.3} stops, tone map {}", map.name())
        }
        _ => "as shown".to_owned(),
    }
}

fn shown(s: &Shown, is_radiance: bool) -> Vec<String> {
    let mut rows = Vec::new();
    // Of PNGs these stand above already.
    if is_radiance {
        rows.push(row("RMSE", number(s.rmse)));
        rows.push(row("PSNR", format!("{} (peak 1)", decibels(s.psnr))));
    }
    let flip = format!(
        "{} (largest {}; {:.1} pixels per degree)",
        number(s.flip.mean),
        number(s.flip.largest),
        s.pixels_per_degree
    );
    rows.extend([row("SSIM", maybe(s.ssim)), row("LDR-FLIP", flip)]);
    rows
}

fn hdr(h: &HdrFlip) -> String {
    let e = h.exposures;
    let text = format!(
        "{} (largest {}; {} exposures from {:+.2} to {:+.2} stops)",
        number(h.error.mean),
        number(h.error.largest),
        e.count,
        e.start,
        e.stop
    );
    row("HDR-FLIP", text)
}

fn scores(z: &ZScore) -> Vec<String> {
    let [r, g, b] = z.mean.map(maybe);
    let share = |s: Option<f64>| s.map(|s| 100.0 * s);
    let mut rows = vec![
        row("RMS z", format!("{} (noise: 1)", maybe(z.rms))),
        row(
            "beyond 3",
            format!(
                "{} % (noise: 0.27 %) of {} channels",
                maybe(share(z.share_beyond_3)),
                z.channels
            ),
        ),
        row(
            "z of the means",
            format!(
                "R {r}, G {g}, B {b}; by chance with probability {}",
                maybe(z.mean_probability)
            ),
        ),
    ];
    if let Some(l) = &z.largest {
        let text = format!(
            "{} in {} of column {}, row {}; by chance with probability {}",
            number(l.z),
            l.channel,
            l.x,
            l.y,
            number(l.probability)
        );
        rows.push(row("largest z", text));
    }
    let exact = format!(
        "{} equal, {} unequal (by at most {})",
        z.exact.equal,
        z.exact.unequal,
        number(z.exact.largest_difference)
    );
    rows.push(row("without variance", exact));
    rows
}
