//! `render --technique auto`: the setting that suits a limit, by a study of a small image.

use std::path::PathBuf;

use clap::Args;
use serde_json::{Value, json};

use super::input::SceneArgs;
use super::progress::Progress;
use super::study::{MAX_SAMPLES, around, cache};
use super::{CliError, Global};
use crate::gpu::Device;
use crate::output::Image;
use crate::scene::Scene;
use crate::study::{
    About, Candidate, Goal, Journal, Record, Reference, ReferenceGoal, Search, Settings, Subject,
    compare, run_scene, shrink,
};
use crate::technique::{FrameReport, Input, Inputs, RenderError, Renderer};

/// The small image has this share of the full one's pixels along each side.
const SHRINK: u32 = 4;

/// Pixels along a side below which the small image is not made smaller.
const MIN_SIDE: u32 = 64;

/// Frames that times are the medians of.
const FRAMES: u32 = 3;

/// When the small reference is good enough.
const REFERENCE: ReferenceGoal = ReferenceGoal {
    error: 0.01,
    seconds: 60.0,
    samples: MAX_SAMPLES,
};

/// What `--technique auto` is to keep.
#[derive(Args)]
pub(super) struct AutoArgs {
    /// With `--technique auto`: the fastest setting whose mean LDR-FLIP is at most this.
    #[arg(long, value_name = "X", conflicts_with = "budget")]
    max_flip: Option<f64>,
    /// With `--technique auto`: the most accurate setting whose frame takes at most so many milliseconds
    /// once the volume is on the device.
    #[arg(long, value_name = "MS")]
    budget: Option<f64>,
    /// Where the measurements of `--technique auto` are kept. Default: the user's cache folder.
    #[arg(long, value_name = "DIR")]
    cache: Option<PathBuf>,
}

/// A rendered image, and why by this setting.
pub(super) struct Found {
    pub(super) renderer: Renderer,
    pub(super) image: Image,
    pub(super) frame: FrameReport,
    pub(super) about: Choice,
}

/// What was chosen and why.
pub(super) struct Choice {
    goal: Goal,
    chosen: Candidate,
    /// FLIP of the full image averaged down to the small one's size.
    found_flip: f64,
    /// Seconds of a frame of the full image, measured where there is a budget.
    found_seconds: Option<f64>,
    small: [u32; 2],
    reference: About,
    /// Settings that should keep the goal, and all.
    counts: [usize; 2],
    search: Search,
}

impl AutoArgs {
    /// What is asked for, if the technique is to be chosen.
    pub(super) fn goal(&self, is_auto: bool) -> Result<Option<Goal>, CliError> {
        let usage = |text: &str| Err(CliError::Usage(text.to_owned()));
        let positive = |value: f64| value > 0.0 && value.is_finite();
        match (is_auto, self.max_flip, self.budget) {
            (false, None, None) => Ok(None),
            (false, ..) => {
                usage("--max-flip and --budget are for --technique auto; expected both or neither")
            }
            (true, Some(flip), _) if positive(flip) => Ok(Some(Goal::MaxFlip(flip))),
            (true, _, Some(ms)) if positive(ms) => Ok(Some(Goal::BudgetSeconds(1e-3 * ms))),
            (true, None, None) => usage("--technique auto: expected --max-flip X or --budget MS"),
            (true, ..) => usage("--max-flip and --budget: expected a number above 0"),
        }
    }
}

/// Measures a small image at every setting, as far as that is not known yet, and renders the full image
/// with the one that suits best; one that misses the goal there gives way to the next.
pub(super) fn render(
    global: &Global,
    scene_args: &SceneArgs,
    args: &AutoArgs,
    more: &[String],
    scene: Scene,
    device: &Device,
    goal: Goal,
) -> Result<Found, CliError> {
    let small = small_scene(&scene);
    let [full_pixels, small_pixels] =
        [&scene, &small].map(|s| f64::from(s.image.width) * f64::from(s.image.height));
    let subject = around(scene_args, scene_args.name(), small, &[], more)?;
    let mut progress = Progress::new(global.quiet);
    let (reference, records) = measure(args, &subject, device, &mut progress)?;
    let mut search = Search::new(goal, &records, full_pixels / small_pixels);
    let counts = [search.promising(), subject.variants.len()];
    while let Some(candidate) = search.best().cloned() {
        let Some(tried) = attempt(&subject, &candidate, &scene, device, goal, &mut progress)?
        else {
            search.miss(&candidate.configuration, f64::INFINITY, f64::INFINITY);
            continue;
        };
        let flip = small_flip(&tried.image, &subject, &reference)?;
        let seconds = tried.seconds.unwrap_or(candidate.seconds);
        if !goal.is_kept(flip, seconds) {
            search.miss(&candidate.configuration, seconds, flip);
            continue;
        }
        progress.finish();
        let about = Choice {
            goal,
            chosen: candidate,
            found_flip: flip,
            found_seconds: tried.seconds,
            small: [subject.scene.image.width, subject.scene.image.height],
            reference: reference.about,
            counts,
            search,
        };
        return Ok(Found {
            renderer: tried.renderer,
            image: tried.image,
            frame: tried.frame,
            about,
        });
    }
    progress.finish();
    Err(out_of_reach(goal, &search))
}

/// The scene with a small image.
fn small_scene(scene: &Scene) -> Scene {
    let mut small = scene.clone();
    let [width, height] = [scene.image.width, scene.image.height];
    if width.min(height) / SHRINK >= MIN_SIDE {
        (small.image.width, small.image.height) = (width / SHRINK, height / SHRINK);
    } else {
        // The smaller side keeps its 64 pixels, or all it has.
        let factor = (f64::from(width.min(height)) / f64::from(MIN_SIDE)).max(1.0);
        let side = |n: u32| ((f64::from(n) / factor).round() as u32).max(1);
        (small.image.width, small.image.height) = (side(width), side(height));
    }
    small
}

/// The reference and all settings of the small image.
fn measure(
    args: &AutoArgs,
    subject: &Subject,
    device: &Device,
    progress: &mut Progress,
) -> Result<(Reference, Vec<Record>), CliError> {
    let cache = cache(args.cache.as_ref())?;
    let mut show = |done, total| progress.update("reference", done, total);
    let reference = cache.reference(device, subject, &REFERENCE, &mut show)?;
    let mut journal = Journal::open(cache.folder().join("auto.jsonl"), false)?;
    let settings = Settings {
        frames: FRAMES,
        pictures: None,
    };
    let total = 1000 * subject.variants.len() as u64;
    let mut show = |done: f64| progress.update("study", (1e3 * done) as u64, total);
    let records = run_scene(
        device,
        subject,
        &reference,
        &mut journal,
        &settings,
        &mut show,
    )?;
    Ok((reference, records))
}

/// A setting rendered at the full size.
struct Tried {
    renderer: Renderer,
    image: Image,
    frame: FrameReport,
    /// Seconds of a second frame, where there is a budget.
    seconds: Option<f64>,
}

/// Renders the full image; `None` where the device refuses it.
fn attempt(
    subject: &Subject,
    candidate: &Candidate,
    scene: &Scene,
    device: &Device,
    goal: Goal,
    progress: &mut Progress,
) -> Result<Option<Tried>, CliError> {
    let mut variants = subject.variants.iter();
    let Some(variant) = variants.find(|v| v.configuration == candidate.configuration) else {
        return Ok(None);
    };
    let mut renderer = match Renderer::new(device, variant.apply(scene)) {
        Ok(renderer) => renderer,
        Err(RenderError::Plan(_)) => return Ok(None),
        Err(error) => return Err(error.into()),
    };
    let mut show = |phase: &str, done, total| progress.update(phase, done, total);
    let (mut image, mut frame) = renderer.render(&mut show)?;
    let mut seconds = None;
    if let Goal::BudgetSeconds(_) = goal {
        // What was extrapolated is a frame after a change of the camera.
        renderer.invalidate(Inputs::of(&[Input::Camera]));
        (image, frame) = renderer.render(&mut show)?;
        seconds = Some(frame.wall_seconds);
    }
    Ok(Some(Tried {
        renderer,
        image,
        frame,
        seconds,
    }))
}

/// Mean LDR-FLIP of the image averaged down to the reference's size.
fn small_flip(image: &Image, subject: &Subject, reference: &Reference) -> Result<f64, CliError> {
    let small = &subject.scene.image;
    let shrunk = shrink(image, [small.width, small.height]);
    let comparison = compare(&shrunk, reference, &subject.scene);
    let comparison = comparison.map_err(|e| CliError::Compare(format!("the image: {e}")))?;
    Ok(comparison.shown.flip.mean)
}

/// Says which limit could be kept.
fn out_of_reach(goal: Goal, search: &Search) -> CliError {
    let Some((configuration, value)) = search.nearest() else {
        return CliError::Limits(vec![
            "--technique auto: no setting could be measured on this device".to_owned(),
        ]);
    };
    let setting = format!("{} {}", configuration.technique, configuration.label());
    CliError::Limits(vec![match goal {
        Goal::MaxFlip(limit) => format!(
            "--max-flip {limit} is out of reach: the nearest possible value is {}, with {setting}",
            rounded_up(value)
        ),
        Goal::BudgetSeconds(limit) => format!(
            "--budget {} is out of reach: the nearest possible value is about {} (ms), with {setting}",
            1e3 * limit,
            rounded_up(1e3 * value)
        ),
    }])
}

/// Three significant digits, not below the value.
fn rounded_up(value: f64) -> f64 {
    if value <= 0.0 || !value.is_finite() {
        return value;
    }
    let digits = (2.0 - value.log10().floor()) as i32;
    // Dividing by a power of ten rounds to the nearest double of the short decimal.
    if digits >= 0 {
        (value * 10f64.powi(digits)).ceil() / 10f64.powi(digits)
    } else {
        (value / 10f64.powi(-digits)).ceil() * 10f64.powi(-digits)
    }
}

impl Choice {
    /// One line for people.
    pub(super) fn sentence(&self) -> String {
        let Self { chosen, counts, .. } = self;
        let [width, height] = self.small;
        let measured = format!(
            "FLIP {:.4} measured at {width} x {height} against a reference of relative error {:.2} %, {:.4} by the \
             full image averaged down to that",
            chosen.flip,
            100.0 * self.reference.relative_error,
            self.found_flip
        );
        let expected = 1e3 * chosen.seconds;
        let why = match (self.goal, self.found_seconds) {
            (Goal::BudgetSeconds(limit), Some(seconds)) => format!(
                "the most accurate of {} (of {} settings) expected within {} ms; a frame took {:.1} ms, expected \
                 {expected:.1}; {measured}",
                counts[0],
                counts[1],
                1e3 * limit,
                1e3 * seconds
            ),
            (Goal::MaxFlip(limit), _) | (Goal::BudgetSeconds(limit), None) => format!(
                "the fastest of {} (of {} settings) with FLIP of at most {limit}; {measured}; a frame is expected to \
                 take {expected:.1} ms",
                counts[0], counts[1]
            ),
        };
        let missed = match self.search.missed.len() {
            0 => String::new(),
            n => format!("; {n} tried before missed it"),
        };
        let configuration = &chosen.configuration;
        format!(
            "auto: {} {}: {why}{missed}",
            configuration.technique,
            configuration.label()
        )
    }

    /// The same for programs.
    pub(super) fn report(&self) -> Value {
        json!({
            "goal": self.goal,
            "chosen": self.chosen,
            "options": self.chosen.configuration.options(),
            "found_flip": self.found_flip,
            "found_seconds": self.found_seconds,
            "measured_at": self.small,
            "reference": self.reference,
            "settings_that_should_keep_it": self.counts[0],
            "settings": self.counts[1],
            "missed": self.search.missed,
        })
    }
}
