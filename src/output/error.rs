//! What can go wrong with a result file, in the user's terms.

use std::path::PathBuf;

/// A file that cannot be written or read: which file, what was tried, why it failed.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// The operating system refused, or the disk is full.
    #[error("{path}: cannot {action}: {source}", path = path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What was tried: `create a temporary file beside it`, `write`, `rename ...`, `open`.
        action: &'static str,
        /// Why it failed.
        source: std::io::Error,
    },
    /// The folder of the file is not there.
    #[error("{path}: cannot write: the folder {folder} does not exist", path = path.display(),
        folder = folder.display())]
    MissingFolder {
        /// The file.
        path: PathBuf,
        /// Its folder.
        folder: PathBuf,
    },
    /// Something that must not be replaced by a file has that name.
    #[error("{path}: cannot write: it is {found}, expected a file or nothing",
        path = path.display())]
    NotReplaceable {
        /// The path.
        path: PathBuf,
        /// What is there: `a folder`, `a read-only file`, `a device, pipe or socket`.
        found: &'static str,
    },
    /// The picture is empty or does not fill its own size.
    #[error("{path}: cannot write: {width} x {height} picture with {pixels} pixels",
        path = path.display())]
    Size {
        /// The file.
        path: PathBuf,
        /// Pixels across.
        width: u32,
        /// Pixels down.
        height: u32,
        /// Pixels given.
        pixels: usize,
    },
    /// The file is not what its format demands, or uses a part of it that is not read.
    #[error("{path}: cannot read as {format}: {reason}", path = path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// `PNG` or `OpenEXR`.
        format: &'static str,
        /// What was found and what was expected.
        reason: String,
    },
}
