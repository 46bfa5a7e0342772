//! `--set a.b=c`.

use std::path::Path;

use toml::{Table, Value};

use super::SceneError;

/// A key of the scene with the value that replaces it.
#[derive(Clone, Debug, PartialEq)]
pub struct Override {
    /// As the user wrote it.
    pub text: String,
    /// `image.width` is `["image", "width"]`; elements of arrays are named by number.
    pub path: Vec<String>,
    /// The value.
    pub value: Value,
}

/// Keys of which a table holds one group: setting a key of one removes the others.
const ALTERNATIVES: [(&str, &[&[&str]]); 7] = [
    (
        "volume",
        &[&["file", "raw", "time"], &["procedural"], &["height_field"]],
    ),
    ("volume.height_field", &[&["file"], &["procedural"]]),
    (
        "transfer_function",
        &[
            &["preset"],
            &["file"],
            &["points", "color_space"],
            &["extinction", "color_space"],
            &["primitives", "color_space"],
        ],
    ),
    (
        "lights.environment",
        &[&["radiance"], &["file", "scale", "rotation_deg", "up"]],
    ),
    ("lights", &[&["directional"], &["point"], &["environment"]]),
    (
        "camera",
        &[&["eye"], &["azimuth_deg", "elevation_deg", "zoom"]],
    ),
    ("camera", &[&["vfov_deg"], &["orthographic_height"]]),
];

impl Override {
    /// Parses `KEY=VALUE`. The value is TOML; what is not valid TOML is taken as text, so that
    /// `transfer_function.preset=ct_bone` needs no quotes.
    ///
    /// # Errors
    /// There is no `=` or no key.
    pub fn parse(text: &str) -> Result<Self, SceneError> {
        let (key, value) = text.split_once('=').unwrap_or((text, ""));
        let path: Vec<String> = key.trim().split('.').map(str::to_owned).collect();
        if !text.contains('=') || path.iter().any(String::is_empty) {
            return Err(SceneError::plain(format!(
                "--set {text}: expected KEY=VALUE, for example image.width=512"
            )));
        }
        let value = value.trim();
        let parsed = toml::from_str::<Table>(&format!("value = {value}"));
        let value = parsed.ok().and_then(|mut t| t.remove("value"));
        let value = value
            .unwrap_or_else(|| Value::String(text.split_once('=').map_or("", |p| p.1).to_owned()));
        Ok(Self {
            text: text.to_owned(),
            path,
            value,
        })
    }

    /// Applies the override to a parsed scene. The index after the last element appends one.
    ///
    /// # Errors
    /// The path leads through a value that is no table, or beyond the end of an array.
    pub(super) fn apply(&self, scene: &mut Table) -> Result<(), SceneError> {
        let mut root = Value::Table(std::mem::take(scene));
        let result = self.replace(&mut root);
        if let Value::Table(table) = root {
            *scene = table;
        }
        result
    }

    fn replace(&self, root: &mut Value) -> Result<(), SceneError> {
        let mut value = root;
        for (depth, key) in self.path.iter().enumerate() {
            let (walked, rest) = self.path.split_at(depth);
            let absent = match rest.get(1) {
                Some(next) if next.parse::<usize>().is_ok() => Value::Array(Vec::new()),
                _ => Value::Table(Table::new()),
            };
            if value.is_bool() {
                // A switch gives way to a table.
                *value = Value::Table(Table::new());
            }
            let name = walked.last().map_or("", String::as_str);
            value = match value {
                Value::Table(table) => {
                    drop_alternatives(table, walked, key);
                    table.entry(key.clone()).or_insert(absent)
                }
                Value::Array(list) => {
                    let length = list.len();
                    let index = key.parse().unwrap_or(usize::MAX);
                    if index == length {
                        list.push(absent);
                    }
                    list.get_mut(index).ok_or_else(|| {
                        self.fail(&format!(
                            "`{name}` has {length} elements, expected an index from 0 to {length}"
                        ))
                    })?
                }
                _ => return Err(self.fail(&format!("`{name}` is not a table"))),
            };
        }
        *value = self.value.clone();
        Ok(())
    }

    fn fail(&self, why: &str) -> SceneError {
        SceneError::plain(format!("--set {}: {why}", self.text))
    }

    /// Paths on the command line are relative to the working folder, not to the scene file.
    pub(super) fn anchor(&mut self, folder: &Path) {
        let is_file = self.path.last().is_some_and(|k| k == "file");
        if let (true, Value::String(file)) = (is_file, &mut self.value) {
            *file = folder.join(&*file).to_string_lossy().into_owned();
        }
    }
}

/// Removes what cannot stand beside `key` in the table reached by `walked`.
fn drop_alternatives(table: &mut Table, walked: &[String], key: &str) {
    let is_index = |k: &&String| k.parse::<usize>().is_ok();
    let tables: Vec<_> = walked.iter().filter(|k| !is_index(k)).cloned().collect();
    let path = tables.join(".");
    for (_, groups) in ALTERNATIVES.iter().filter(|(name, _)| *name == path) {
        let with: Vec<_> = groups.iter().filter(|g| g.contains(&key)).collect();
        let beside = |other: &str| with.iter().any(|g| g.contains(&other));
        for other in groups.iter().flat_map(|g| g.iter()) {
            if !with.is_empty() && !beside(other) {
                table.remove(*other);
            }
        }
    }
}
