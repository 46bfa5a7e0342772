//! `tyndall render`.

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use serde_json::json;

use super::auto::{self, AutoArgs};
use super::input::{SceneArgs, size};
use super::progress::Progress;
use super::{CliError, Global, print, print_json, sequence};
use crate::gpu::Device;
use crate::output::png::{BitDepth, PngOptions};
use crate::output::tone_map::{Alpha, ToneMapping, expose};
use crate::output::{Image, Metadata, Variance, atomic, exr, json as json_file, png};
use crate::scene::file::describe;
use crate::scene::{Scene, ToneMap};
use crate::study::Goal;
use crate::technique::{FrameReport, Renderer};

/// Render a scene, a volume file or a procedural volume to PNG, EXR and JSON.
#[derive(Args)]
pub(super) struct RenderArgs {
    #[command(flatten)]
    pub(super) scene: SceneArgs,
    /// Output file; may be given several times. The ending decides: .png (display), .exr (linear
    /// float radiance, with its variance where the technique estimates it), .json (settings, times,
    /// bytes). {} in the name stands for the time step; several steps need it, but for a .json, which
    /// tells of all of them without it. Default: NAME.png, or NAME_{}.png.
    #[arg(long, short, value_name = "FILE")]
    output: Vec<PathBuf>,
    #[command(flatten)]
    auto: AutoArgs,
    /// Image size in pixels.
    #[arg(long, value_name = "WxH")]
    size: Option<String>,
    /// Bits a channel of the PNG.
    #[arg(long, default_value = "8", value_parser = ["8", "16"])]
    bits: String,
    /// Keep transparency in the PNG instead of the background.
    #[arg(long)]
    alpha: bool,
    /// Exposure of the PNG in stops, or `auto`; several time steps take that of the first.
    #[arg(long, value_name = "STOPS|auto", allow_hyphen_values = true)]
    exposure: Option<String>,
    /// Tone map of the PNG.
    #[arg(long)]
    tone_map: Option<ToneMap>,
    /// Print settings, times and bytes as JSON.
    #[arg(long)]
    pub(super) json: bool,
}

/// A finished image.
pub(super) struct Shot<'a> {
    pub(super) renderer: &'a Renderer,
    pub(super) image: &'a Image,
    pub(super) stops: f32,
    pub(super) report: &'a serde_json::Value,
}

pub(super) fn run(global: &Global, args: &RenderArgs) -> Result<(), CliError> {
    let goal = args.auto.goal(args.scene.is_auto())?;
    match (args.scene.steps(), goal) {
        (None, _) => one_step(global, args, goal),
        (Some(steps), None) => sequence::run(global, args, steps),
        (Some(_), Some(_)) => Err(CliError::Usage(
            "--technique auto: found several time steps, expected one".to_owned(),
        )),
    }
}

fn one_step(global: &Global, args: &RenderArgs, goal: Option<Goal>) -> Result<(), CliError> {
    let start = Instant::now();
    let mut outputs = outputs(args, false)?;
    let more = overrides(args)?;
    let file = args.scene.open(&more)?;
    if outputs.iter().any(|p| sequence::has_place(p)) {
        let steps = file.time_steps()?;
        for path in &mut outputs {
            *path = sequence::filled(path, file.time(), steps);
        }
    }
    let scene = args.scene.resolve(global, &file)?;
    let device = global.open_device()?;
    let (renderer, image, frame, found) = match goal {
        Some(goal) => {
            let found = auto::render(global, &args.scene, &args.auto, &more, scene, &device, goal)?;
            (found.renderer, found.image, found.frame, Some(found.about))
        }
        None => {
            let (renderer, image, frame) = as_told(global, &device, scene)?;
            (renderer, image, frame, None)
        }
    };
    let stops = expose(&image, renderer.scene().image.exposure);
    let mut report = report(&renderer, &device, &image, &frame, stops);
    if let Some(about) = &found {
        report["auto"] = about.report();
    }
    let shot = Shot {
        renderer: &renderer,
        image: &image,
        stops,
        report: &report,
    };
    write(args, &outputs, &shot, &device, None)?;
    if args.json {
        return print_json(&report);
    }
    if !global.quiet {
        if let Some(about) = &found {
            print(&about.sentence())?;
        }
        let device_seconds: f64 = frame.stages.iter().map(|s| s.seconds).sum();
        let names: Vec<_> = outputs.iter().map(|p| p.display().to_string()).collect();
        let samples = frame
            .samples
            .map_or(String::new(), |n| format!(", {n} samples a pixel"));
        print(&format!(
            "{} in {:.2} s (device {:.3} s{samples}) on {}",
            names.join(", "),
            start.elapsed().as_secs_f64(),
            device_seconds,
            device.info().name
        ))?;
    }
    Ok(())
}

/// Renders with the technique that the scene names.
fn as_told(
    global: &Global,
    device: &Device,
    scene: Scene,
) -> Result<(Renderer, Image, FrameReport), CliError> {
    let mut renderer = Renderer::new(device, scene)?;
    let mut progress = Progress::new(global.quiet);
    let rendered = renderer.render(&mut |phase, done, total| progress.update(phase, done, total));
    progress.finish();
    let (image, frame) = rendered?;
    Ok((renderer, image, frame))
}

/// Writes an image to files, each as its ending says.
pub(super) fn write(
    args: &RenderArgs,
    files: &[PathBuf],
    shot: &Shot<'_>,
    device: &Device,
    step: Option<u32>,
) -> Result<(), CliError> {
    let scene = shot.renderer.scene();
    let metadata = metadata(scene, device, step);
    for path in files {
        match ending(path).as_str() {
            "exr" => write_exr(path, shot.renderer, shot.image, &metadata)?,
            "json" => json_file::write(path, shot.report)?,
            _ => {
                let options = png_options(args, scene, shot.stops);
                png::write(path, shot.image, &options, &metadata)?;
            }
        }
    }
    Ok(())
}

/// The files to write; unknown endings and missing folders are refused before any work is done.
pub(super) fn outputs(args: &RenderArgs, several: bool) -> Result<Vec<PathBuf>, CliError> {
    if args.output.is_empty() {
        let place = if several { "_{}" } else { "" };
        let name = format!("{}{place}.png", args.scene.name());
        return Ok(vec![PathBuf::from(name)]);
    }
    for path in &args.output {
        if !["png", "exr", "json"].contains(&ending(path).as_str()) {
            return Err(CliError::Usage(format!(
                "--output {}: expected a file ending in .png, .exr or .json",
                path.display()
            )));
        }
    }
    for path in &args.output {
        atomic::check(path)?;
    }
    Ok(args.output.clone())
}

/// The ending of a file's name, without its dot.
pub(super) fn ending(path: &Path) -> String {
    path.extension()
        .map(|e| e.to_string_lossy().to_lowercase())
        .unwrap_or_default()
}

/// Options that stand for keys of the scene.
pub(super) fn overrides(args: &RenderArgs) -> Result<Vec<String>, CliError> {
    let mut list = Vec::new();
    if let Some(text) = &args.size {
        list.extend(size(text)?);
    }
    if let Some(exposure) = &args.exposure {
        list.push(format!("image.exposure={exposure}"));
    }
    if let Some(tone_map) = args.tone_map {
        list.push(format!("image.tone_map={}", tone_map.name()));
    }
    Ok(list)
}

/// Everything a program may want to know about the render.
pub(super) fn report(
    renderer: &Renderer,
    device: &Device,
    image: &Image,
    frame: &FrameReport,
    stops: f32,
) -> serde_json::Value {
    let scene = renderer.scene();
    json!({
        "tyndall": env!("CARGO_PKG_VERSION"),
        "device": device.info(),
        "scene": describe(scene),
        "plan": renderer.plan(),
        "bytes_planned": renderer.plan().bytes(),
        "bytes_allocated": device.live_allocations().iter().map(|a| a.bytes).sum::<u64>(),
        "frame": frame,
        "exposure_stops": stops,
        "tone_map": scene.image.tone_map.name(),
        "non_finite_pixels": image.non_finite(),
    })
}

/// With the variance, where the technique has one: then `compare` can tell noise from bias.
fn write_exr(
    path: &Path,
    renderer: &Renderer,
    image: &Image,
    metadata: &Metadata,
) -> Result<(), CliError> {
    match renderer.variance()? {
        Some(pixels) => exr::write_with_variance(path, image, &Variance { pixels }, metadata)?,
        None => exr::write(path, image, metadata)?,
    }
    Ok(())
}

fn png_options(args: &RenderArgs, scene: &Scene, stops: f32) -> PngOptions {
    PngOptions {
        bit_depth: if args.bits == "16" {
            BitDepth::Sixteen
        } else {
            BitDepth::Eight
        },
        alpha: if args.alpha {
            Alpha::Straight {
                background: scene.image.background,
            }
        } else {
            Alpha::Opaque
        },
        tone_mapping: ToneMapping {
            stops,
            operator: scene.image.tone_map,
        },
    }
}

/// What images say about where they come from.
fn metadata(scene: &Scene, device: &Device, step: Option<u32>) -> Metadata {
    let info = device.info();
    let entries = [
        ("version", env!("CARGO_PKG_VERSION").to_owned()),
        ("technique", scene.technique.name().to_owned()),
        ("device", info.name.clone()),
        ("driver", info.driver.clone()),
        ("scene", describe(scene).to_string()),
    ];
    let step = step.map(|n| ("time_step", n.to_string()));
    entries
        .into_iter()
        .chain(step)
        .map(|(key, value)| (key.to_owned(), value))
        .collect()
}
