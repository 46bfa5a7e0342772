//! The next coarser level of a map: half as many columns along x and y, each the mean of what it covers.

use glam::{DAffine3, DVec3, UVec3};

use super::HeightField;
use crate::volume::{ColorVolume, Grid, Rescale, Volume};

impl Volume {
    /// The same medium in the same place from maps of half as many columns along x and y, and half as many layers. A
    /// ramp is at least a layer; depth along z stays what it was.
    ///
    /// `None` for a volume without a height field, and where one column is left.
    #[must_use]
    pub fn halved(&self) -> Option<Self> {
        let field = self.height_field.as_ref()?;
        let (from, to) = columns(self.grid.dims);
        if to == from {
            return None;
        }
        let heights = shrink(from, to, |i| {
            0.5 * (f64::from(field.heights[i]) + 0.5) - 0.5
        });
        let (ramp, thickness) = thinned(field);
        let top = 0.5 * field.top;
        let bottom = top - thickness;
        // The box goes with its faces.
        let (low, high) = (heights.iter()).fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), h| {
            (a.min(*h), b.max(*h))
        });
        let lowest = low + bottom - 0.5 * field.margin;
        let layers = (high + top + 0.5 * field.margin - lowest).ceil().max(1.0);
        let scale = DVec3::new(
            from[0] as f64 / to[0] as f64,
            from[1] as f64 / to[1] as f64,
            2.0,
        );
        // Grid coordinates of the lower corner are -1/2.
        let half = DVec3::splat(0.5);
        let grid = Grid {
            dims: UVec3::new(to[0] as u32, to[1] as u32, layers as u32),
            world_from_index: self.grid.world_from_index
                * DAffine3::from_translation(-half)
                * DAffine3::from_scale(scale)
                * DAffine3::from_translation(half + DVec3::Z * (lowest + 0.5)),
            space: self.grid.space,
        };
        let values = shrink(from, to, |i| self.value(i));
        Some(Self {
            name: self.name.clone(),
            grid,
            voxels: self.voxels.scalar_type().floats(values.into_iter()),
            rescale: Rescale::IDENTITY,
            spatial_unit: self.spatial_unit.clone(),
            height_field: Some(HeightField {
                heights: heights.iter().map(|h| (h - lowest - 0.5) as f32).collect(),
                bottom,
                top,
                ramp,
                margin: 0.5 * field.margin,
                level: field.level + 1,
            }),
        })
    }
}

/// Ramp and thickness, in layers of twice the height: a ramp is at least a layer, so that steps see it, and the optical
/// depth of the whole layer stays what it was.
fn thinned(field: &HeightField) -> (f64, f64) {
    let thickness = field.top - field.bottom;
    let depth = if thickness >= 2.0 * field.ramp {
        thickness - field.ramp
    } else {
        thickness * thickness / (4.0 * field.ramp)
    };
    let (ramp, depth) = ((0.5 * field.ramp).max(1.0), 0.5 * depth);
    let thickness = if depth >= ramp {
        depth + ramp
    } else {
        2.0 * (depth * ramp).sqrt()
    };
    (ramp, thickness)
}

impl ColorVolume {
    /// The colours of [`Volume::halved`].
    #[must_use]
    pub fn halved(&self) -> Self {
        let (from, to) = columns(self.dims);
        let [r, g, b] = [0, 1, 2].map(|c| shrink(from, to, |i| self.color(i)[c]));
        let color = |i: usize| [r[i], g[i], b[i]].map(|c| c as f32);
        let colors: Vec<_> = (0..r.len()).map(color).collect();
        let dims = UVec3::new(to[0] as u32, to[1] as u32, 1);
        Self::new(&self.name, dims, &colors)
    }
}

/// Columns along x and y, and half as many.
fn columns(dims: UVec3) -> ([usize; 2], [usize; 2]) {
    let from = [dims.x, dims.y].map(|n| n as usize);
    (from, from.map(|n| (n / 2).max(1)))
}

/// Means over `to` columns that cover the `from` columns evenly.
fn shrink(from: [usize; 2], to: [usize; 2], value: impl Fn(usize) -> f64) -> Vec<f64> {
    let across: Vec<_> = (0..to[0]).map(|x| covered(x, from[0], to[0])).collect();
    let mut means = Vec::with_capacity(to[0] * to[1]);
    for y in 0..to[1] {
        let rows = covered(y, from[1], to[1]);
        for columns in &across {
            let (mut sum, mut weights) = (0.0, 0.0);
            for (j, v) in &rows {
                for (i, u) in columns {
                    sum += u * v * value(i + from[0] * j);
                    weights += u * v;
                }
            }
            means.push(sum / weights);
        }
    }
    means
}

/// The columns of `from` that column `i` of `to` covers, and how much of each.
fn covered(i: usize, from: usize, to: usize) -> Vec<(usize, f64)> {
    let scale = from as f64 / to as f64;
    let (first, end) = (i as f64 * scale, (i + 1) as f64 * scale);
    let last = (end.ceil() as usize).min(from);
    (first as usize..last)
        .map(|c| (c, end.min((c + 1) as f64) - first.max(c as f64)))
        // Rounding leaves slivers of columns that are not covered.
        .filter(|(_, weight)| *weight > 1e-9)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::{HeightMap, Layer, Sheet, Voxels};
    use glam::{DVec2, UVec2};

    fn sloped(nx: u32, ny: u32) -> Option<Volume> {
        let values = (0..ny).flat_map(|y| (0..nx).map(move |x| (x + 2 * y) as f32 / nx as f32));
        let map = HeightMap {
            name: "slope".to_owned(),
            dims: UVec2::new(nx, ny),
            voxels: Voxels::F32(values.collect()),
            rescale: Rescale::IDENTITY,
            spacing: None,
            spatial_unit: None,
        };
        let layer = Layer {
            bottom: -0.5,
            top: 0.1,
            ramp: 0.2,
        };
        let sheet = Sheet {
            size: DVec2::new(2.0, 1.0),
            height: 1.5,
            layer,
            margin: 0.0,
        };
        map.volume(None, &sheet).ok()
    }

    #[test]
    #[allow(clippy::panic)]
    fn a_halved_field_is_the_same_medium_in_the_same_place() {
        // Odd columns are cut, and the means of steps are not those of a plane by up to 6 % of a column's rise.
        for (nx, ny, tolerance) in [(16, 12, 1e-5), (17, 13, 1e-2)] {
            let fine = sloped(nx, ny);
            let coarse = fine.as_ref().and_then(Volume::halved);
            let (Some(fine), Some(coarse)) = (fine, coarse) else {
                panic!("no field")
            };
            assert_eq!(coarse.grid.dims.truncate(), UVec2::new(8, 6));
            let (a, b) = (fine.grid.world_bounds(), coarse.grid.world_bounds());
            let sides = [(a.0 - b.0).truncate(), (a.1 - b.1).truncate()];
            assert!(sides.iter().all(|s| s.length() < 1e-12));
            // Away from the edges a plane stays the plane it was, and so do its data values.
            for x in [DVec3::new(0.1, 0.05, 1.7), DVec3::new(-0.4, -0.2, 0.9)] {
                let at = |v: &Volume| v.grid.world_from_index.inverse().transform_point3(x);
                let [fine_above, coarse_above] = [&fine, &coarse].map(|v| {
                    let field = v.height_field.as_ref();
                    let above = field.map_or(0.0, |f| f.above(&v.grid, at(v)));
                    above * v.grid.spacing().z
                });
                let error = (fine_above - coarse_above).abs();
                assert!(error < tolerance, "{fine_above} {coarse_above}");
                let values = [&fine, &coarse].map(|v| v.sample_index(at(v)));
                assert!((values[0] - values[1]).abs() < tolerance, "{values:?}");
            }
        }
    }

    /// World length of full extinction over the middle column, inside the box.
    fn depth(v: &Volume) -> f64 {
        let (n, d) = (2000, v.grid.dims.as_dvec3());
        let share = |i: u32| {
            let z = (f64::from(i) + 0.5) / f64::from(n) * d.z - 0.5;
            v.share_at(DVec3::new(0.5 * d.x, 0.5 * d.y, z))
        };
        (0..n).map(share).sum::<f64>() / f64::from(n) * d.z * v.grid.spacing().z
    }

    #[test]
    fn however_often_it_is_halved_a_layer_is_as_deep() {
        let flat = HeightMap {
            name: "flat".to_owned(),
            dims: UVec2::splat(64),
            voxels: Voxels::F32(vec![0.5; 64 * 64]),
            rescale: Rescale::IDENTITY,
            spacing: None,
            spatial_unit: None,
        };
        // Thick, as thick as two ramps, and thinner than one.
        for (bottom, ramp) in [(-0.5, 0.02), (-0.08, 0.04), (-0.01, 0.03)] {
            let layer = Layer {
                bottom,
                top: 0.0,
                ramp,
            };
            let sheet = Sheet {
                size: DVec2::splat(2.0),
                height: 1.0,
                layer,
                margin: 0.0,
            };
            let mut v = flat.volume(None, &sheet).ok();
            let expected = v.as_ref().map(depth);
            for level in 1..=5 {
                v = v.as_ref().and_then(Volume::halved);
                let found = v.as_ref().map(depth);
                let error = found.zip(expected).map(|(a, b)| (a / b - 1.0).abs());
                assert!(
                    error.is_some_and(|e| e < 0.01),
                    "{level}: {found:?} {expected:?}"
                );
            }
        }
    }
}
