//! What is rendered: a scene file, a volume file, or a procedural volume; with overrides.

use std::path::{Path, PathBuf};

use clap::Args;

use super::progress::Progress;
use super::time::{Steps, Time, one_step, time};
use super::{CliError, Global};
use crate::scene::file::{Override, SceneError, SceneFile};
use crate::scene::{Scene, TechniqueParams};
use crate::volume::procedural::Procedural;
use crate::volume::{PLACE, RawLayout, ReadOptions, ScalarType};

/// Which scene, and what is changed in it.
#[derive(Args, Default)]
pub(super) struct SceneArgs {
    /// A scene (.toml), a volume (.nrrd .nhdr .mha .mhd .nii .nii.gz .vti .raw), a numbered series of such
    /// files with {} for the number, as `flow_{}.vti`, a map of heights (.png .tif), or a procedural volume:
    /// marschner_lobb, shepp_logan, supernova, cloud, mechanical_part, cumulus. Default: the built-in scene.
    pub(super) input: Option<PathBuf>,
    /// Override a key of the scene, e.g. `--set technique.ray_march.step=0.25`.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<String>,
    /// Transfer function: a preset's name (ct_bone, ct_skin_bone, ct_soft_tissue, mri, fluorescence,
    /// terrain, generic) or a file (.json of ParaView, .toml).
    #[arg(long, value_name = "PRESET|FILE")]
    tf: Option<String>,
    #[command(flatten)]
    raw: RawArgs,
    /// Technique: ray_march, single_scatter, ambient_occlusion, ambient_scattering, half_angle or path_trace; for
    /// `render` also auto. Default: the scene's.
    #[arg(long, value_name = "NAME")]
    technique: Option<String>,
    #[command(flatten)]
    goals: GoalArgs,
}

/// When `path_trace` ends, and what the time step is, which shares an option with it.
#[derive(Args, Default)]
struct GoalArgs {
    /// Time step of a 4D file or a numbered series, from 0. For `render` also several, FIRST..LAST (both
    /// included) or `all`: range, transfer function, camera (by default of the whole box) and exposure are
    /// then the same for all. With a unit, how long `path_trace` renders: 500ms, 30s, 5m.
    #[arg(long, value_name = "STEP|FIRST..LAST|all|DURATION", value_parser = time)]
    time: Option<Time>,
    /// Samples a pixel of `path_trace`, at most.
    #[arg(long, value_name = "N")]
    spp: Option<u32>,
    /// `path_trace` ends when the pixels' standard errors are this share of the mean radiance, as 0.01.
    #[arg(long, value_name = "SHARE")]
    target_error: Option<f64>,
}

/// `WIDTHxHEIGHT` as keys of the scene.
pub(super) fn size(text: &str) -> Result<Vec<String>, CliError> {
    let (width, height) = text.split_once(['x', 'X']).ok_or_else(|| {
        CliError::Usage(format!(
            "--size {text}: expected WIDTHxHEIGHT, for example 800x600"
        ))
    })?;
    let keys = [("width", width), ("height", height)];
    Ok(keys
        .map(|(key, value)| format!("image.{key}={value}"))
        .to_vec())
}

/// The layout of a headerless volume.
#[derive(Args, Default)]
struct RawArgs {
    /// Headerless volume: voxels along x (fastest), y, z.
    #[arg(
        long,
        value_name = "X,Y,Z",
        value_parser = triple::<u32>, requires = "scalar_type"
    )]
    dims: Option<[u32; 3]>,
    /// Headerless volume: stored type.
    #[arg(long = "type", value_name = "TYPE", requires = "dims", value_parser = scalar_type)]
    scalar_type: Option<ScalarType>,
    /// Headerless volume: world units between voxel centres.
    #[arg(
        long,
        value_name = "X,Y,Z",
        value_parser = triple::<f64>, requires = "dims"
    )]
    spacing: Option<[f64; 3]>,
    /// Headerless volume: byte order.
    #[arg(long, value_name = "little|big", requires = "dims", value_parser = ["little", "big"])]
    endian: Option<String>,
    /// Headerless volume: bytes before the first voxel.
    #[arg(long, value_name = "N", requires = "dims")]
    skip_bytes: Option<u64>,
}

fn triple<T: std::str::FromStr>(text: &str) -> Result<[T; 3], String> {
    let parts: Option<Vec<T>> = text
        .split(',')
        .map(|part| part.trim().parse().ok())
        .collect();
    let parts = parts.and_then(|p| <[T; 3]>::try_from(p).ok());
    parts.ok_or_else(|| "expected three numbers, for example 256,256,128".to_owned())
}

fn scalar_type(text: &str) -> Result<ScalarType, String> {
    let names = ScalarType::ALL.map(ScalarType::name).join(", ");
    let found = ScalarType::ALL.into_iter().find(|t| t.name() == text);
    found.ok_or_else(|| format!("expected one of {names}"))
}

impl RawArgs {
    fn layout(&self) -> Option<RawLayout> {
        Some(RawLayout {
            dims: self.dims?,
            scalar_type: self.scalar_type?,
            spacing: self.spacing.unwrap_or([1.0; 3]),
            big_endian: self.endian.as_deref() == Some("big"),
            skip_bytes: self.skip_bytes.unwrap_or(0),
        })
    }
}

impl SceneArgs {
    /// How a volume file named on the command line is to be read.
    pub(super) fn read_options(&self) -> ReadOptions {
        ReadOptions {
            raw: self.raw.layout(),
            time: match self.goals.time {
                Some(Time::Step(step)) => step,
                _ => 0,
            },
        }
    }

    /// The volume file named on the command line, if it is one.
    pub(super) fn volume_file(&self) -> Option<&Path> {
        let path = self.input.as_deref()?;
        let scene = path
            .extension()
            .is_some_and(|e| e.eq_ignore_ascii_case("toml"));
        (!scene && self.procedural().is_none()).then_some(path)
    }

    /// The procedural volume named on the command line; a file of that name goes first.
    fn procedural(&self) -> Option<Procedural> {
        let path = self.input.as_deref()?;
        let name = path.to_str()?;
        (!path.exists()).then(|| Procedural::ALL.into_iter().find(|p| p.name() == name))?
    }

    /// A short name for output files; of a series, what stands before the numbers.
    pub(super) fn name(&self) -> String {
        let file = self
            .input
            .as_deref()
            .and_then(Path::file_name)
            .map(|n| n.to_string_lossy().into_owned());
        let name = file.unwrap_or_else(|| "tyndall".to_owned());
        let name = match name.split_once(PLACE) {
            Some((before, after)) => before.trim_end_matches(['_', '-', '.']).to_owned() + after,
            None => name,
        };
        name.split('.')
            .find(|part| !part.is_empty())
            .unwrap_or("tyndall")
            .to_owned()
    }

    /// A scene with some overrides and, maybe, a transfer function.
    pub(super) fn named(input: &Path, overrides: &[String], tf: Option<&String>) -> Self {
        Self {
            input: Some(input.to_owned()),
            overrides: overrides.to_vec(),
            tf: tf.cloned(),
            ..Self::default()
        }
    }

    /// Whether the technique is to be chosen.
    pub(super) fn is_auto(&self) -> bool {
        self.technique.as_deref() == Some("auto")
    }

    /// What the options say of the scene; `more` are overrides that other options stand for.
    pub(super) fn overrides(&self, more: &[String]) -> Result<Vec<Override>, SceneError> {
        let mut overrides = Vec::new();
        if let Some(tf) = &self.tf {
            let key = if Path::new(tf).extension().is_some() {
                "file"
            } else {
                "preset"
            };
            overrides.push(format!("transfer_function.{key}={tf:?}"));
        }
        if let Some(technique) = self.technique.as_ref().filter(|_| !self.is_auto()) {
            overrides.push(format!("technique.name={technique}"));
        }
        overrides.extend(self.goals.overrides());
        overrides.extend(more.iter().cloned());
        overrides.extend(self.overrides.iter().cloned());
        overrides.iter().map(|text| Override::parse(text)).collect()
    }

    /// The time steps to be rendered one after the other, if there are several.
    pub(super) fn steps(&self) -> Option<Steps> {
        match self.goals.time {
            Some(Time::Steps(steps)) => Some(steps),
            _ => None,
        }
    }

    /// Refuses several time steps.
    pub(super) fn one_step(&self) -> Result<(), CliError> {
        one_step(self.goals.time)
    }

    /// Reads the scene, not the volume.
    pub(super) fn file(&self, overrides: &[Override]) -> Result<SceneFile, SceneError> {
        let mut file = match (self.procedural(), self.volume_file(), &self.input) {
            (Some(procedural), _, _) => SceneFile::for_procedural(procedural, overrides),
            (_, Some(path), _) => SceneFile::for_volume_file(path, &self.read_options(), overrides),
            (_, _, Some(path)) => SceneFile::load(path, overrides),
            _ => SceneFile::built_in(overrides),
        }?;
        if let Some(Time::Step(step)) = self.goals.time {
            file.set_time(step)?;
        }
        Ok(file)
    }

    /// Reads the scene, not the volume; `more` are overrides that options stand for.
    pub(super) fn open(&self, more: &[String]) -> Result<SceneFile, CliError> {
        Ok(self.file(&self.overrides(more)?)?)
    }

    /// Reads the volume and chooses what the scene leaves open.
    pub(super) fn resolve(&self, global: &Global, file: &SceneFile) -> Result<Scene, CliError> {
        let mut progress = Progress::new(global.quiet);
        let scene = file.resolve(&mut |phase, done, total| progress.update(phase, done, total));
        progress.finish();
        let scene = scene?;
        self.check(global, &scene)?;
        Ok(scene)
    }

    /// Refuses options that the scene would not heed; tells what was chosen.
    pub(super) fn check(&self, global: &Global, scene: &Scene) -> Result<(), CliError> {
        self.goals.check(&scene.technique)?;
        remark(global, scene);
        Ok(())
    }

    /// Reads and resolves the scene; `more` are overrides that options stand for.
    pub(super) fn load_with(&self, global: &Global, more: &[String]) -> Result<Scene, CliError> {
        self.resolve(global, &self.open(more)?)
    }

    /// Reads and resolves the scene of a command that shows one.
    pub(super) fn load(&self, global: &Global) -> Result<(SceneFile, Scene), CliError> {
        self.one_step()?;
        if self.is_auto() {
            return Err(CliError::Usage(
                "--technique auto is for `render`; expected the name of a technique".to_owned(),
            ));
        }
        let file = self.open(&[])?;
        let scene = self.resolve(global, &file)?;
        Ok((file, scene))
    }
}

impl GoalArgs {
    /// Keys of the scene that the options stand for.
    fn overrides(&self) -> Vec<String> {
        let seconds = match self.time {
            Some(Time::Seconds(seconds)) => Some(format!("seconds={seconds:?}")),
            _ => None,
        };
        let others = [
            seconds,
            self.spp.map(|n| format!("samples={n}")),
            self.target_error.map(|e| format!("target_error={e:?}")),
        ];
        let keys = others.into_iter().flatten();
        keys.map(|key| format!("technique.path_trace.{key}"))
            .collect()
    }

    /// Refuses options that the technique would not heed.
    fn check(&self, technique: &TechniqueParams) -> Result<(), CliError> {
        let options = [
            ("--spp", self.spp.is_some()),
            ("--target-error", self.target_error.is_some()),
            (
                "--time DURATION",
                matches!(self.time, Some(Time::Seconds(_))),
            ),
        ];
        let given = options.into_iter().find(|(_, given)| *given);
        match (given, technique) {
            (None, _) | (_, TechniqueParams::PathTrace(_)) => Ok(()),
            (Some((option, _)), other) => Err(CliError::Usage(format!(
                "{option} is for path_trace, and the scene's technique is {}; add --technique path_trace",
                other.name()
            ))),
        }
    }
}

/// Tells what was chosen and what is odd, unless the user asked for quiet.
fn remark(global: &Global, scene: &Scene) {
    let s = &scene.statistics;
    if !global.quiet && s.nan + s.infinite > 0 {
        eprintln!(
            "note: {}: {} NaN and {} infinite voxels are rendered as empty",
            scene.volume.name, s.nan, s.infinite
        );
    }
    let level = scene.volume.height_field.as_ref().map_or(0, |f| f.level);
    if !global.quiet && level > 0 {
        let stored = scene.volume.stored_dims();
        eprintln!(
            "height field: halved {level} time(s), to {} x {} columns, as fine as the image needs \
             (volume.height_field.level)",
            stored.x, stored.y
        );
    }
    if !global.quiet {
        eprintln!("transfer function: {}", scene.medium.transfer_function.name);
    }
}
