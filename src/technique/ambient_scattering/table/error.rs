//! What can go wrong with tables.

use std::path::{Path, PathBuf};

use crate::gpu::GpuError;
use crate::output::OutputError;

/// A table that cannot be built, read or written.
#[derive(Debug, thiserror::Error)]
pub enum TableError {
    /// Vulkan failed.
    #[error(transparent)]
    Gpu(#[from] GpuError),
    /// A file could not be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The operating system refused.
    #[error("{}: cannot {action}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What was tried.
        action: &'static str,
        /// Why it failed.
        source: std::io::Error,
    },
    /// A file is not what it should be.
    #[error("{}: {what} is {found}, expected {expected}", path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// Which part of it.
        what: &'static str,
        /// What it says.
        found: String,
        /// What it may say.
        expected: String,
    },
}

impl TableError {
    pub(super) fn io(path: &Path, action: &'static str, source: std::io::Error) -> Self {
        Self::Io {
            path: path.to_owned(),
            action,
            source,
        }
    }

    pub(super) fn content(
        path: &Path,
        what: &'static str,
        found: impl Into<String>,
        expected: impl Into<String>,
    ) -> Self {
        Self::Content {
            path: path.to_owned(),
            what,
            found: found.into(),
            expected: expected.into(),
        }
    }
}
