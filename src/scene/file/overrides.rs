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
const ALTERNATIVES: [(&str, &[&[&str]]); 5] = [
    ("volume", &[&["file", "raw", "time"], &["procedural"]]),
    (
        "transfer_function",
        &[&["preset"], &["file"], &["points", "color_space"]],
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

    /// Applies the override to a parsed scene.
    ///
    /// # Errors
    /// The path leads through a value that is no table, or beyond the end of an array.
    pub(super) fn apply(&self, scene: &mut Table) -> Result<(), SceneError> {
        let Some((last, way)) = self.path.split_last() else {
            return Ok(());
        };
        let mut table = scene;
        let mut walked: Vec<&str> = Vec::new();
        let mut way = way.iter().peekable();
        while let Some(key) = way.next() {
            drop_alternatives(table, &walked, key);
            walked.push(key);
            let mut value = table
                .entry(key.clone())
                .or_insert_with(|| Value::Table(Table::new()));
            while value.is_array() && way.peek().is_some() {
                let index = way.next().and_then(|i| i.parse::<usize>().ok());
                let list = value.as_array_mut().map_or(&mut [][..], Vec::as_mut_slice);
                let length = list.len();
                value = index.and_then(|i| list.get_mut(i)).ok_or_else(|| {
                    self.fail(&format!("`{key}` has {length} elements, numbered from 0"))
                })?;
            }
            table = value
                .as_table_mut()
                .ok_or_else(|| self.fail(&format!("`{key}` is not a table")))?;
        }
        drop_alternatives(table, &walked, last);
        table.insert(last.clone(), self.value.clone());
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
fn drop_alternatives(table: &mut Table, walked: &[&str], key: &str) {
    for (name, groups) in ALTERNATIVES {
        if walked.first() != Some(&name) || walked.len() != 1 {
            continue;
        }
        if groups.iter().any(|g| g.contains(&key)) {
            for other in groups
                .iter()
                .filter(|g| !g.contains(&key))
                .flat_map(|g| g.iter())
            {
                table.remove(*other);
            }
        }
    }
}
