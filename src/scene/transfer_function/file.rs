//! Transfer function files.

use std::io::Read;
use std::path::Path;

use glam::Vec3;
use serde::Deserialize;

use super::{ControlPoint, TransferFunction, read_color_map};
use crate::scene::linear_from_srgb;
use crate::volume::{Grid, Statistics};

/// Colour maps are small; anything larger is something else.
const MAX_BYTES: u64 = 16 << 20;

/// A transfer function file that cannot be read.
#[derive(Debug, thiserror::Error)]
#[error("{path}: {message}")]
pub struct TransferFunctionError {
    /// The file.
    pub path: String,
    /// What was found and what was expected.
    pub message: String,
}

impl TransferFunctionError {
    pub(super) fn new(path: &Path, message: impl Into<String>) -> Self {
        Self {
            path: path.display().to_string(),
            message: message.into(),
        }
    }
}

/// A Tyndall transfer function, the format of `assets/transfer_functions/*.toml`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct TransferFunctionFile {
    /// What it shows.
    #[serde(default)]
    pub(super) description: String,
    /// `data`: values are data values. `foreground`: 0 is the histogram's background threshold, 1
    /// its bright end.
    pub(super) units: Units,
    /// Encoding of the colours.
    pub(super) color_space: FileColorSpace,
    /// World distance over which the opacity is reached; this or the next.
    pub(super) opacity_unit_distance: Option<f64>,
    /// The same as a share of the volume's diagonal.
    pub(super) opacity_unit_diagonals: Option<f64>,
    /// Rows of value, r, g, b, opacity.
    pub(super) points: Vec<[f64; 5]>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Units {
    Data,
    Foreground,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum FileColorSpace {
    Srgb,
    Linear,
}

/// Reads a transfer function: a ParaView or VTK colour map (`.json`) or a Tyndall one (`.toml`).
///
/// # Errors
/// Names the file, what was found and what was expected.
pub fn read_file(
    path: &Path,
    grid: &Grid,
    statistics: &Statistics,
) -> Result<TransferFunction, TransferFunctionError> {
    let fail = |message: String| TransferFunctionError::new(path, message);
    let file = std::fs::File::open(path).map_err(|e| fail(format!("cannot open: {e}")))?;
    let mut text = String::new();
    file.take(MAX_BYTES)
        .read_to_string(&mut text)
        .map_err(|e| fail(format!("cannot read: {e}")))?;
    let ending = path
        .extension()
        .map(|e| e.to_string_lossy().to_lowercase())
        .unwrap_or_default();
    match ending.as_str() {
        "json" => read_color_map(path, &text, statistics),
        "toml" => parse(&text, &path.display().to_string(), grid, statistics).map_err(fail),
        _ => Err(fail(
            "found another ending, expected .json (ParaView) or .toml".to_owned(),
        )),
    }
}

/// Parses a Tyndall transfer function for a volume.
pub(super) fn parse(
    text: &str,
    name: &str,
    grid: &Grid,
    statistics: &Statistics,
) -> Result<TransferFunction, String> {
    let file: TransferFunctionFile = toml::from_str(text).map_err(|e| e.to_string())?;
    let (low, high) = match file.units {
        Units::Data => (0.0, 1.0),
        Units::Foreground => statistics.foreground(),
    };
    let mut points = Vec::with_capacity(file.points.len());
    for [value, r, g, b, opacity] in file.points {
        let color = Vec3::new(r as f32, g as f32, b as f32);
        let color = match file.color_space {
            FileColorSpace::Linear => color,
            FileColorSpace::Srgb => Vec3::from(color.to_array().map(linear_from_srgb)),
        };
        points.push(ControlPoint {
            value: low + value * (high - low),
            color,
            opacity,
        });
    }
    let distance = match (file.opacity_unit_distance, file.opacity_unit_diagonals) {
        (Some(distance), None) => distance,
        (None, Some(share)) => share * grid.diagonal(),
        _ => {
            return Err("expected one of opacity_unit_distance, opacity_unit_diagonals".to_owned());
        }
    };
    let name = if file.description.is_empty() {
        name.to_owned()
    } else {
        format!("{name} ({})", file.description)
    };
    checked(TransferFunction {
        name,
        points,
        opacity_unit_distance: distance,
    })
}

/// Refuses what cannot be rendered.
pub(super) fn checked(tf: TransferFunction) -> Result<TransferFunction, String> {
    let distance = tf.opacity_unit_distance;
    if !(distance > 0.0 && distance.is_finite()) {
        return Err(format!(
            "opacity unit distance: found {distance}, expected a finite number above 0"
        ));
    }
    let mut before = f64::NEG_INFINITY;
    for (i, p) in tf.points.iter().enumerate() {
        if !p.value.is_finite() || p.value < before {
            return Err(format!(
                "point {i}: found value {} after {before}, expected finite values in ascending order",
                p.value
            ));
        }
        if !(p.color.is_finite() && p.color.min_element() >= 0.0) {
            return Err(format!(
                "point {i}: found colour {}, expected finite numbers of at least 0",
                p.color
            ));
        }
        if !(0.0..=1.0).contains(&p.opacity) {
            return Err(format!(
                "point {i}: found opacity {}, expected a number from 0 to 1",
                p.opacity
            ));
        }
        before = p.value;
    }
    Ok(tf)
}
