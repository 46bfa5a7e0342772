//! Time against error as an SVG.

use std::fmt::Write;

use super::SceneReport;
use super::text::{escape, milliseconds, number};
use crate::technique::NAMES;

const WIDTH: f64 = 820.0;
const HEIGHT: f64 = 440.0;
/// Left, right, top, bottom.
const MARGINS: [f64; 4] = [64.0, 180.0, 16.0, 52.0];

/// Colours that all kinds of sight tell apart, as of Okabe and Ito.
const COLORS: [&str; 8] = [
    "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000", "#8c6d31",
];

/// Markers about the origin, so that colour is not all that tells techniques apart.
const MARKERS: [&str; 8] = [
    "M-5,0a5,5 0 1,0 10,0a5,5 0 1,0 -10,0z",
    "M-4.5,-4.5h9v9h-9z",
    "M0,-6l5.5,10h-11z",
    "M0,-6.5l6.5,6.5l-6.5,6.5l-6.5,-6.5z",
    "M0,6l5.5,-10h-11z",
    "M-2,-6h4v4h4v4h-4v4h-4v-4h-4v-4h4z",
    "M-6,-3l6,-3l6,3v6l-6,3l-6,-3z",
    "M-6,0l3,-6h6l3,6l-3,6h-6z",
];

/// From seconds and FLIP to places in the picture.
struct Scales {
    /// Powers of ten of the milliseconds at the left and the right.
    time: [f64; 2],
    flip: f64,
}

impl Scales {
    fn new(points: &[(f64, f64)]) -> Self {
        let powers = points.iter().map(|(s, _)| (1e3 * s.max(1e-9)).log10());
        let lowest = powers.clone().fold(f64::INFINITY, f64::min);
        let highest = powers.fold(f64::NEG_INFINITY, f64::max);
        let time = if lowest <= highest {
            // Room for markers, and for a single point.
            [lowest - 0.1, highest + 0.1]
        } else {
            [0.0, 1.0]
        };
        let largest = points.iter().map(|p| p.1).fold(0.0, f64::max);
        Self {
            time,
            flip: if largest > 0.0 { 1.05 * largest } else { 1.0 },
        }
    }

    fn x(&self, milliseconds: f64) -> f64 {
        let share = (milliseconds.max(1e-6).log10() - self.time[0]) / (self.time[1] - self.time[0]);
        MARGINS[0] + share * (WIDTH - MARGINS[0] - MARGINS[1])
    }

    fn y(&self, flip: f64) -> f64 {
        HEIGHT - MARGINS[3] - flip / self.flip * (HEIGHT - MARGINS[2] - MARGINS[3])
    }

    /// Milliseconds worth a line: powers of ten, and 2 and 5 times them.
    fn times(&self) -> Vec<f64> {
        let powers = self.time[0].floor() as i32..=self.time[1].ceil() as i32;
        let steps = powers.flat_map(|p| [1.0, 2.0, 5.0].map(|f| f * 10f64.powi(p)));
        let within = |t: &f64| (self.time[0]..=self.time[1]).contains(&t.log10());
        steps.filter(within).collect()
    }

    /// Errors worth a line.
    fn flips(&self) -> Vec<f64> {
        let power = 10f64.powf((self.flip / 4.0).log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0].map(|f| f * power);
        let step = step.into_iter().find(|s| self.flip / s <= 6.0);
        let step = step.unwrap_or(10.0 * power);
        (0..=6)
            .map(|i| f64::from(i) * step)
            .filter(|f| *f <= self.flip)
            .collect()
    }
}

/// Every setting of a scene by its time (logarithmic) and FLIP, with the front as a numbered line.
///
/// `id` begins the anchors of the table's rows that the markers lead to.
#[must_use]
pub fn plot(scene: &SceneReport, id: &str) -> String {
    let points: Vec<(usize, (f64, f64))> = scene
        .records
        .iter()
        .enumerate()
        .filter_map(|(i, r)| Some((i, r.outcome.measured()?)))
        .map(|(i, m)| (i, (m.seconds, m.errors.flip)))
        .collect();
    let places: Vec<_> = points.iter().map(|p| p.1).collect();
    let scales = Scales::new(&places);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" \
         font-family=\"sans-serif\" font-size=\"12\">\n<title>Time against FLIP, {}</title>\n",
        escape(&scene.name)
    );
    axes(&mut svg, &scales);
    front_line(&mut svg, scene, &scales);
    for (i, (seconds, flip)) in points {
        marker(&mut svg, scene, (i, seconds, flip), &scales, id);
    }
    numbers(&mut svg, scene, &scales);
    legend(&mut svg, scene);
    svg += "</svg>\n";
    svg
}

// Writing to a string cannot fail; the results below say nothing.

fn axes(svg: &mut String, scales: &Scales) {
    let [left, right, top, bottom] = MARGINS;
    let (end, floor) = (WIDTH - right, HEIGHT - bottom);
    for t in scales.times() {
        let (x, label) = (scales.x(t), label(t));
        let _ = writeln!(
            svg,
            "<line x1=\"{x:.1}\" y1=\"{top}\" x2=\"{x:.1}\" y2=\"{floor}\" stroke=\"#ddd\"/>\
             <text x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{label}</text>",
            floor + 18.0
        );
    }
    for f in scales.flips() {
        let y = scales.y(f);
        let label = label(f);
        let _ = writeln!(
            svg,
            "<line x1=\"{left}\" y1=\"{y:.1}\" x2=\"{end}\" y2=\"{y:.1}\" stroke=\"#ddd\"/>\
             <text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{label}</text>",
            left - 8.0,
            y + 4.0
        );
    }
    let (middle, height) = (0.5 * (left + end), 0.5 * (top + floor));
    let _ = writeln!(
        svg,
        "<path d=\"M{left},{top}V{floor}H{end}\" fill=\"none\" stroke=\"#333\"/>\n\
         <text x=\"{middle}\" y=\"{}\" text-anchor=\"middle\">milliseconds a frame, logarithmic</text>\n\
         <text transform=\"translate(16 {height}) rotate(-90)\" text-anchor=\"middle\">mean LDR-FLIP</text>",
        HEIGHT - 12.0
    );
}

/// A round number without an exponent.
fn label(value: f64) -> String {
    let text = format!("{value:.6}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

fn place(scene: &SceneReport, record: usize, scales: &Scales) -> Option<(f64, f64)> {
    let measured = scene.records.get(record)?.outcome.measured()?;
    let x = scales.x(1e3 * measured.seconds);
    Some((x, scales.y(measured.errors.flip)))
}

fn front_line(svg: &mut String, scene: &SceneReport, scales: &Scales) {
    let places = scene.front.iter().filter_map(|i| place(scene, *i, scales));
    let points: Vec<_> = places.map(|(x, y)| format!("{x:.1},{y:.1}")).collect();
    let _ = writeln!(
        svg,
        "<polyline class=\"front\" points=\"{}\" fill=\"none\" stroke=\"#999\" stroke-width=\"2\"/>",
        points.join(" ")
    );
}

fn marker(
    svg: &mut String,
    scene: &SceneReport,
    (i, seconds, flip): (usize, f64, f64),
    scales: &Scales,
    id: &str,
) {
    let configuration = &scene.records[i].configuration;
    let (color, shape) = look(&configuration.technique);
    let on_front = scene.place(i).is_some();
    let _ = writeln!(
        svg,
        "<a href=\"#{id}-{i}\"><path class=\"point\" transform=\"translate({:.1} {:.1})\" d=\"{shape}\" \
         fill=\"{color}\" fill-opacity=\"{}\" stroke=\"{color}\"><title>{} {}: {} ms, FLIP {}</title></path></a>",
        scales.x(1e3 * seconds),
        scales.y(flip),
        if on_front { 1.0 } else { 0.35 },
        escape(&configuration.technique),
        escape(&configuration.label()),
        milliseconds(seconds),
        number(flip)
    );
}

fn numbers(svg: &mut String, scene: &SceneReport, scales: &Scales) {
    for (n, i) in scene.front.iter().enumerate() {
        if let Some((x, y)) = place(scene, *i, scales) {
            let _ = writeln!(
                svg,
                "<text x=\"{:.1}\" y=\"{:.1}\" font-size=\"11\" font-weight=\"bold\">{}</text>",
                x + 7.0,
                y - 7.0,
                n + 1
            );
        }
    }
}

fn legend(svg: &mut String, scene: &SceneReport) {
    let mut names: Vec<&str> = Vec::new();
    for record in &scene.records {
        let name = record.configuration.technique.as_str();
        if !names.contains(&name) {
            names.push(name);
        }
    }
    let x = WIDTH - MARGINS[1] + 18.0;
    let mut y = MARGINS[2] + 12.0;
    for name in names {
        let (color, shape) = look(name);
        let _ = writeln!(
            svg,
            "<path transform=\"translate({x} {y})\" d=\"{shape}\" fill=\"{color}\"/>\
             <text x=\"{}\" y=\"{}\">{}</text>",
            x + 12.0,
            y + 4.0,
            escape(name)
        );
        y += 20.0;
    }
    let _ = writeln!(
        svg,
        "<line x1=\"{}\" y1=\"{y}\" x2=\"{}\" y2=\"{y}\" stroke=\"#999\" stroke-width=\"2\"/>\
         <text x=\"{}\" y=\"{}\">front (nothing beats it)</text>",
        x - 7.0,
        x + 7.0,
        x + 12.0,
        y + 4.0
    );
}

/// Colour and marker of a technique: the same in every study.
fn look(technique: &str) -> (&'static str, &'static str) {
    let index = NAMES.iter().position(|n| *n == technique);
    let index = index.unwrap_or(COLORS.len() - 1);
    (COLORS[index % COLORS.len()], MARKERS[index % MARKERS.len()])
}
