//! ParaView and VTK colour-map JSON.

use std::path::Path;

use glam::{DVec3, Vec3};
use serde_json::{Map, Value};

use super::color_space::ColorSpace;
use super::definition::POINTS_MAX;
use super::nodes::join;
use super::opacity_curve::{Node, straighten};
use super::read::text;
use super::{ControlPoint, TransferFunction, TransferFunctionError};
use crate::volume::Statistics;

/// Reads a ParaView colour-map JSON file (what its editor exports), or a plain list of points.
///
/// *ParaView*: an object, or an array of which the first is taken, with `RGBPoints`
/// (`[value, r, g, b, ...]`, sRGB-encoded in [0, 1]), optionally `ColorSpace` (`RGB`, `HSV`, `Lab`,
/// `CIELAB`, `Diverging`, `Step`; `RGB` if absent), `HSVWrap`, `Name` and `Points`
/// (`[value, opacity, midpoint, sharpness, ...]`; a ramp from 0 to 1 if absent). Points are sorted
/// by value. The interpolation in the file's space is cut into pieces that are straight in linear
/// RGB. Other fields (`NanColor`, annotations) are ignored.
///
/// As ParaView does with a preset, colours and opacities whose values do not overlap the data, or
/// that are normalised ([0, 1] or [-1, 1] while the data span more than twice that), are stretched
/// over the data's range; the name then says so.
///
/// *Plain list*: `[[value, r, g, b, opacity], ...]` in ascending data values, never stretched. VTK
/// renders such colours without any conversion, so they are taken as *linear*.
///
/// The opacity is per one world unit, VTK's default; [`read_file`](super::read_file) takes ParaView's
/// default, which follows the grid, for ParaView's maps.
///
/// # Errors
/// Names the file, the line or the field, what was found and what was expected.
pub fn read_paraview(
    path: &Path,
    statistics: &Statistics,
) -> Result<TransferFunction, TransferFunctionError> {
    read_json(path, statistics, 1.0)
}

/// Either kind of JSON; `opacity_unit_distance` is that of ParaView's maps.
pub(super) fn read_json(
    path: &Path,
    statistics: &Statistics,
    opacity_unit_distance: f64,
) -> Result<TransferFunction, TransferFunctionError> {
    let name = path.display().to_string();
    let error = |message| TransferFunctionError::new(&name, message);
    let value: Value =
        serde_json::from_str(&text(path)?).map_err(|e| error(format!("not JSON: {e}")))?;
    match &value {
        Value::Object(map) => {
            let map = ColorMap::parse(map).map_err(error)?;
            map.resolve(&name, statistics, opacity_unit_distance)
        }
        Value::Array(items) => match items.first() {
            Some(Value::Object(map)) => {
                let map = ColorMap::parse(map).map_err(error)?;
                map.resolve(&name, statistics, opacity_unit_distance)
            }
            Some(Value::Array(_)) => {
                let points = plain_points(items).map_err(error)?;
                TransferFunction::new(&name, points, 1.0)
            }
            _ => Err(error("the array has no colour map in it".to_owned())),
        },
        _ => Err(error(
            "expected a ParaView colour map (an object with `RGBPoints`, or an array of such) or \
             a list [[value, r, g, b, opacity], ...]"
                .to_owned(),
        )),
    }
}

/// `[[value, r, g, b, opacity], ...]`, linear colours.
fn plain_points(rows: &[Value]) -> Result<Vec<ControlPoint>, String> {
    if rows.len() > POINTS_MAX {
        return Err(format!(
            "{} points, expected at most {POINTS_MAX}",
            rows.len()
        ));
    }
    rows.iter()
        .enumerate()
        .map(|(i, row)| {
            let numbers = numbers(row, &format!("[{i}]"))?;
            let [value, r, g, b, opacity] = numbers[..] else {
                return Err(format!(
                    "[{i}] has {} numbers, expected 5 (value, r, g, b, opacity)",
                    numbers.len()
                ));
            };
            Ok(ControlPoint {
                value,
                color: Vec3::new(r as f32, g as f32, b as f32),
                opacity,
            })
        })
        .collect()
}

/// A ParaView colour map as the file has it, sorted.
struct ColorMap {
    name: Option<String>,
    space: ColorSpace,
    colors: Vec<(f64, DVec3)>,
    opacities: Vec<Node>,
}

impl ColorMap {
    fn parse(map: &Map<String, Value>) -> Result<Self, String> {
        let Some(colors) = map.get("RGBPoints") else {
            return Err(if map.contains_key("IndexedColors") {
                "`IndexedColors` without `RGBPoints`: a map of categories has no values".to_owned()
            } else {
                "`RGBPoints` is missing, expected [value, r, g, b, ...]".to_owned()
            });
        };
        let colors = color_points(colors)?;
        let opacities = match map.get("Points") {
            Some(Value::Null) | None => ramp(&colors),
            Some(points) => opacity_points(points)?,
        };
        Ok(Self {
            name: map.get("Name").and_then(Value::as_str).map(str::to_owned),
            space: color_space(map)?,
            colors,
            opacities,
        })
    }

    fn resolve(
        mut self,
        path: &str,
        statistics: &Statistics,
        opacity_unit_distance: f64,
    ) -> Result<TransferFunction, TransferFunctionError> {
        let data = (statistics.min, statistics.max);
        let mut values: Vec<&mut f64> = self.colors.iter_mut().map(|c| &mut c.0).collect();
        let mut stretched = stretch(&mut values, data);
        let mut values: Vec<&mut f64> = self.opacities.iter_mut().map(|n| &mut n.value).collect();
        stretched |= stretch(&mut values, data);

        let mut name = path.to_owned();
        if let Some(own) = &self.name {
            name = format!("{name}: {own}");
        }
        if stretched {
            name = format!("{name} (stretched over the data: {} … {})", data.0, data.1);
        }
        let colors = self.space.linear_nodes(&self.colors);
        let points = join(&colors, &straighten(&self.opacities));
        TransferFunction::new(name, points, opacity_unit_distance).map_err(|e| {
            TransferFunctionError {
                path: path.to_owned(),
                ..e
            }
        })
    }
}

fn color_space(map: &Map<String, Value>) -> Result<ColorSpace, String> {
    let name = match map.get("ColorSpace") {
        None => "RGB",
        Some(Value::String(name)) => name,
        Some(other) => {
            return Err(format!(
                "`ColorSpace` is {}, expected a string",
                shown(other)
            ));
        }
    };
    let wrap = match map.get("HSVWrap") {
        None => true,
        Some(Value::Bool(wrap)) => *wrap,
        Some(other) => other.as_f64() != Some(0.0),
    };
    ColorSpace::from_name(name, wrap).ok_or_else(|| {
        format!(
            "`ColorSpace` is \"{name}\", expected RGB, HSV, Lab, CIELAB, Lab/CIEDE2000, Diverging \
             or Step"
        )
    })
}

fn color_points(value: &Value) -> Result<Vec<(f64, DVec3)>, String> {
    let mut points = Vec::new();
    for (i, p) in groups(value, "RGBPoints")?.into_iter().enumerate() {
        let color = DVec3::new(p[1], p[2], p[3]);
        if color.min_element() < 0.0 || color.max_element() > 1.0 {
            return Err(format!(
                "`RGBPoints` point {i} has the colour {:?}, expected numbers in [0, 1]",
                &p[1..]
            ));
        }
        points.push((p[0], color));
    }
    if points.is_empty() {
        return Err("`RGBPoints` is empty, expected at least one point".to_owned());
    }
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    keep_jumps(&mut points, |p| p.0);
    Ok(points)
}

fn opacity_points(value: &Value) -> Result<Vec<Node>, String> {
    let mut nodes = Vec::new();
    for (i, p) in groups(value, "Points")?.into_iter().enumerate() {
        for (name, number) in ["opacity", "midpoint", "sharpness"].iter().zip(&p[1..]) {
            if !(0.0..=1.0).contains(number) {
                return Err(format!(
                    "`Points` point {i} has the {name} {number}, expected a number in [0, 1]"
                ));
            }
        }
        nodes.push(Node {
            value: p[0],
            opacity: p[1],
            midpoint: p[2],
            sharpness: p[3],
        });
    }
    if nodes.is_empty() {
        return Err("`Points` is empty, expected at least one point".to_owned());
    }
    nodes.sort_by(|a, b| a.value.total_cmp(&b.value));
    keep_jumps(&mut nodes, |n| n.value);
    Ok(nodes)
}

/// Opacity 0 to 1 over the colours' range.
fn ramp(colors: &[(f64, DVec3)]) -> Vec<Node> {
    let node = |value, opacity| Node {
        value,
        opacity,
        midpoint: 0.5,
        sharpness: 0.0,
    };
    match colors {
        [] => Vec::new(),
        [only] => vec![node(only.0, 1.0)],
        [first, .., last] => vec![node(first.0, 0.0), node(last.0, 1.0)],
    }
}

/// Drops all but the first and the last of the points that share a value.
fn keep_jumps<T>(points: &mut Vec<T>, value: impl Fn(&T) -> f64) {
    let inner: Vec<bool> = (0..points.len())
        .map(|i| {
            let same = |j: Option<usize>| {
                j.and_then(|j| points.get(j))
                    .is_some_and(|p| value(p) == value(&points[i]))
            };
            same(i.checked_sub(1)) && same(Some(i + 1))
        })
        .collect();
    let mut inner = inner.into_iter();
    points.retain(|_| !inner.next().unwrap_or(false));
}

/// Maps ascending values onto the data's range where ParaView would; returns whether it did.
fn stretch(values: &mut [&mut f64], (data_min, data_max): (f64, f64)) -> bool {
    let (Some(first), Some(last)) = (values.first(), values.last()) else {
        return false;
    };
    let (min, max) = (**first, **last);
    let apart = max < data_min || min > data_max;
    let normalised = max == 1.0 && (min == 0.0 || min == -1.0);
    let stretched = max > min
        && data_max > data_min
        && (apart || normalised && data_max - data_min > 2.0 * (max - min));
    if stretched {
        for value in values {
            **value = data_min + (**value - min) / (max - min) * (data_max - data_min);
        }
    }
    stretched
}

/// A flat array's numbers in fours.
fn groups(value: &Value, key: &str) -> Result<Vec<[f64; 4]>, String> {
    let numbers = numbers(value, &format!("`{key}`"))?;
    let (groups, rest) = numbers.as_chunks::<4>();
    if !rest.is_empty() {
        return Err(format!(
            "`{key}` has {} numbers, expected a multiple of 4",
            numbers.len()
        ));
    }
    if groups.len() > POINTS_MAX {
        return Err(format!(
            "`{key}` has {} points, expected at most {POINTS_MAX}",
            groups.len()
        ));
    }
    Ok(groups.to_vec())
}

fn numbers(value: &Value, key: &str) -> Result<Vec<f64>, String> {
    let Value::Array(items) = value else {
        return Err(format!(
            "{key} is {}, expected an array of numbers",
            shown(value)
        ));
    };
    items
        .iter()
        .enumerate()
        .map(|(i, item)| {
            item.as_f64()
                .filter(|n| n.is_finite())
                .ok_or_else(|| format!("{key}[{i}] is {}, expected a number", shown(item)))
        })
        .collect()
}

/// The start of a value's JSON: a message does not repeat a whole file.
fn shown(value: &Value) -> String {
    value.to_string().chars().take(40).collect()
}
