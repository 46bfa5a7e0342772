//! Reading a transfer function file.

use std::io::Read;
use std::path::Path;

use super::definition::Definition;
use super::{TransferFunction, TransferFunctionError, paraview};
use crate::volume::{Grid, Statistics};

/// Largest file that is read, bytes. 100 000 points take less than 16 MiB.
const BYTES_MAX: u64 = 32 << 20;

/// Reads a transfer function file, by its ending.
///
/// `.json`: a ParaView colour map or a list `[[value, r, g, b, opacity], ...]`; see
/// [`read_paraview`](super::read_paraview). Opacity of a ParaView map is per `opacity_unit_distance`
/// = the approximate length of a cell, ParaView's own default: the box's diagonal over the cube root
/// of the number of voxels.
///
/// `.toml`: Tyndall's own format, that of the presets in `assets/transfer_functions/`:
///
/// | key | meaning |
/// |---|---|
/// | `description` | optional text |
/// | `color_space` | `srgb` (encoded, in [0, 1]) or `linear` (>= 0), of the control points |
/// | `units` | `data` or `hounsfield`: data values; `relative`: 0 is where the background ends, 1 the bright end of the foreground |
/// | `opacity_unit_distance` | world units (mm in CT), or else: |
/// | `opacity_unit_diagonals` | share of the diagonal of the volume's box |
/// | `points` | `[[value, r, g, b, opacity], ...]`, ascending |
///
/// # Errors
/// Names the file, the line or the key, what was found and what was expected.
pub fn read_file(
    path: &Path,
    grid: &Grid,
    statistics: &Statistics,
) -> Result<TransferFunction, TransferFunctionError> {
    let ending = path.extension().and_then(|e| e.to_str()).unwrap_or("");
    if ending.eq_ignore_ascii_case("json") {
        let cell = grid.diagonal() / (grid.voxel_count() as f64).cbrt();
        return paraview::read_json(path, statistics, cell);
    }
    if ending.eq_ignore_ascii_case("toml") {
        let error = |message| TransferFunctionError::new(path.display().to_string(), message);
        let definition = Definition::parse(&text(path)?).map_err(error)?;
        return definition.resolve(&path.display().to_string(), grid, statistics);
    }
    Err(TransferFunctionError::new(
        path.display().to_string(),
        format!("the ending is `{ending}`, expected `json` (ParaView) or `toml`"),
    ))
}

/// The file's text.
pub(super) fn text(path: &Path) -> Result<String, TransferFunctionError> {
    let error = |message: String| TransferFunctionError::new(path.display().to_string(), message);
    let file = std::fs::File::open(path).map_err(|e| error(format!("cannot be opened: {e}")))?;
    let mut text = String::new();
    file.take(BYTES_MAX + 1)
        .read_to_string(&mut text)
        .map_err(|e| error(format!("cannot be read as text: {e}")))?;
    if text.len() as u64 > BYTES_MAX {
        return Err(error(format!(
            "has more than {} MiB, too much for a transfer function",
            BYTES_MAX >> 20
        )));
    }
    Ok(text)
}
