//! The paper's Fig. 5 as an SVG: log10 radiance over angle and extinction, for three anisotropies.

use std::fmt::Write;
use std::io::Write as _;
use std::path::Path;

use base64::Engine;

use super::super::CliError;
use super::Source;
use crate::output::{OutputError, atomic};
use crate::technique::ambient_scattering::table::Slice;

/// Anisotropies of the panels, as in the paper.
const GS: [f64; 3] = [-0.8, 0.0, 0.8];
/// Width of a panel and of what it is apart from the next, height, and place of the first.
const PANEL: [f64; 2] = [256.0, 44.0];
const HEIGHT: f64 = 256.0;
const ORIGIN: [f64; 2] = [64.0, 44.0];
/// Pixels of a panel's picture along each side.
const PIXELS: u32 = 512;
/// Powers of ten at the ends of the colours.
const POWERS: [f64; 2] = [-8.0, 1.0];
/// Extinction at the top.
const SIGMA_MAX: f64 = 20.0;

/// Dark to light evenly for the eye, told apart by all kinds of sight (the colours of viridis).
const COLORS: [[f64; 3]; 9] = [
    [68.0, 1.0, 84.0],
    [71.0, 44.0, 122.0],
    [59.0, 81.0, 139.0],
    [44.0, 113.0, 142.0],
    [33.0, 144.0, 141.0],
    [39.0, 173.0, 129.0],
    [92.0, 200.0, 99.0],
    [170.0, 220.0, 50.0],
    [253.0, 231.0, 37.0],
];

pub(super) fn write(path: &Path, source: &Source) -> Result<(), CliError> {
    atomic::check(path)?;
    let slice = |g| -> Result<Slice, CliError> {
        Ok(match source {
            Source::Shipped => Source::shipped()?.slice(g, 0.9),
            Source::Table(table) => table.slice(g),
        })
    };
    let slices = [slice(GS[0])?, slice(GS[1])?, slice(GS[2])?];
    let svg = svg(path, &slices)?;
    Ok(atomic::write(path, |file| file.write_all(svg.as_bytes()))?)
}

// Writing to a string cannot fail; the results below say nothing.

fn svg(path: &Path, slices: &[Slice; 3]) -> Result<String, OutputError> {
    let width = ORIGIN[0] + 3.0 * (PANEL[0] + PANEL[1]) + 70.0;
    let height = ORIGIN[1] + HEIGHT + 56.0;
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" role=\"img\" \
         font-family=\"sans-serif\" font-size=\"12\">\n<title>Preintegration table, albedo {}</title>\n\
         <rect width=\"{width}\" height=\"{height}\" fill=\"#fff\"/>\n",
        slices[0].albedo
    );
    for (i, slice) in slices.iter().enumerate() {
        let left = ORIGIN[0] + i as f64 * (PANEL[0] + PANEL[1]);
        panel(&mut svg, path, slice, left)?;
        axes(&mut svg, slice, left, i == 0);
    }
    color_bar(&mut svg, ORIGIN[0] + 3.0 * (PANEL[0] + PANEL[1]) - 14.0);
    svg += "</svg>\n";
    Ok(svg)
}

/// The picture of a slice, with a line at every power of ten.
fn panel(svg: &mut String, path: &Path, slice: &Slice, left: f64) -> Result<(), OutputError> {
    let power = |x: u32, y: u32| {
        let theta = f64::from(x) / f64::from(PIXELS) * std::f64::consts::PI;
        let sigma_t = (1.0 - f64::from(y) / f64::from(PIXELS)) * SIGMA_MAX;
        slice.radiance(theta, sigma_t).log10()
    };
    let mut pixels = Vec::new();
    for y in 0..PIXELS {
        for x in 0..PIXELS {
            let here = power(x, y);
            let crosses = |there: f64| there.floor() != here.floor();
            let line = crosses(power(x + 1, y)) || crosses(power(x, y + 1));
            let shade = if line { 0.55 } else { 1.0 };
            pixels.extend(color(here).map(|c| (shade * c) as u8));
        }
    }
    let picture = encode(path, &pixels)?;
    let _ = writeln!(
        svg,
        "<image x=\"{left}\" y=\"{}\" width=\"{}\" height=\"{HEIGHT}\" preserveAspectRatio=\"none\" \
         href=\"data:image/png;base64,{picture}\"/>",
        ORIGIN[1], PANEL[0]
    );
    Ok(())
}

fn encode(path: &Path, pixels: &[u8]) -> Result<String, OutputError> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, PIXELS, PIXELS);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_compression(png::Compression::High);
    let written = encoder
        .write_header()
        .and_then(|mut w| w.write_image_data(pixels));
    written.map_err(|e| OutputError::Io {
        path: path.to_owned(),
        action: "encode its picture",
        source: e.into(),
    })?;
    Ok(base64::engine::general_purpose::STANDARD.encode(bytes))
}

fn color(power: f64) -> [f64; 3] {
    let last = COLORS.len() - 1;
    let share = (power - POWERS[0]) / (POWERS[1] - POWERS[0]);
    let at = share.clamp(0.0, 1.0) * last as f64;
    let i = (at as usize).min(last - 1);
    let mix = at - i as f64;
    [0, 1, 2].map(|c| COLORS[i][c] + mix * (COLORS[i + 1][c] - COLORS[i][c]))
}

fn axes(svg: &mut String, slice: &Slice, left: f64, labelled: bool) {
    let (top, bottom, middle) = (ORIGIN[1], ORIGIN[1] + HEIGHT, left + 0.5 * PANEL[0]);
    let _ = writeln!(
        svg,
        "<rect x=\"{left}\" y=\"{top}\" width=\"{}\" height=\"{HEIGHT}\" fill=\"none\" stroke=\"#333\"/>\n\
         <text x=\"{middle}\" y=\"{}\" text-anchor=\"middle\" font-size=\"14\">g = {}</text>\n\
         <text x=\"{middle}\" y=\"{}\" text-anchor=\"middle\">\u{3b8}, degrees</text>",
        PANEL[0],
        top - 12.0,
        slice.g,
        bottom + 38.0
    );
    for degrees in [0.0, 45.0, 90.0, 135.0, 180.0] {
        let x = left + degrees / 180.0 * PANEL[0];
        let _ = writeln!(
            svg,
            "<path d=\"M{x:.1},{bottom}v5\" stroke=\"#333\"/>\
             <text x=\"{x:.1}\" y=\"{}\" text-anchor=\"middle\">{degrees}</text>",
            bottom + 18.0
        );
    }
    for sigma in [0.0, 5.0, 10.0, 15.0, 20.0] {
        let y = bottom - sigma / SIGMA_MAX * HEIGHT;
        let _ = writeln!(svg, "<path d=\"M{left},{y:.1}h-5\" stroke=\"#333\"/>");
        if labelled {
            let (x, y) = (left - 9.0, y + 4.0);
            let _ = writeln!(
                svg,
                "<text x=\"{x}\" y=\"{y:.1}\" text-anchor=\"end\">{sigma}</text>"
            );
        }
    }
    if labelled {
        let (x, y) = (left - 40.0, top + 0.5 * HEIGHT);
        let _ = writeln!(
            svg,
            "<text transform=\"translate({x} {y}) rotate(-90)\" text-anchor=\"middle\">\
             extinction times radius, \u{3c3}<tspan dy=\"3\" font-size=\"9\">t</tspan></text>"
        );
    }
}

fn color_bar(svg: &mut String, left: f64) {
    const STEPS: u32 = 128;
    let (top, bottom) = (ORIGIN[1], ORIGIN[1] + HEIGHT);
    let span = POWERS[1] - POWERS[0];
    let step = HEIGHT / f64::from(STEPS);
    for i in 0..STEPS {
        let power = POWERS[0] + span * (f64::from(i) + 0.5) / f64::from(STEPS);
        let [r, g, b] = color(power).map(|c| c as u8);
        let y = bottom - f64::from(i + 1) * step;
        let _ = writeln!(
            svg,
            "<rect x=\"{left}\" y=\"{y:.2}\" width=\"16\" height=\"{:.2}\" fill=\"#{r:02x}{g:02x}{b:02x}\"/>",
            step + 0.3
        );
    }
    let _ = writeln!(
        svg,
        "<rect x=\"{left}\" y=\"{top}\" width=\"16\" height=\"{HEIGHT}\" fill=\"none\" stroke=\"#333\"/>\n\
         <text x=\"{}\" y=\"{}\" text-anchor=\"middle\">radiance, 1/sr</text>",
        left + 24.0,
        top - 12.0
    );
    for power in POWERS[0] as i32..=POWERS[1] as i32 {
        let y = bottom - (f64::from(power) - POWERS[0]) / span * HEIGHT;
        let _ = writeln!(
            svg,
            "<path d=\"M{:.1},{y:.1}h5\" stroke=\"#333\"/><text x=\"{:.1}\" y=\"{:.1}\">10\
             <tspan dy=\"-5\" font-size=\"9\">{power}</tspan></text>",
            left + 16.0,
            left + 25.0,
            y + 4.0
        );
    }
}
