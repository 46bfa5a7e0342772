//! VTK's piecewise function: linear segments bent by a midpoint and a sharpness.

use super::nodes::Nodes;

/// Straight pieces that stand in for one bent segment.
const PIECES: usize = 64;

/// One node as `Points` of a ParaView file lists it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Node {
    /// Data value.
    pub(super) value: f64,
    /// Opacity in [0, 1].
    pub(super) opacity: f64,
    /// Where the segment to the next node reaches its half, as a share of its length, in [0, 1].
    pub(super) midpoint: f64,
    /// 0: linear, 1: close to a step at the midpoint.
    pub(super) sharpness: f64,
}

/// Straight nodes of the curve through `nodes` (ascending).
pub(super) fn straighten(nodes: &[Node]) -> Nodes<f64> {
    let mut straight: Nodes<f64> = Vec::with_capacity(nodes.len());
    for pair in nodes.windows(2) {
        let (a, b) = (pair[0], pair[1]);
        straight.push((a.value, a.opacity));
        let at = |s: f64| a.value + s * (b.value - a.value);
        if a.opacity == b.opacity || a.value == b.value {
            continue;
        }
        let midpoint = a.midpoint.clamp(1e-5, 1.0 - 1e-5);
        if a.sharpness < 0.01 {
            if midpoint != 0.5 {
                straight.push((at(midpoint), 0.5 * (a.opacity + b.opacity)));
            }
        } else {
            straight.extend((1..PIECES).map(|i| {
                let s = i as f64 / PIECES as f64;
                (at(s), bend(&a, &b, halve_at(midpoint, s)))
            }));
        }
    }
    if let Some(last) = nodes.last() {
        straight.push((last.value, last.opacity));
    }
    straight
}

/// Moves `midpoint` to 0.5, linearly on either side.
fn halve_at(midpoint: f64, s: f64) -> f64 {
    if s < midpoint {
        0.5 * s / midpoint
    } else {
        0.5 + 0.5 * (s - midpoint) / (1.0 - midpoint)
    }
}

/// VTK's blend from a line (sharpness 0) to nearly a step (1): a power law about the centre, then a
/// cubic Hermite curve whose end slopes fall with the sharpness.
fn bend(a: &Node, b: &Node, s: f64) -> f64 {
    let exponent = 1.0 + 10.0 * a.sharpness;
    let s = if s < 0.5 {
        0.5 * (2.0 * s).powf(exponent)
    } else {
        1.0 - 0.5 * (2.0 * (1.0 - s)).powf(exponent)
    };
    let (s2, s3) = (s * s, s * s * s);
    let rise = b.opacity - a.opacity;
    let slope = (1.0 - a.sharpness) * rise;
    let cubic =
        a.opacity + rise * (3.0 * s2 - 2.0 * s3) + slope * ((s3 - 2.0 * s2 + s) + (s3 - s2));
    cubic.clamp(a.opacity.min(b.opacity), a.opacity.max(b.opacity))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values by VTK 9's `vtkPiecewiseFunction::GetValue` for these four nodes.
    #[test]
    fn agrees_with_vtk() {
        let node = |value, opacity, midpoint, sharpness| Node {
            value,
            opacity,
            midpoint,
            sharpness,
        };
        let nodes = [
            node(0.0, 0.0, 0.3, 0.4),
            node(1.0, 1.0, 0.5, 1.0),
            node(2.0, 0.2, 0.7, 0.0),
            node(3.0, 1.0, 0.5, 0.0),
        ];
        let bent = |s| bend(&nodes[0], &nodes[1], halve_at(0.3, s));
        for (s, expected) in [
            (0.1, 0.00124),
            (0.25, 0.162_524),
            (0.3, 0.5),
            (0.5, 0.934_491),
            (0.75, 0.998_247),
        ] {
            assert!((bent(s) - expected).abs() < 1e-6, "{s}: {}", bent(s));
        }
        let straight = straighten(&nodes);
        assert!(straight.is_sorted_by(|a, b| a.0 <= b.0));
        assert!((bend(&nodes[1], &nodes[2], 0.25) - 0.999_999_857).abs() < 1e-9);
        assert!((bend(&nodes[1], &nodes[2], 0.49) - 0.717_978_678).abs() < 1e-9);
        assert!(
            straight
                .iter()
                .any(|n| (n.0 - 2.7).abs() < 1e-12 && (n.1 - 0.6).abs() < 1e-12)
        );
    }
}
