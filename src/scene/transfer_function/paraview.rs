//! ParaView and VTK colour-map JSON.

use std::path::Path;

use super::TransferFunction;
use crate::volume::Statistics;

/// A transfer function file that cannot be read.
#[derive(Debug, thiserror::Error)]
#[error("{path}: {message}")]
pub struct TransferFunctionError {
    /// The file.
    pub path: String,
    /// What was found and what was expected.
    pub message: String,
}

/// Reads a ParaView (or VTK/tomviz/Slicer-style) colour-map JSON file.
///
/// # Errors
/// Names the file, the field, what was found and what was expected.
pub fn read_paraview(
    path: &Path,
    statistics: &Statistics,
) -> Result<TransferFunction, TransferFunctionError> {
    let _ = statistics;
    Err(TransferFunctionError {
        path: path.display().to_string(),
        message: String::new(),
    })
}

/// temp
pub fn read_file(
    path: &Path,
    _grid: &crate::volume::Grid,
    statistics: &Statistics,
) -> Result<TransferFunction, TransferFunctionError> {
    read_paraview(path, statistics)
}
