//! Include-flattened sources: the text whose hash decides whether a module is stale.

use std::fs;
use std::path::{Path, PathBuf};

use super::ShaderError;

/// Deepest nesting of includes; a cycle ends here.
const MAX_DEPTH: usize = 16;

/// Every compute shader under `root/glsl`, as `technique/stage`, sorted.
///
/// # Errors
/// A folder cannot be read.
pub fn sources(root: &Path) -> Result<Vec<String>, ShaderError> {
    let mut found = Vec::new();
    for folder in entries(&root.join("glsl"))? {
        if !folder.is_dir() {
            continue;
        }
        for file in entries(&folder)? {
            if file.extension().is_some_and(|e| e == "comp")
                && let (Some(technique), Some(stage)) = (folder.file_name(), file.file_stem())
            {
                found.push(format!(
                    "{}/{}",
                    technique.to_string_lossy(),
                    stage.to_string_lossy()
                ));
            }
        }
    }
    found.sort();
    Ok(found)
}

fn entries(folder: &Path) -> Result<Vec<PathBuf>, ShaderError> {
    let io = |source| ShaderError::Io {
        path: folder.to_owned(),
        source,
    };
    fs::read_dir(folder)
        .map_err(io)?
        .map(|e| e.map(|e| e.path()).map_err(io))
        .collect()
}

/// The source of `technique/stage` with every `#include "path"` (relative to `root/glsl`) replaced
/// by the file's text. Line ends are `\n` whatever the checkout made of them.
///
/// # Errors
/// A file cannot be read, or includes nest too deep.
pub fn flatten(root: &Path, name: &str) -> Result<String, ShaderError> {
    let folder = root.join("glsl");
    let mut text = String::new();
    append(&folder, &folder.join(format!("{name}.comp")), 0, &mut text)?;
    Ok(text)
}

fn append(folder: &Path, file: &Path, depth: usize, text: &mut String) -> Result<(), ShaderError> {
    let source = fs::read_to_string(file).map_err(|source| ShaderError::Io {
        path: file.to_owned(),
        source,
    })?;
    for (number, line) in source.lines().enumerate() {
        let included = line
            .trim()
            .strip_prefix("#include")
            .and_then(|rest| rest.trim().strip_prefix('"')?.strip_suffix('"'));
        match included {
            Some(_) if depth >= MAX_DEPTH => {
                return Err(ShaderError::Source {
                    path: file.to_owned(),
                    line: number + 1,
                    message: format!("includes nest deeper than {MAX_DEPTH}"),
                });
            }
            Some(path) => append(folder, &folder.join(path), depth + 1, text)?,
            None => {
                text.push_str(line);
                text.push('\n');
            }
        }
    }
    Ok(())
}
