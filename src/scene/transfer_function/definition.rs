//! Tyndall's own transfer function file, TOML: the built-in ones and a user's.

use glam::{DVec3, Vec3};
use serde::Deserialize;

use super::color_space::linear_from_encoded;
use super::histogram::{Histogram, Window};
use super::{ControlPoint, TransferFunction};
use crate::volume::{Grid, Statistics};

/// Most control points that a file may have.
pub(super) const POINTS_MAX: usize = 100_000;

/// A transfer function before it meets a volume.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Definition {
    /// What it shows, for people.
    #[serde(default)]
    pub(super) description: String,
    color_space: Encoding,
    units: Units,
    /// World units.
    opacity_unit_distance: Option<f64>,
    /// Share of the box's diagonal.
    opacity_unit_diagonals: Option<f64>,
    /// Value, red, green, blue, opacity.
    points: Vec<[f64; 5]>,
}

/// What the colours' numbers are.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
enum Encoding {
    Srgb,
    Linear,
}

/// What the points' values are.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "snake_case")]
enum Units {
    /// Data values.
    Data,
    /// Data values of CT.
    Hounsfield,
    /// 0 is the upper foot of the background's peak, 1 the bright end of the foreground.
    Relative,
    /// 0 is the lowest value, 1 the highest.
    Range,
}

impl Definition {
    /// Reads a file's text.
    ///
    /// # Errors
    /// Says line, column and key, what was found and what was expected.
    pub(super) fn parse(text: &str) -> Result<Self, String> {
        let definition: Self = toml::from_str(text).map_err(|e| e.to_string().trim().to_owned())?;
        if definition.points.len() > POINTS_MAX {
            return Err(format!(
                "`points` has {} points, expected at most {POINTS_MAX}",
                definition.points.len()
            ));
        }
        if definition.opacity_unit_distance.is_some() == definition.opacity_unit_diagonals.is_some()
        {
            return Err(
                "expected exactly one of `opacity_unit_distance` (world units) and \
                 `opacity_unit_diagonals` (shares of the volume's diagonal)"
                    .to_owned(),
            );
        }
        for (i, point) in definition.points.iter().enumerate() {
            let color = &point[1..4];
            if definition.color_space == Encoding::Srgb
                && !color.iter().all(|c| (0.0..=1.0).contains(c))
            {
                return Err(format!(
                    "points[{i}]: colour is {color:?}, expected sRGB numbers in [0, 1]"
                ));
            }
        }
        Ok(definition)
    }

    /// The function for a volume.
    ///
    /// # Errors
    /// Where the points break an invariant of [`TransferFunction::new`].
    pub(super) fn resolve(
        &self,
        name: &str,
        grid: &Grid,
        statistics: &Statistics,
    ) -> Result<TransferFunction, super::TransferFunctionError> {
        let window = match self.units {
            Units::Data | Units::Hounsfield => None,
            Units::Relative => Some(window(statistics)),
            Units::Range => Some(whole(statistics)),
        };
        let points = self.points.iter().map(|p| {
            let color = DVec3::new(p[1], p[2], p[3]);
            let color = match self.color_space {
                Encoding::Srgb => linear_from_encoded(color),
                Encoding::Linear => color,
            };
            ControlPoint {
                value: window.map_or(p[0], |w| w.low + p[0] * (w.high - w.low)),
                color: Vec3::new(color.x as f32, color.y as f32, color.z as f32),
                opacity: p[4],
            }
        });
        let distance = match (self.opacity_unit_distance, self.opacity_unit_diagonals) {
            (Some(distance), _) => distance,
            (None, share) => share.unwrap_or_default() * grid.diagonal(),
        };
        TransferFunction::new(name, points.collect(), distance)
    }
}

/// The range of the data; above 0 for a constant volume.
fn whole(statistics: &Statistics) -> Window {
    let (low, high) = (statistics.min, statistics.max);
    let high = if high > low {
        high
    } else {
        low + low.abs().max(1.0)
    };
    Window {
        low,
        split: 0.5 * (low + high),
        high,
    }
}

/// The range for relative values. A constant volume is foreground where it is above 0.
pub(super) fn window(statistics: &Statistics) -> Window {
    if let Some(histogram) = Histogram::of(statistics) {
        return histogram.window();
    }
    let value = statistics.max;
    let (low, high) = if value > 0.0 {
        (0.0, value)
    } else {
        (value, value + value.abs().max(1.0))
    };
    Window {
        low,
        split: 0.5 * (low + high),
        high,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn error(body: &str) -> String {
        Definition::parse(body).err().unwrap_or_default()
    }

    #[test]
    fn errors_name_key_and_expectation() {
        let head = "color_space = \"srgb\"\nunits = \"data\"\n";
        let both = "opacity_unit_distance = 1\nopacity_unit_diagonals = 0.1\npoints = []\n";
        assert!(error(&format!("{head}{both}")).contains("exactly one of"));
        assert!(error(&format!("{head}points = []")).contains("exactly one of"));
        let short = format!("{head}opacity_unit_distance = 1\npoints = [[0, 1, 1, 1]]");
        assert!(error(&short).contains("line 4"), "{}", error(&short));
        let bright = format!("{head}opacity_unit_distance = 1\npoints = [[0, 1, 2, 1, 0]]");
        assert!(error(&bright).contains("points[0]: colour"));
        let unknown = format!("{head}opacity_unit_distance = 1\npoints = []\ngamma = 2");
        assert!(error(&unknown).contains("gamma"));
        assert!(error("color_space = \"hsv\"").contains("srgb"));
    }
}
