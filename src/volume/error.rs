//! What can be wrong with a volume, in the user's terms.

use std::path::{Path, PathBuf};

/// A volume that cannot be read: which file, which field, what was found, what was expected.
#[derive(Debug, thiserror::Error)]
pub enum VolumeError {
    /// The operating system refused.
    #[error("{path}: cannot {action}: {source}", path = path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What was tried: `open`, `read`.
        action: &'static str,
        /// Why it failed.
        source: std::io::Error,
    },
    /// A header field or the payload is not as the format demands.
    #[error("{path}: {field}: found {found}, expected {expected}", path = path.display())]
    Field {
        /// The file.
        path: PathBuf,
        /// Header field (`sizes`, `dim[0]`, `DimSize`) or `voxel data`.
        field: String,
        /// What the file says.
        found: String,
        /// What would be right.
        expected: String,
    },
    /// No reader knows this file.
    #[error("{path}: unknown volume format; expected one of {expected}", path = path.display())]
    UnknownFormat {
        /// The file.
        path: PathBuf,
        /// The formats read, with their file name endings.
        expected: &'static str,
    },
    /// The voxels do not fit in this machine's memory.
    #[error("{path}: {bytes} bytes of voxels do not fit in memory", path = path.display())]
    OutOfMemory {
        /// The file.
        path: PathBuf,
        /// Decoded size.
        bytes: u64,
    },
}

impl VolumeError {
    /// A [`VolumeError::Io`].
    pub fn io(path: &Path, action: &'static str, source: std::io::Error) -> Self {
        Self::Io {
            path: path.to_owned(),
            action,
            source,
        }
    }

    /// A [`VolumeError::Field`].
    pub fn field(
        path: &Path,
        field: impl Into<String>,
        found: impl Into<String>,
        expected: impl Into<String>,
    ) -> Self {
        Self::Field {
            path: path.to_owned(),
            field: field.into(),
            found: found.into(),
            expected: expected.into(),
        }
    }
}
