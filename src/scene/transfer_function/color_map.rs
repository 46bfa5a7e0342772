//! ParaView and VTK colour-map JSON.
//!
//! ParaView's colours are sRGB and become linear here. A plain list of `[value, r, g, b, opacity]`
//! rows holds linear colours: VTK renders such numbers as they are.

use std::path::Path;

use glam::Vec3;
use serde::Deserialize;
use serde_json::Value;

use super::file::checked;
use super::interpolate::{Space, between};
use super::{ControlPoint, TransferFunction, TransferFunctionError};
use crate::scene::linear_from_srgb;
use crate::volume::Statistics;

/// More nodes than any editor makes.
const MAX_NODES: usize = 100_000;

/// Straight pieces that stand for one curved one.
const PIECES: usize = 32;

/// What is read of a ParaView colour map; everything else in it is ignored.
#[derive(Deserialize)]
#[serde(rename_all = "PascalCase")]
struct ColorMap {
    #[serde(default)]
    name: String,
    #[serde(default)]
    color_space: String,
    #[serde(default, rename = "RGBPoints")]
    rgb_points: Vec<f64>,
    #[serde(default)]
    points: Vec<f64>,
}

/// Parses a ParaView colour map (an array of them: the first), or a plain list of rows.
///
/// A map over [0, 1] or [-1, 1], or one whose range the data do not meet, is stretched over the
/// data's range, as ParaView does when a preset is loaded. Without opacities they rise from 0 to 1.
///
/// # Errors
/// Names the file, what was found and what was expected.
pub fn read_color_map(
    path: &Path,
    text: &str,
    statistics: &Statistics,
) -> Result<TransferFunction, TransferFunctionError> {
    let fail = |message: String| TransferFunctionError::new(path, message);
    let json: Value = serde_json::from_str(text).map_err(|e| fail(e.to_string()))?;
    if let Ok(rows) = serde_json::from_value::<Vec<[f64; 5]>>(json.clone()) {
        return plain_list(&rows, path).map_err(fail);
    }
    let map = match json {
        Value::Array(list) => list.into_iter().next().unwrap_or(Value::Null),
        other => other,
    };
    let map: ColorMap = serde_json::from_value(map).map_err(|e| {
        fail(format!(
            "expected a ParaView colour map or a list of [value, r, g, b, opacity]: {e}"
        ))
    })?;
    from_paraview(&map, path, statistics).map_err(fail)
}

fn plain_list(rows: &[[f64; 5]], path: &Path) -> Result<TransferFunction, String> {
    let point = |&[value, r, g, b, opacity]: &[f64; 5]| ControlPoint {
        value,
        color: Vec3::new(r as f32, g as f32, b as f32),
        opacity,
    };
    checked(TransferFunction {
        name: path.display().to_string(),
        points: rows.iter().map(point).collect(),
        opacity_unit_distance: 1.0,
    })
}

fn from_paraview(
    map: &ColorMap,
    path: &Path,
    statistics: &Statistics,
) -> Result<TransferFunction, String> {
    let nodes = quadruples(&map.rgb_points, "RGBPoints", "value, r, g, b")?;
    let mut opacities = quadruples(&map.points, "Points", "value, opacity, midpoint, sharpness")?;
    let (Some(first), Some(last)) = (nodes.first(), nodes.last()) else {
        return Err("RGBPoints: found none, expected value, r, g, b for each node".to_owned());
    };
    if opacities.is_empty() {
        opacities = vec![[first[0], 0.0, 0.5, 0.0], [last[0], 1.0, 0.5, 0.0]];
    }
    let space = Space::parse(&map.color_space)?;
    let mut values: Vec<f64> = Vec::new();
    for list in [&nodes, &opacities] {
        for w in list.windows(2) {
            values.extend(
                (0..PIECES).map(|i| w[0][0] + (w[1][0] - w[0][0]) * i as f64 / PIECES as f64),
            );
        }
        values.extend(list.last().map(|n| n[0]));
    }
    values.sort_by(f64::total_cmp);
    values.dedup();
    let stretch = Stretch::new(first[0], last[0], statistics);
    let point = |value: &f64| ControlPoint {
        value: stretch.apply(*value),
        color: Vec3::from(
            color_at(&nodes, *value, space)
                .to_array()
                .map(linear_from_srgb),
        ),
        opacity: opacity_at(&opacities, *value),
    };
    let name = if map.name.is_empty() {
        path.display().to_string()
    } else {
        map.name.clone()
    };
    checked(TransferFunction {
        name: format!("{name}{}", stretch.remark),
        points: values.iter().map(point).collect(),
        opacity_unit_distance: 1.0,
    })
}

/// Maps a normalised colour map to the data's range.
struct Stretch {
    from: f64,
    scale: f64,
    to: f64,
    remark: &'static str,
}

impl Stretch {
    fn new(min: f64, max: f64, s: &Statistics) -> Self {
        let normalised = max == 1.0 && (min == 0.0 || min == -1.0) && (s.max > 1.5 || s.min < -1.5);
        let apart = max < s.min || min > s.max;
        if (normalised || apart) && max > min && s.max > s.min {
            let remark = ", stretched over the data's range";
            Self {
                from: min,
                scale: (s.max - s.min) / (max - min),
                to: s.min,
                remark,
            }
        } else {
            Self {
                from: 0.0,
                scale: 1.0,
                to: 0.0,
                remark: "",
            }
        }
    }

    fn apply(&self, value: f64) -> f64 {
        self.to + (value - self.from) * self.scale
    }
}

/// Rows of four, sorted by value.
fn quadruples(flat: &[f64], key: &str, what: &str) -> Result<Vec<[f64; 4]>, String> {
    if !flat.len().is_multiple_of(4) || flat.len() / 4 > MAX_NODES {
        return Err(format!(
            "{key}: found {} numbers, expected rows of four ({what})",
            flat.len()
        ));
    }
    let mut rows: Vec<[f64; 4]> = flat.as_chunks::<4>().0.to_vec();
    if rows.iter().flatten().any(|v| !v.is_finite()) {
        return Err(format!("{key}: found a number that is not finite"));
    }
    rows.sort_by(|a, b| a[0].total_cmp(&b[0]));
    Ok(rows)
}

fn color_at(nodes: &[[f64; 4]], value: f64, space: Space) -> Vec3 {
    let rgb = |n: &[f64; 4]| Vec3::new(n[1] as f32, n[2] as f32, n[3] as f32);
    let upper = nodes.partition_point(|n| n[0] <= value);
    match (
        upper.checked_sub(1).and_then(|i| nodes.get(i)),
        nodes.get(upper),
    ) {
        (Some(a), Some(b)) => between(
            rgb(a),
            rgb(b),
            ((value - a[0]) / (b[0] - a[0])) as f32,
            space,
        ),
        (Some(n), None) | (None, Some(n)) => rgb(n),
        (None, None) => Vec3::ZERO,
    }
}

/// VTK's piecewise function: the midpoint is where half the way is made, the sharpness bends the
/// line towards a step.
fn opacity_at(nodes: &[[f64; 4]], value: f64) -> f64 {
    let upper = nodes.partition_point(|n| n[0] <= value);
    let (a, b) = match (
        upper.checked_sub(1).and_then(|i| nodes.get(i)),
        nodes.get(upper),
    ) {
        (Some(a), Some(b)) => (a, b),
        (Some(n), None) | (None, Some(n)) => return n[1].clamp(0.0, 1.0),
        (None, None) => return 0.0,
    };
    let midpoint = a[2].clamp(1e-5, 1.0 - 1e-5);
    let s = (value - a[0]) / (b[0] - a[0]);
    let s = if s < midpoint {
        0.5 * s / midpoint
    } else {
        0.5 + 0.5 * (s - midpoint) / (1.0 - midpoint)
    };
    let sharpness = a[3].clamp(0.0, 1.0);
    let eased = if sharpness > 0.99 {
        f64::from(u8::from(s >= 0.5))
    } else {
        let power = 1.0 + 10.0 * sharpness;
        let bent = if s < 0.5 {
            0.5 * (2.0 * s).powf(power)
        } else {
            1.0 - 0.5 * (2.0 - 2.0 * s).powf(power)
        };
        // Hermite, its end slopes falling to 0 with sharpness.
        let (s2, s3) = (bent * bent, bent * bent * bent);
        let slope = 1.0 - sharpness;
        3.0f64.mul_add(s2, -2.0 * s3) + slope * (s3 - 2.0 * s2 + bent) + slope * (s3 - s2)
    };
    (a[1] + eased * (b[1] - a[1])).clamp(0.0, 1.0)
}
