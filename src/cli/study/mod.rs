//! `tyndall study`.

mod extremes;
mod summary;

use std::path::PathBuf;

use clap::Args;

use super::input::{SceneArgs, size};
use super::progress::Progress;
use super::time::duration;
use super::{CliError, Global, print, print_json};
use crate::gpu::Device;
use crate::scene::Scene;
use crate::scene::file::Override;
use crate::study::{
    Cache, Journal, Pictures, Reference, ReferenceGoal, Report, SceneReport, Settings, StudyError,
    Subject, run_scene, write,
};

/// Samples a pixel of a reference, at most.
pub(super) const MAX_SAMPLES: u32 = 1 << 20;

/// Parts that a setting's progress is counted in.
const PARTS: f64 = 1000.0;

/// Render every technique at every setting worth trying, beside a reference: time, memory, errors.
///
/// For each scene a converged reference is path-traced once and kept on disk. Every technique is rendered at
/// all values of its knobs, timed and compared with it. Results go to study.csv, study.json and study.html,
/// a page with pictures. A study that was interrupted goes on where it was.
#[derive(Args)]
#[command(after_help = "Examples:\n  \
    tyndall study assets/scenes/cloud.toml shepp_logan --size 256x256\n  \
    tyndall study scene.toml --techniques ray_march --frames 9 -o out/scene\n  \
    tyndall study scene.toml --reference-error 0.002 --reference-time 2h\n  \
    tyndall study scene.toml --set technique.ray_march.step=1    that knob stays as it is\n  \
    tyndall study --extremes")]
pub(super) struct StudyArgs {
    /// Scenes (.toml), volumes or procedural volumes, as for `render`.
    #[arg(value_name = "SCENE", required_unless_present = "extremes")]
    scenes: Vec<PathBuf>,
    /// Instead: render scenes at the extremes by every technique and print what was found of each image,
    /// and what theory says of it.
    #[arg(long, conflicts_with = "scenes")]
    extremes: bool,
    /// Techniques to try, separated by commas. Default: all.
    #[arg(long, value_name = "NAME,...", value_delimiter = ',')]
    techniques: Vec<String>,
    /// Override a key of every scene; a knob that is set stays as it is.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<String>,
    /// Transfer function of every scene: a preset's name or a file.
    #[arg(long, value_name = "PRESET|FILE")]
    tf: Option<String>,
    /// Image size in pixels. Default: each scene's.
    #[arg(long, value_name = "WxH")]
    size: Option<String>,
    /// Frames that times are the medians of.
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=1000))]
    frames: u32,
    /// Standard errors of the reference's pixels (root mean square) as a share of its mean radiance.
    #[arg(long, value_name = "SHARE", default_value = "0.005", value_parser = share)]
    reference_error: f64,
    /// How long a reference may take, whatever its error.
    #[arg(long, value_name = "DURATION", default_value = "10m", value_parser = duration)]
    reference_time: f64,
    /// Where references are kept. Default: the user's cache folder.
    #[arg(long, value_name = "DIR")]
    cache: Option<PathBuf>,
    /// Folder of the results.
    #[arg(long, short, value_name = "DIR", default_value = "out/study")]
    output: PathBuf,
    /// Measure everything again. References are kept: their files are named after all that decides them.
    #[arg(long)]
    fresh: bool,
    /// Print the results as JSON.
    #[arg(long)]
    json: bool,
}

pub(super) fn run(global: &Global, args: &StudyArgs) -> Result<(), CliError> {
    if args.extremes {
        return extremes::run(global, args.json);
    }
    let subjects = subjects(global, args)?;
    let cache = cache(args.cache.as_ref())?;
    let pictures = Pictures::new(args.output.join("images"))?;
    let mut journal = Journal::open(args.output.join("study.jsonl"), args.fresh)?;
    let device = global.open_device()?;
    let mut progress = Progress::new(global.quiet);
    let references = references(args, &device, &subjects, &cache, &mut progress)?;
    let settings = Settings {
        frames: args.frames,
        pictures: Some(&pictures),
    };
    let mut report = Report::new(device.info(), args.frames);
    let in_all: usize = subjects.iter().map(|s| s.variants.len()).sum();
    let mut before = 0;
    for (subject, reference) in subjects.iter().zip(&references) {
        pictures.write_reference(reference, &subject.scene)?;
        let mut show = |done: f64| {
            let done = PARTS * (f64::from(before) + done);
            progress.update("study", done as u64, (PARTS * in_all as f64) as u64);
        };
        let records = run_scene(
            &device,
            subject,
            reference,
            &mut journal,
            &settings,
            &mut show,
        )?;
        before += subject.variants.len() as u32;
        let scene = SceneReport::new(subject, reference, records);
        report.scenes.push(scene);
    }
    progress.finish();
    let files = write(&args.output, &report, &pictures)?;
    if args.json {
        return print_json(&report);
    }
    print(&summary::summary(&report, &files))
}

/// All scenes, or what is wrong with any of them.
fn subjects(global: &Global, args: &StudyArgs) -> Result<Vec<Subject>, CliError> {
    let size = args.size.as_deref().map_or(Ok(Vec::new()), size)?;
    let named = |input: &PathBuf| SceneArgs::named(input, &args.overrides, args.tf.as_ref());
    let scenes: Vec<SceneArgs> = args.scenes.iter().map(named).collect();
    let (mut subjects, mut errors) = (Vec::new(), Vec::new());
    for scene in &scenes {
        let name = scene.name();
        let is_unique = scenes.iter().filter(|s| s.name() == name).count() == 1;
        let path = scene.input.as_ref().filter(|_| !is_unique);
        let name = path.map_or(name, |p| p.display().to_string());
        match subject(global, scene, name, &args.techniques, &size) {
            Ok(subject) => subjects.push(subject),
            Err(error) => errors.push(error),
        }
    }
    match errors.len() {
        0 => Ok(subjects),
        1 => Err(errors.remove(0)),
        _ => Err(CliError::Several(errors)),
    }
}

fn subject(
    global: &Global,
    scene: &SceneArgs,
    name: String,
    techniques: &[String],
    more: &[String],
) -> Result<Subject, CliError> {
    let resolved = scene.load_with(global, more)?;
    Ok(around(scene, name, resolved, techniques, more)?)
}

/// Everything that is to be tried in a scene: knobs that the options set stay as they are.
pub(super) fn around(
    args: &SceneArgs,
    name: String,
    scene: Scene,
    techniques: &[String],
    more: &[String],
) -> Result<Subject, StudyError> {
    let told = args.overrides(more)?;
    let fixed: Vec<String> = told.iter().map(|o| o.path.join(".")).collect();
    Subject::new(name, scene, techniques, &fixed, &|knobs: &[Override]| {
        args.file(&[told.as_slice(), knobs].concat())
    })
}

/// The folder given, or the user's.
pub(super) fn cache(folder: Option<&PathBuf>) -> Result<Cache, CliError> {
    let folder = folder.cloned().or_else(Cache::user_folder);
    let folder = folder.ok_or_else(|| {
        CliError::Usage("the system names no cache folder; give one with --cache DIR".to_owned())
    })?;
    Ok(Cache::new(folder)?)
}

fn references(
    args: &StudyArgs,
    device: &Device,
    subjects: &[Subject],
    cache: &Cache,
    progress: &mut Progress,
) -> Result<Vec<Reference>, CliError> {
    let goal = ReferenceGoal {
        error: args.reference_error,
        seconds: args.reference_time,
        samples: MAX_SAMPLES,
    };
    let mut references = Vec::new();
    for (i, subject) in (1..).zip(subjects) {
        let phase = format!("reference {i} of {}", subjects.len());
        let mut show = |done, total| progress.update(&phase, done, total);
        references.push(cache.reference(device, subject, &goal, &mut show)?);
    }
    Ok(references)
}

fn share(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(share) if share > 0.0 && share.is_finite() => Ok(share),
        _ => Err("expected a number above 0, for example 0.005".to_owned()),
    }
}
