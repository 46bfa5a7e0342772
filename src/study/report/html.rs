//! A page that needs no other file.

use std::fmt::Write;
use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use super::plot::plot;
use super::text::{escape, maybe, milliseconds, number, percent};
use super::{Report, SceneReport};
use crate::study::{Measured, Outcome, Pictures, Stage};
use crate::technique::{KNOBS, Knobs, size};

const STYLE: &str = "body{font:15px/1.45 sans-serif;max-width:1500px;margin:2em auto;padding:0 1em;color:#111;\
background:#fff}table{border-collapse:collapse;font-size:13px}th,td{padding:3px 8px;border-bottom:1px solid #ddd;\
text-align:right;vertical-align:top}th{position:sticky;top:0;background:#fff}td.text,th.text{text-align:left}\
tr.front td{background:#f2f7ff}tr:target td{background:#fff3c4}img{display:block;width:112px;\
image-rendering:auto}dl{display:grid;grid-template-columns:max-content auto;gap:2px 16px}dd{margin:0;\
overflow-wrap:anywhere}svg{width:100%;max-width:900px}code{font-size:12px}\
p.warning{border-left:4px solid #d55e00;padding-left:8px}";

/// The whole study as a page, pictures included. It is well-formed XML as well.
#[must_use]
pub fn to_html(report: &Report, pictures: &Pictures) -> String {
    let mut page = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n\
         <meta name=\"viewport\" content=\"width=device-width\"/>\n\
         <title>Speed against accuracy</title>\n<style>{STYLE}</style>\n</head>\n<body>\n\
         <h1>Speed against accuracy</h1>\n<dl>\n"
    );
    term(&mut page, "Device", &report.device);
    term(&mut page, "Driver", &report.driver);
    term(&mut page, "Vulkan", &report.vulkan);
    term(&mut page, "Tyndall", &report.tyndall);
    page += "</dl>\n";
    page += &explanation(report);
    for (i, scene) in report.scenes.iter().enumerate() {
        section(&mut page, scene, pictures, &format!("s{i}"));
    }
    page += "</body>\n</html>\n";
    page
}

fn term(page: &mut String, name: &str, value: &str) {
    let _ = writeln!(page, "<dt>{}</dt><dd>{}</dd>", escape(name), escape(value));
}

/// What the columns mean, and what must not be read into them.
fn explanation(report: &Report) -> String {
    let mut text = format!(
        "<p><b>Time</b> is the host's for a frame after a change of the camera, median of {}; <b>first</b> is \
         that of the first frame, uploads and pipelines included. Memory is the device's, as planned. Bias and \
         RMSE are of linear radiance, the bias as a share of the reference's mean; FLIP and SSIM are of both images as \
         shown with the scene's exposure and tone map. Numbers on the front count from the fastest.</p>\n\
         <p>The reference is noisy itself: its relative standard error stands beside each scene, and errors \
         of that size say nothing.</p>\n",
        report.frames
    );
    for Knobs {
        technique, lacks, ..
    } in KNOBS
    {
        let mut records = report.scenes.iter().flat_map(|s| &s.records);
        let is_there = records.any(|r| r.configuration.technique == *technique);
        if let (true, Some(lacks)) = (is_there, lacks) {
            let _ = writeln!(
                text,
                "<p><code>{technique}</code> computes another model than the reference: its images lack {lacks}. \
                 Its errors include that difference, which no setting removes.</p>"
            );
        }
    }
    text
}

fn section(page: &mut String, scene: &SceneReport, pictures: &Pictures, id: &str) {
    let reference = &scene.reference;
    let _ = write!(page, "<h2>{}</h2>\n<dl>\n", escape(&scene.name));
    term(page, "Scene", &scene.scene_hash);
    term(page, "Voxels", &scene.voxels_hash);
    let [width, height] = scene.image;
    term(page, "Image", &format!("{width} x {height} pixels"));
    let about = format!(
        "path_trace, {} samples a pixel, relative standard error {}, {} s",
        reference.samples,
        percent(reference.relative_error),
        number(reference.seconds)
    );
    term(page, "Reference", &about);
    page.push_str("</dl>\n");
    for warning in &scene.warnings {
        let _ = writeln!(page, "<p class=\"warning\">{}</p>", escape(warning));
    }
    let picture = picture(&pictures.image(&reference.key), "the reference");
    let _ = write!(page, "{picture}\n<figure>\n{}</figure>\n", plot(scene, id));
    table(page, scene, pictures, id);
}

fn table(page: &mut String, scene: &SceneReport, pictures: &Pictures, id: &str) {
    page.push_str(
        "<table>\n<thead><tr><th>front</th><th class=\"text\">image</th><th class=\"text\">FLIP map</th>\
         <th class=\"text\">technique</th><th>time, ms</th><th>first, ms</th>\
         <th class=\"text\">stages: ms (first)</th><th>memory</th><th>bias</th><th>RMSE</th><th>FLIP</th>\
         <th>HDR-FLIP</th><th>SSIM</th></tr></thead>\n<tbody>\n",
    );
    for (i, record) in scene.records.iter().enumerate() {
        let place = scene.place(i);
        let class = if place.is_some() {
            " class=\"front\""
        } else {
            ""
        };
        let number = place.map_or_else(String::new, |n| n.to_string());
        let configuration = &record.configuration;
        let name = format!(
            "<td class=\"text\"><b>{}</b><br/>{}<br/><code>{}</code></td>",
            escape(&configuration.technique),
            escape(&configuration.label()),
            escape(&configuration.options())
        );
        let _ = write!(page, "<tr id=\"{id}-{i}\"{class}><td>{number}</td>");
        match &record.outcome {
            Outcome::Measured(measured) => {
                let image = picture(&pictures.image(&record.key), "the image");
                let error = picture(&pictures.error(&record.key), "its FLIP map");
                let _ = write!(page, "<td>{image}</td><td>{error}</td>{name}");
                page.push_str(&numbers(measured));
            }
            Outcome::Failed(why) => {
                let why = escape(why);
                let _ = write!(
                    page,
                    "<td></td><td></td>{name}<td class=\"text\" colspan=\"9\">not measured: {why}</td>"
                );
            }
        }
        page.push_str("</tr>\n");
    }
    page.push_str("</tbody>\n</table>\n");
}

fn numbers(measured: &Measured) -> String {
    let e = &measured.errors;
    let stage = |s: &Stage| {
        format!(
            "{} {} ({})",
            escape(&s.name),
            milliseconds(s.seconds),
            milliseconds(s.first_seconds)
        )
    };
    let stages: Vec<_> = measured.stages.iter().map(stage).collect();
    let bias = e.relative_bias.map_or_else(|| number(e.bias), percent);
    let samples = measured.samples;
    let samples = samples.map_or_else(String::new, |n| format!("<br/>{n} samples"));
    format!(
        "<td>{}{samples}</td><td>{}</td><td class=\"text\">{}</td><td>{}</td><td>{bias}</td><td>{}</td>\
         <td>{}</td><td>{}</td><td>{}</td>",
        milliseconds(measured.seconds),
        milliseconds(measured.first_seconds),
        stages.join("<br/>"),
        size(measured.bytes),
        number(e.rmse),
        number(e.flip),
        maybe(e.hdr_flip),
        maybe(e.ssim)
    )
}

/// A thumbnail inside the page; a dash where it is not there.
fn picture(path: &Path, what: &str) -> String {
    std::fs::read(path).map_or_else(
        |_| "\u{2013}".to_owned(),
        |bytes| {
            let data = STANDARD.encode(bytes);
            format!("<img alt=\"{what}\" src=\"data:image/png;base64,{data}\"/>")
        },
    )
}
