//! What is rendered: a scene file, a volume file, or a procedural volume; with overrides.

use std::path::{Path, PathBuf};

use clap::Args;

use super::progress::Progress;
use super::{CliError, Global};
use crate::scene::Scene;
use crate::scene::file::{Override, SceneFile};
use crate::volume::procedural::Procedural;
use crate::volume::{RawLayout, ReadOptions, ScalarType};

/// Which scene, and what is changed in it.
#[derive(Args)]
pub(super) struct SceneArgs {
    /// A scene (.toml), a volume (.nrrd .nhdr .mha .mhd .nii .nii.gz .raw), or a procedural volume:
    /// marschner_lobb, shepp_logan, supernova, cloud, mechanical_part. Default: the built-in scene.
    pub(super) input: Option<PathBuf>,
    /// Override a key of the scene, e.g. `--set technique.ray_march.step=0.25`.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<String>,
    /// Transfer function: a preset's name (ct_bone, ct_skin_bone, ct_soft_tissue, mri, fluorescence,
    /// generic) or a file (.json of ParaView, .toml).
    #[arg(long, value_name = "PRESET|FILE")]
    tf: Option<String>,
    #[command(flatten)]
    raw: RawArgs,
    /// Time step of a 4D file, from 0.
    #[arg(long, value_name = "N")]
    time: Option<u32>,
}

/// The layout of a headerless volume.
#[derive(Args)]
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
            time: self.time.unwrap_or(0),
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

    /// A short name for output files.
    pub(super) fn name(&self) -> String {
        let file = self
            .input
            .as_deref()
            .and_then(Path::file_name)
            .map(|n| n.to_string_lossy().into_owned());
        let name = file.unwrap_or_else(|| "tyndall".to_owned());
        name.split('.')
            .find(|part| !part.is_empty())
            .unwrap_or("tyndall")
            .to_owned()
    }

    /// Reads and resolves the scene; `more` are overrides that options stand for.
    pub(super) fn load_with(&self, global: &Global, more: &[String]) -> Result<Scene, CliError> {
        let mut overrides = Vec::new();
        if let Some(tf) = &self.tf {
            let key = if Path::new(tf).extension().is_some() {
                "file"
            } else {
                "preset"
            };
            overrides.push(format!("transfer_function.{key}={tf:?}"));
        }
        overrides.extend(more.iter().cloned());
        overrides.extend(self.overrides.iter().cloned());
        let overrides = overrides
            .iter()
            .map(|text| Override::parse(text))
            .collect::<Result<Vec<_>, _>>()?;
        let file = match (self.procedural(), self.volume_file(), &self.input) {
            (Some(procedural), _, _) => SceneFile::for_procedural(procedural, &overrides)?,
            (_, Some(path), _) => {
                SceneFile::for_volume_file(path, &self.read_options(), &overrides)?
            }
            (_, _, Some(path)) => SceneFile::load(path, &overrides)?,
            _ => SceneFile::built_in(&overrides)?,
        };
        let mut progress = Progress::new(global.quiet);
        let scene = file.resolve(&mut |phase, done, total| progress.update(phase, done, total));
        progress.finish();
        let scene = scene?;
        remark(global, &scene);
        Ok(scene)
    }

    /// Reads and resolves the scene.
    pub(super) fn load(&self, global: &Global) -> Result<Scene, CliError> {
        self.load_with(global, &[])
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
    if !global.quiet {
        eprintln!("transfer function: {}", scene.medium.transfer_function.name);
    }
}
