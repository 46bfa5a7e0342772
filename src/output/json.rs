//! Reports for programs: settings, times of the stages, bytes, device.

use std::io::{self, Write};
use std::path::Path;

use serde_json::Value;

use super::{OutputError, atomic};

/// Writes `value` indented, with a newline at its end.
///
/// # Errors
///
/// As [`atomic::write`].
pub fn write(path: &Path, value: &Value) -> Result<(), OutputError> {
    atomic::write(path, |file| {
        serde_json::to_writer_pretty(&mut *file, value).map_err(io::Error::from)?;
        file.write_all(b"\n")
    })
}
