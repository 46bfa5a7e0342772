//! Compiling with shaderc.

use std::fs;
use std::path::Path;

use super::manifest::hash;
use super::{Manifest, ModuleEntry, ShaderError, flatten, sources};

/// The pinned crate; its bytes differ between versions, the generator word in the module does not.
const COMPILER: &str = "shaderc 0.10.1 (2025.3)";
const OPTIONS: &str = "vulkan1.3, spirv1.6, performance";

/// Compiles every shader under `root/glsl` into `root/spirv` and writes the manifest; returns the
/// names of the modules that changed.
///
/// # Errors
/// A file cannot be read or written, or a shader does not compile.
pub fn compile_all(root: &Path) -> Result<Vec<String>, ShaderError> {
    let mut manifest = Manifest {
        compiler: COMPILER.to_owned(),
        options: OPTIONS.to_owned(),
        ..Manifest::default()
    };
    let mut changed = Vec::new();
    for name in sources(root)? {
        let source = flatten(root, &name)?;
        let module = compile(&name, &source)?;
        let path = root.join(format!("spirv/{name}.spv"));
        if fs::read(&path).ok().as_deref() != Some(&module) {
            write(&path, &module)?;
            changed.push(name.clone());
        }
        let entry = ModuleEntry {
            source: hash(source.as_bytes()),
            spirv: hash(&module),
        };
        manifest.modules.insert(name, entry);
    }
    let text = toml::to_string(&manifest).map_err(|e| ShaderError::Other(e.to_string()))?;
    write(&root.join("spirv/manifest.toml"), text.as_bytes())?;
    Ok(changed)
}

/// Recompiles every shader and names the modules whose committed bytes differ.
///
/// # Errors
/// As [`compile_all`].
pub fn recompiled_differs(root: &Path) -> Result<Vec<String>, ShaderError> {
    let mut differing = Vec::new();
    for name in sources(root)? {
        let module = compile(&name, &flatten(root, &name)?)?;
        if fs::read(root.join(format!("spirv/{name}.spv")))
            .ok()
            .as_deref()
            != Some(&module)
        {
            differing.push(name);
        }
    }
    Ok(differing)
}

fn compile(name: &str, source: &str) -> Result<Vec<u8>, ShaderError> {
    let other = |e: shaderc::Error| ShaderError::Other(e.to_string());
    let compiler = shaderc::Compiler::new().map_err(other)?;
    let mut options = shaderc::CompileOptions::new().map_err(other)?;
    options.set_target_env(
        shaderc::TargetEnv::Vulkan,
        shaderc::EnvVersion::Vulkan1_3 as u32,
    );
    options.set_target_spirv(shaderc::SpirvVersion::V1_6);
    options.set_optimization_level(shaderc::OptimizationLevel::Performance);
    let file = format!("glsl/{name}.comp");
    let artifact = compiler
        .compile_into_spirv(
            source,
            shaderc::ShaderKind::Compute,
            &file,
            "main",
            Some(&options),
        )
        .map_err(other)?;
    Ok(artifact.as_binary_u8().to_vec())
}

fn write(path: &Path, bytes: &[u8]) -> Result<(), ShaderError> {
    let io = |source| ShaderError::Io {
        path: path.to_owned(),
        source,
    };
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder).map_err(io)?;
    }
    fs::write(path, bytes).map_err(io)
}
