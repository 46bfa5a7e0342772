//! What ends a study early.

use std::path::PathBuf;

use crate::output::OutputError;
use crate::scene::file::SceneError;
use crate::technique::RenderError;

/// A study that cannot go on.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    /// A scene, or a setting in it, is not as it should be.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The scene does not fit the device, or Vulkan failed.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// A picture or report could not be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The journal or the cache could not be used.
    #[error("{path}: cannot {action}: {source}", path = path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// What was tried.
        action: &'static str,
        /// Why it failed.
        source: std::io::Error,
    },
    /// A name that is none of the techniques.
    #[error("technique {found}: expected one of {expected}")]
    Technique {
        /// What was asked for.
        found: String,
        /// What there is.
        expected: String,
    },
}
