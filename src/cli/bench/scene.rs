//! One scene: what each stage costs over a camera orbit, and what each kind of change costs.

use serde::Serialize;

use super::BenchArgs;
use crate::cli::progress::Progress;
use crate::cli::sequence::neighbours;
use crate::cli::{CliError, Global, print, print_json};
use crate::gpu::{DeviceInfo, StageTime};
use crate::scene::{Light, Scene};
use crate::technique::{
    FrameReport, Input, Inputs, Renderer, Spread, StageSpread, size, stage_spreads,
};

#[derive(Serialize)]
struct Change {
    what: &'static str,
    /// Stages that ran.
    stages: Vec<String>,
    /// Device time of all stages.
    device_seconds: Spread,
    /// Host time of the whole frame.
    wall_seconds: Spread,
}

#[derive(Serialize)]
struct Report {
    device: DeviceInfo,
    volume: String,
    image: [u32; 2],
    frames: u32,
    plan_bytes: u64,
    allocated_bytes: u64,
    first_frame: FrameReport,
    orbit: Vec<StageSpread>,
    changes: Vec<Change>,
}

pub(super) fn run(global: &Global, args: &BenchArgs) -> Result<(), CliError> {
    let (file, scene) = args.scene.load(global)?;
    let device = global.open_device()?;
    let mut renderer = Renderer::new(&device, scene.clone())?;
    let mut progress = Progress::new(global.quiet);
    let steps = neighbours(&file, &scene, &mut progress)?;
    let (_, first_frame) =
        renderer.render(&mut |phase, done, total| progress.update(phase, done, total))?;
    let orbit = orbit(&mut renderer, args, &mut progress)?;
    let mut changes = changes(&mut renderer, &scene, args.repeat, &mut progress)?;
    if let Some(steps) = &steps {
        changes.push(time_step(&mut renderer, steps, args.repeat)?);
        renderer.set_scene(scene.clone())?;
    }
    progress.finish();
    let report = Report {
        device: device.info().clone(),
        volume: scene.volume.name.clone(),
        image: [scene.image.width, scene.image.height],
        frames: args.frames,
        plan_bytes: renderer.plan().bytes(),
        allocated_bytes: device.live_allocations().iter().map(|a| a.bytes).sum(),
        first_frame,
        orbit,
        changes,
    };
    if args.json {
        print_json(&report)
    } else {
        print(&table(&report))
    }
}

/// Turns the camera once around and gathers each stage's times.
fn orbit(
    renderer: &mut Renderer,
    args: &BenchArgs,
    progress: &mut Progress,
) -> Result<Vec<StageSpread>, CliError> {
    let start = renderer.scene().clone();
    let mut frames = Vec::new();
    for i in 0..args.warmup + args.frames {
        let turn = f64::from(i) - f64::from(args.warmup);
        let mut scene = start.clone();
        scene.camera = start.camera.orbit(turn * 360.0 / f64::from(args.frames));
        renderer.set_scene(scene)?;
        let (_, report) = renderer.render(&mut |_, _, _| {})?;
        if i >= args.warmup {
            frames.push(report);
        }
        progress.update(
            "orbit",
            u64::from(i + 1),
            u64::from(args.warmup + args.frames),
        );
    }
    renderer.set_scene(start)?;
    Ok(rows(&frames))
}

fn rows(frames: &[FrameReport]) -> Vec<StageSpread> {
    let mut rows = stage_spreads(frames);
    let walls = frames.iter().map(|f| f.wall_seconds).collect();
    rows.push(StageSpread {
        name: "whole frame (host)".to_owned(),
        seconds: Spread::of(walls),
    });
    rows
}

/// Changes one thing at a time and renders again.
fn changes(
    renderer: &mut Renderer,
    start: &Scene,
    repeat: u32,
    progress: &mut Progress,
) -> Result<Vec<Change>, CliError> {
    type Edit = fn(&mut Scene, u32);
    let edits: [(&'static str, Option<Edit>); 6] = [
        ("nothing", Some(|_, _| {})),
        ("volume", None),
        (
            "transfer function",
            Some(|s, i| s.medium.density_scale *= 1.0 + 1e-3 * f64::from(i + 1)),
        ),
        (
            "phase",
            Some(|s, i| s.medium.phase_g = 0.01 * f64::from(i + 1)),
        ),
        ("light", Some(change_light)),
        (
            "camera",
            Some(|s, i| s.camera = s.camera.orbit(0.5 * f64::from(i + 1))),
        ),
    ];
    let mut list = Vec::new();
    for (n, (what, edit)) in (1..).zip(edits) {
        renderer.set_scene(start.clone())?;
        renderer.render(&mut |_, _, _| {})?;
        let mut reports = Vec::new();
        for i in 0..repeat {
            match edit {
                Some(edit) => {
                    let mut scene = start.clone();
                    edit(&mut scene, i);
                    renderer.set_scene(scene)?;
                }
                None => renderer.invalidate(Inputs::of(&[Input::Volume])),
            }
            reports.push(renderer.render(&mut |_, _, _| {})?.1);
        }
        progress.update("changes", n, 6);
        list.push(change(what, &reports));
    }
    renderer.set_scene(start.clone())?;
    Ok(list)
}

/// Goes to and fro between two time steps.
fn time_step(renderer: &mut Renderer, steps: &[Scene; 2], repeat: u32) -> Result<Change, CliError> {
    renderer.set_scene(steps[0].clone())?;
    renderer.render(&mut |_, _, _| {})?;
    let mut reports = Vec::new();
    for scene in steps.iter().cycle().skip(1).take(repeat as usize) {
        renderer.set_scene(scene.clone())?;
        reports.push(renderer.render(&mut |_, _, _| {})?.1);
    }
    Ok(change("time step", &reports))
}

fn change_light(scene: &mut Scene, i: u32) {
    let factor = 1.0 + 1e-3 * (i + 1) as f32;
    for light in &mut scene.lights {
        match light {
            Light::Directional { irradiance: c, .. }
            | Light::Point { intensity: c, .. }
            | Light::Environment { radiance: c }
            | Light::EnvironmentMap { scale: c, .. } => *c *= factor,
        }
    }
}

fn change(what: &'static str, reports: &[FrameReport]) -> Change {
    let stages = reports.first().map_or_else(Vec::new, |r| {
        r.stages.iter().map(|s| s.name.clone()).collect()
    });
    let device = |r: &FrameReport| r.stages.iter().map(|s: &StageTime| s.seconds).sum();
    Change {
        what,
        stages,
        device_seconds: Spread::of(reports.iter().map(device).collect()),
        wall_seconds: Spread::of(reports.iter().map(|r| r.wall_seconds).collect()),
    }
}

fn table(r: &Report) -> String {
    let ms = |s: f64| format!("{:.3}", 1e3 * s);
    let mut lines = vec![
        format!("{} on {} ({})", r.volume, r.device.name, r.device.driver),
        format!(
            "{} x {} pixels, {} frames; {} planned, {} allocated on the device",
            r.image[0],
            r.image[1],
            r.frames,
            size(r.plan_bytes),
            size(r.allocated_bytes)
        ),
        String::new(),
        format!(
            "{:<28} {:>10} {:>10} {:>10}   milliseconds over the orbit",
            "stage", "min", "median", "max"
        ),
    ];
    for row in &r.orbit {
        let s = row.seconds;
        lines.push(format!(
            "{:<28} {:>10} {:>10} {:>10}",
            row.name,
            ms(s.min),
            ms(s.median),
            ms(s.max)
        ));
    }
    lines.push(String::new());
    lines.push(format!(
        "{:<28} {:>10} {:>10}   median milliseconds, and what ran",
        "change", "device", "host"
    ));
    let first: f64 = r.first_frame.stages.iter().map(|s| s.seconds).sum();
    let all: Vec<_> = r
        .first_frame
        .stages
        .iter()
        .map(|s| s.name.clone())
        .collect();
    let wall = ms(r.first_frame.wall_seconds);
    lines.push(format!(
        "{:<28} {:>10} {:>10}   {}",
        "first frame",
        ms(first),
        wall,
        all.join(" ")
    ));
    for c in &r.changes {
        let (device, wall) = (ms(c.device_seconds.median), ms(c.wall_seconds.median));
        let ran = if c.stages.is_empty() {
            "nothing".to_owned()
        } else {
            c.stages.join(" ")
        };
        lines.push(format!(
            "{:<28} {:>10} {:>10}   {}",
            c.what, device, wall, ran
        ));
    }
    lines.join("\n")
}
