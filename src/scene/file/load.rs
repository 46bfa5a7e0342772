//! From text to a checked specification.

use std::io::Read;
use std::path::{Path, PathBuf};

use super::error::Problem;
use super::keys::{locate, unknown};
use super::spec::{RawSpec, SceneSpec};
use super::wording::reword;
use super::{Endian, Override, SceneError, schema, validate};
use crate::volume::ReadOptions;
use crate::volume::procedural::Procedural;

/// A scene file is a page of text; anything larger is something else.
const MAX_BYTES: u64 = 16 << 20;

/// The scene rendered when none is named.
const BUILT_IN: &str = include_str!("../../../assets/scenes/default.toml");

/// A checked scene file, its choices still open.
#[derive(Clone, Debug)]
pub struct SceneFile {
    /// What it says.
    pub spec: SceneSpec,
    /// What paths in it are relative to.
    pub(super) folder: PathBuf,
}

impl SceneFile {
    /// Reads a scene file and applies overrides.
    ///
    /// # Errors
    /// It cannot be read, a key is unknown, or a value is out of range.
    pub fn load(path: &Path, overrides: &[Override]) -> Result<Self, SceneError> {
        let fail = |why: String| SceneError::plain(format!("{}: {why}", path.display()));
        let file = std::fs::File::open(path).map_err(|e| fail(format!("cannot open: {e}")))?;
        let mut bytes = Vec::new();
        file.take(MAX_BYTES + 1)
            .read_to_end(&mut bytes)
            .map_err(|e| fail(format!("cannot read: {e}")))?;
        if bytes.len() as u64 > MAX_BYTES {
            return Err(fail(
                "found more than 16 MiB, expected a scene file (TOML text)".to_owned(),
            ));
        }
        let text = String::from_utf8(bytes).map_err(|e| {
            fail(format!(
                "found a byte that is not UTF-8 at {}, expected TOML text",
                e.utf8_error().valid_up_to()
            ))
        })?;
        let folder = path.parent().unwrap_or(Path::new("")).to_owned();
        Self::parse(&text, &path.display().to_string(), folder, overrides)
    }

    /// The built-in scene.
    ///
    /// # Errors
    /// An override is wrong.
    pub fn built_in(overrides: &[Override]) -> Result<Self, SceneError> {
        Self::parse(BUILT_IN, "built-in scene", PathBuf::new(), overrides)
    }

    /// A scene around a volume file, or a picture as a map of heights; everything else is chosen to suit it.
    ///
    /// # Errors
    /// An override is wrong.
    pub fn for_volume_file(
        path: &Path,
        options: &ReadOptions,
        overrides: &[Override],
    ) -> Result<Self, SceneError> {
        let file = toml::Value::from(path.to_string_lossy().into_owned());
        let ending = path.extension().unwrap_or_default();
        let maps = ["png", "tif", "tiff"];
        let key = if maps.iter().any(|e| ending.eq_ignore_ascii_case(e)) {
            "volume.height_field.file"
        } else {
            "volume.file"
        };
        let text = format!("{key} = {file}");
        let mut scene = Self::parse(&text, "command line", PathBuf::new(), overrides)?;
        let volume = &mut scene.spec.volume;
        if volume.file.is_none() {
            return Ok(scene);
        }
        volume.time = volume.time.or(Some(options.time));
        let given = volume.raw.take();
        let chosen = options.raw.as_ref().map(|r| RawSpec {
            dims: r.dims,
            scalar_type: r.scalar_type,
            spacing: Some(r.spacing),
            endian: Some(if r.big_endian {
                Endian::Big
            } else {
                Endian::Little
            }),
            skip_bytes: Some(r.skip_bytes),
        });
        volume.raw = given.or(chosen);
        Ok(scene)
    }

    /// The scene of a procedural volume: its file in `assets/scenes`.
    ///
    /// # Errors
    /// An override is wrong.
    pub fn for_procedural(
        procedural: Procedural,
        overrides: &[Override],
    ) -> Result<Self, SceneError> {
        let text = match procedural {
            Procedural::MarschnerLobb => include_str!("../../../assets/scenes/marschner_lobb.toml"),
            Procedural::SheppLogan => include_str!("../../../assets/scenes/shepp_logan.toml"),
            Procedural::Supernova => BUILT_IN,
            Procedural::Cloud => include_str!("../../../assets/scenes/cloud.toml"),
            Procedural::Cumulus => include_str!("../../../assets/scenes/cumulus.toml"),
            Procedural::MechanicalPart => {
                include_str!("../../../assets/scenes/mechanical_part.toml")
            }
        };
        Self::parse(text, procedural.name(), PathBuf::new(), overrides)
    }

    /// Parses a scene; `name` stands for the file in messages.
    ///
    /// # Errors
    /// The text is not TOML, a key is unknown, or a value is out of range.
    pub fn parse(
        text: &str,
        name: &str,
        folder: PathBuf,
        overrides: &[Override],
    ) -> Result<Self, SceneError> {
        let mut table: toml::Table = toml::from_str(text).map_err(|e| {
            let span = e.span().unwrap_or(0..0);
            SceneError::at(name, text, span, &reword(e.message(), None).0, None)
        })?;
        let working_folder = std::env::current_dir().unwrap_or_default();
        for o in overrides {
            let mut o = o.clone();
            o.anchor(&working_folder);
            o.apply(&mut table)?;
        }
        let place = |p: Problem| place(p, text, name, overrides);
        if let Some(problem) = unknown(&table, &schema()) {
            return Err(place(problem));
        }
        let table = toml::Value::Table(table);
        let spec: SceneSpec = serde_path_to_error::deserialize(table.clone()).map_err(|e| {
            let path: Vec<_> = e
                .path()
                .iter()
                .map(|s| s.to_string().trim_matches(['[', ']']).to_owned())
                .collect();
            let (message, help) = reword(e.inner().message(), value_at(&table, &path));
            place(Problem {
                path,
                message,
                help,
            })
        })?;
        validate::check(&spec).map_err(place)?;
        Ok(Self { spec, folder })
    }
}

/// The value of a key.
fn value_at<'a>(root: &'a toml::Value, path: &[String]) -> Option<&'a toml::Value> {
    path.iter().try_fold(root, |value, key| match value {
        toml::Value::Array(list) => list.get(key.parse::<usize>().ok()?),
        _ => value.get(key),
    })
}

/// Says where a problem stands: in an override if one set the key, else in the file.
fn place(problem: Problem, text: &str, name: &str, overrides: &[Override]) -> SceneError {
    let message = format!("{}: {}", problem.path.join("."), problem.message);
    let leads =
        |o: &&Override| problem.path.starts_with(&o.path) || o.path.starts_with(&problem.path);
    if let Some(o) = overrides.iter().rev().find(leads) {
        return SceneError::plain(format!("--set {}: {message}", o.text)).with_help(problem.help);
    }
    match locate(text, &problem.path) {
        Some(span) => SceneError::at(name, text, span, &message, problem.help),
        None => SceneError::plain(format!("{name}: {message}")).with_help(problem.help),
    }
}
