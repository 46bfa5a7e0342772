//! From `glsl/` to `spirv/`: what was compiled from what, and (with the feature `shader-compiler`)
//! the compilation itself.
//!
//! Compiled modules are committed, so that users need no C++ toolchain. `spirv/manifest.toml` holds
//! for each module the hash of its include-flattened source, the options, the compiler and the
//! module's own hash; [`stale`] compares it with the files.

#[cfg(feature = "shader-compiler")]
mod compile;
mod flatten;
mod manifest;

#[cfg(feature = "shader-compiler")]
pub use compile::{compile_all, recompiled_differs};
pub use flatten::{flatten, sources};
pub(crate) use manifest::hash;
pub use manifest::{Manifest, ModuleEntry, stale};

/// What can go wrong with shader sources and modules.
#[derive(Debug, thiserror::Error)]
pub enum ShaderError {
    /// A file cannot be read or written.
    #[error("{path}: {source}", path = path.display())]
    Io {
        /// The file or folder.
        path: std::path::PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A source file is not as expected.
    #[error("{path}:{line}: {message}", path = path.display())]
    Source {
        /// The file.
        path: std::path::PathBuf,
        /// Line, from 1.
        line: usize,
        /// What is wrong.
        message: String,
    },
    /// The manifest cannot be understood, or the compiler refused.
    #[error("{0}")]
    Other(String),
}
