//! Piecewise-linear curves over data values, and joining a colour and an opacity curve.

use std::ops::{Add, Mul, Sub};

use glam::{DVec3, Vec3};

use super::ControlPoint;

/// Nodes ascending in value; two may share a value (a jump). Constant beyond the outer ones.
pub(super) type Nodes<T> = Vec<(f64, T)>;

/// One point at every value at which either curve has a node (two at a jump).
/// Nothing if either curve is empty.
pub(super) fn join(colors: &Nodes<DVec3>, opacities: &Nodes<f64>) -> Vec<ControlPoint> {
    let mut values: Vec<f64> = colors
        .iter()
        .map(|n| n.0)
        .chain(opacities.iter().map(|n| n.0))
        .collect();
    values.sort_by(f64::total_cmp);
    values.dedup();
    let mut points = Vec::with_capacity(values.len());
    for value in values {
        let (Some(color), Some(opacity)) = (limits(colors, value), limits(opacities, value)) else {
            return Vec::new();
        };
        let point = |color: DVec3, opacity: f64| ControlPoint {
            value,
            color: Vec3::new(color.x as f32, color.y as f32, color.z as f32),
            opacity,
        };
        points.push(point(color.0, opacity.0));
        if color.0 != color.1 || opacity.0 != opacity.1 {
            points.push(point(color.1, opacity.1));
        }
    }
    points
}

/// The curve's limits from below and from above at `value`; `None` for an empty curve.
fn limits<T>(nodes: &[(f64, T)], value: f64) -> Option<(T, T)>
where
    T: Copy + Add<Output = T> + Sub<Output = T> + Mul<f64, Output = T>,
{
    let first = nodes.partition_point(|n| n.0 < value);
    let end = nodes.partition_point(|n| n.0 <= value);
    if first < end {
        return Some((nodes[first].1, nodes[end - 1].1));
    }
    let between = match (first.checked_sub(1).map(|i| nodes[i]), nodes.get(first)) {
        (Some((a, below)), Some(&(b, above))) => below + (above - below) * ((value - a) / (b - a)),
        (Some((_, only)), None) | (None, Some(&(_, only))) => only,
        (None, None) => return None,
    };
    Some((between, between))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn joined_curves_agree_with_both() {
        let colors = vec![(0.0, DVec3::ZERO), (1.0, DVec3::ONE)];
        let opacities = vec![(0.25, 0.0), (0.5, 0.2), (0.5, 0.8), (2.0, 1.0)];
        let points = join(&colors, &opacities);
        let seen: Vec<_> = points
            .iter()
            .map(|p| (p.value, p.color.x, (p.opacity * 1e6).round() / 1e6))
            .collect();
        assert_eq!(
            seen,
            [
                (0.0, 0.0, 0.0),
                (0.25, 0.25, 0.0),
                (0.5, 0.5, 0.2),
                (0.5, 0.5, 0.8),
                (1.0, 1.0, 0.866_667),
                (2.0, 1.0, 1.0),
            ]
        );
        assert!(join(&Vec::new(), &opacities).is_empty());
    }
}
