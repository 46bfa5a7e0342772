//! `spirv/manifest.toml`.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::{ShaderError, flatten, sources};

/// What every module in `spirv/` was made from.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Manifest {
    /// Compiler and version.
    pub compiler: String,
    /// Options given to it.
    pub options: String,
    /// One entry a module, by `technique/stage`.
    pub modules: BTreeMap<String, ModuleEntry>,
}

/// One compiled module.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ModuleEntry {
    /// SHA-256 of the include-flattened source.
    pub source: String,
    /// SHA-256 of the module.
    pub spirv: String,
}

impl Manifest {
    /// Reads `root/spirv/manifest.toml`.
    ///
    /// # Errors
    /// It cannot be read or understood.
    pub fn read(root: &Path) -> Result<Self, ShaderError> {
        let path = root.join("spirv/manifest.toml");
        let text = fs::read_to_string(&path).map_err(|source| ShaderError::Io {
            path: path.clone(),
            source,
        })?;
        toml::from_str(&text).map_err(|e| ShaderError::Other(format!("{}: {e}", path.display())))
    }
}

/// Names what is stale: sources without module, modules without source, and either changed since
/// the manifest was written. Empty if all is fresh.
///
/// # Errors
/// A file cannot be read.
pub fn stale(root: &Path) -> Result<Vec<String>, ShaderError> {
    let manifest = Manifest::read(root)?;
    let names = sources(root)?;
    let mut stale = Vec::new();
    for name in &names {
        let Some(entry) = manifest.modules.get(name) else {
            stale.push(format!("glsl/{name}.comp was never compiled"));
            continue;
        };
        if hash(flatten(root, name)?.as_bytes()) != entry.source {
            stale.push(format!("glsl/{name}.comp changed since it was compiled"));
        }
        let path = root.join(format!("spirv/{name}.spv"));
        match fs::read(&path) {
            Ok(module) if hash(&module) == entry.spirv => {}
            Ok(_) => stale.push(format!(
                "spirv/{name}.spv is not the module that was compiled"
            )),
            Err(e) => stale.push(format!("spirv/{name}.spv: {e}")),
        }
    }
    let orphans = manifest.modules.keys().filter(|name| !names.contains(name));
    stale.extend(orphans.map(|name| format!("spirv/{name}.spv has no source")));
    Ok(stale)
}

/// SHA-256, hexadecimal.
pub(crate) fn hash(bytes: &[u8]) -> String {
    Sha256::digest(bytes)
        .iter()
        .map(|b| format!("{b:02x}"))
        .collect()
}
