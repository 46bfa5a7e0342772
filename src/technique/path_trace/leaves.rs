//! A partition of the volume into blocks, each with bounds of its extinction: what lets a flight take
//! long steps where the medium is thin or even.

use glam::UVec3;
use rayon::prelude::*;

use crate::scene::{Perturbation, Scene};
use crate::technique::medium::{Table, reach_of_noise};
use crate::volume::Volume;

/// Most cells along an axis; larger volumes get larger cells.
const MAX_CELLS: u32 = 128;

/// Voxels along a cell's edge, at least.
const MIN_EDGE: u32 = 4;

/// Levels that fit the four bits they are packed into.
const MAX_LEVEL: u32 = 15;

/// Voxels along the edge of a cell, for a volume of `dims` voxels.
#[must_use]
pub fn cell_edge(dims: UVec3) -> u32 {
    let edge = dims.max_element().div_ceil(MAX_CELLS);
    edge.next_power_of_two().max(MIN_EDGE)
}

/// Cells along each axis.
#[must_use]
pub fn cells_along(dims: UVec3) -> UVec3 {
    let edge = cell_edge(dims);
    (dims + edge - 1) / edge
}

/// Smallest and largest extinction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Nothing in the block is below.
    pub min: f32,
    /// Nothing in the block is above.
    pub max: f32,
}

impl Bounds {
    const EMPTY: Self = Self {
        min: f32::INFINITY,
        max: f32::NEG_INFINITY,
    };

    const fn union(self, other: Self) -> Self {
        Self {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
        }
    }
}

/// One level of a pyramid of blocks: 2^level cells along each edge.
struct Level {
    dims: UVec3,
    bounds: Vec<Bounds>,
    // Expected steps of a ray that crosses the block, at best.
    cost: Vec<f32>,
    // Whether the block is better left whole.
    whole: Vec<bool>,
}

impl Level {
    fn index(&self, c: UVec3) -> usize {
        (c.x + self.dims.x * (c.y + self.dims.y * c.z)) as usize
    }

    fn cells(&self) -> impl Iterator<Item = UVec3> + use<> {
        let d = self.dims;
        (0..d.z).flat_map(move |z| {
            (0..d.y).flat_map(move |y| (0..d.x).map(move |x| UVec3::new(x, y, z)))
        })
    }
}

/// For every cell, x fastest: the bits of its leaf's largest extinction, rounded up, the last four
/// replaced by the leaf's level (it has 2^level cells along each edge and lies at a multiple of that),
/// and the bits of the smallest.
#[must_use]
pub fn leaves(scene: &Scene, table: &Table) -> Vec<[u32; 2]> {
    let volume = &scene.volume;
    let cells = cells_along(volume.grid.dims);
    let mut first = finest(volume, &Ranges::new(scene, table), cells);
    let reach = reach_of_noise(scene) / f64::from(cell_edge(volume.grid.dims));
    widen(&mut first, reach.ceil().min(cells.as_dvec3()).as_uvec3());
    let mut levels = vec![first];
    let spacing = volume.grid.spacing();
    let edge = f64::from(cell_edge(volume.grid.dims)) * spacing;
    // A convex body's mean chord is 4 V / S; of a box 2 / (1/x + 1/y + 1/z).
    let chord = 2.0 / (1.0 / edge.x + 1.0 / edge.y + 1.0 / edge.z);
    weigh(&mut levels, chord as f32);
    let mut packed = vec![[0; 2]; levels[0].bounds.len()];
    for cell in levels[0].cells() {
        packed[levels[0].index(cell)] = leaf_of(&levels, cell);
    }
    packed
}

/// Smallest and largest extinction of the whole volume.
#[must_use]
pub fn bounds(scene: &Scene, table: &Table) -> Bounds {
    let ranges = Ranges::new(scene, table);
    let s = &scene.statistics;
    let all = ranges.between(s.min, s.max);
    if s.non_finite() > 0 || scene.volume.height_field.is_some() {
        return all.union(Bounds { min: 0.0, max: 0.0 });
    }
    all
}

/// The coarsest whole block that holds the cell.
fn leaf_of(levels: &[Level], cell: UVec3) -> [u32; 2] {
    for (level, blocks) in levels.iter().enumerate().rev() {
        let i = blocks.index(cell >> level as u32);
        if blocks.whole[i] || level == 0 {
            let Bounds { min, max } = blocks.bounds[i];
            let above = (max.to_bits() | 15) ^ 15;
            let above = if f32::from_bits(above | level as u32) < max {
                above + 16
            } else {
                above
            };
            return [above | level as u32, min.to_bits()];
        }
    }
    [0; 2]
}

/// Builds the coarser levels, and decides bottom up which blocks are better left whole.
fn weigh(levels: &mut Vec<Level>, chord: f32) {
    // Flight follows the largest extinction, a shadow ray the difference to the smallest.
    let whole = |b: Bounds, level: u32| {
        1.0 + (b.max - 0.5 * b.min) * chord * 2f32.powi(level.cast_signed())
    };
    let first = &mut levels[0];
    first.cost = first.bounds.iter().map(|b| whole(*b, 0)).collect();
    first.whole = vec![true; first.bounds.len()];
    for level in 1..=MAX_LEVEL {
        let fine = &levels[level as usize - 1];
        if fine.dims == UVec3::ONE {
            break;
        }
        let mut coarse = Level {
            dims: (fine.dims + 1) / 2,
            bounds: Vec::new(),
            cost: Vec::new(),
            whole: Vec::new(),
        };
        for block in coarse.cells() {
            let mut bounds = Bounds::EMPTY;
            let (mut cost, mut count) = (0.0, 0.0);
            for corner in 0..8 {
                let child = 2 * block + (UVec3::new(corner, corner >> 1, corner >> 2) & 1);
                if child.cmplt(fine.dims).all() {
                    let i = fine.index(child);
                    bounds = bounds.union(fine.bounds[i]);
                    cost += fine.cost[i];
                    count += 1.0;
                }
            }
            let together = whole(bounds, level);
            // A random line through a cube crosses two of its octants on average.
            let apart = 2.0 * cost / count;
            coarse.bounds.push(bounds);
            coarse.whole.push(together <= apart);
            coarse.cost.push(together.min(apart));
        }
        levels.push(coarse);
    }
}

/// The bounds in every cell.
fn finest(volume: &Volume, ranges: &Ranges, cells: UVec3) -> Level {
    let edge = cell_edge(volume.grid.dims);
    let slab = |z: u32| {
        let bounds = |y: u32| {
            (0..cells.x).map(move |x| cell_bounds(volume, ranges, UVec3::new(x, y, z), edge))
        };
        (0..cells.y).flat_map(bounds).collect::<Vec<_>>()
    };
    Level {
        dims: cells,
        bounds: (0..cells.z).into_par_iter().flat_map_iter(slab).collect(),
        cost: Vec::new(),
        whole: Vec::new(),
    }
}

/// What noise looks up in a cell lies up to `reach` cells off: every cell takes the bounds of all those about it.
fn widen(level: &mut Level, reach: UVec3) {
    let dims = level.dims;
    for axis in (0..3).filter(|a| reach[*a] > 0) {
        let widened = |c: UVec3| {
            let last = (c[axis] + reach[axis]).min(dims[axis] - 1);
            let mut bounds = Bounds::EMPTY;
            for at in c[axis].saturating_sub(reach[axis])..=last {
                let mut near = c;
                near[axis] = at;
                bounds = bounds.union(level.bounds[level.index(near)]);
            }
            bounds
        };
        level.bounds = level.cells().map(widened).collect();
    }
}

/// The bounds over all voxels that a sample in the cell may be interpolated from.
fn cell_bounds(volume: &Volume, ranges: &Ranges, cell: UVec3, edge: u32) -> Bounds {
    let whole = [
        (cell * edge).saturating_sub(UVec3::ONE),
        ((cell + 1) * edge).min(volume.grid.dims - 1),
    ];
    // Of a height field one layer is stored, for every height.
    let [lo, hi] = whole.map(|at| at.min(volume.stored_dims() - 1));
    let (mut min, mut max) = (f64::INFINITY, f64::NEG_INFINITY);
    let mut has_holes = false;
    for z in lo.z..=hi.z {
        for y in lo.y..=hi.y {
            let row = volume.grid.linear_index(UVec3::new(lo.x, y, z));
            for i in row..=row + (hi.x - lo.x) as usize {
                let value = volume.value(i);
                if value.is_finite() {
                    (min, max) = (min.min(value), max.max(value));
                } else {
                    has_holes = true;
                }
            }
        }
    }
    let hole = Bounds { min: 0.0, max: 0.0 };
    let (is_met, is_whole) = met(volume, whole);
    match (is_met && min <= max, has_holes || !is_whole) {
        (false, _) => hole,
        (true, false) => ranges.between(min, max),
        (true, true) => ranges.between(min, max).union(hole),
    }
}

/// Whether the medium is met anywhere between two corners, and whether it has its full extinction everywhere.
fn met(volume: &Volume, [lo, hi]: [UVec3; 2]) -> (bool, bool) {
    let Some(field) = &volume.height_field else {
        return (true, true);
    };
    let columns = [lo, hi].map(|at| [at.x, at.y]);
    let (lowest, highest) = field.range(&volume.grid, columns[0], columns[1]);
    // Distances above the surface, of which the share is not less between than at the ends.
    // Samples lie up to half a voxel beyond the outermost centres.
    let (low, high) = (
        f64::from(lo.z) - 0.5 - highest,
        f64::from(hi.z) + 0.5 - lowest,
    );
    let is_whole = field.share(low) >= 1.0 && field.share(high) >= 1.0;
    (high >= field.bottom && low <= field.top, is_whole)
}

/// Extinction's bounds over any interval of data values, by tables over runs of 2^k entries.
struct Ranges {
    min: f64,
    entries_a_unit: f64,
    runs: Vec<Vec<Bounds>>,
}

impl Ranges {
    fn new(scene: &Scene, table: &Table) -> Self {
        let baked = table.bake(scene);
        // Where gradients decide too, the table holds the most that they make of a value; the least may be nothing.
        let least = if table.gradients.is_some() { 0.0 } else { 1.0 };
        // Noise makes any value's extinction smaller and larger by as much.
        let perturbation = scene.medium.perturbation.as_ref();
        let varied = perturbation.map_or(0.0, Perturbation::largest_variation) as f32;
        let entry = |e: &[f32; 4]| Bounds {
            min: (1.0 - varied) * least * e[3],
            max: (1.0 + varied) * e[3],
        };
        let mut runs = vec![baked.iter().map(entry).collect::<Vec<_>>()];
        let mut reach = 1;
        while 2 * reach <= baked.len() {
            let last = &runs[runs.len() - 1];
            let pairs = last.iter().zip(&last[reach..]);
            let next = pairs.map(|(a, b)| a.union(*b)).collect();
            runs.push(next);
            reach *= 2;
        }
        Self {
            min: table.min,
            entries_a_unit: f64::from(table.entries - 1) / (table.max - table.min),
            runs,
        }
    }

    /// Over data values from `low` to `high`, with a little room for the device's rounding.
    fn between(&self, low: f64, high: f64) -> Bounds {
        let last = self.runs[0].len() - 1;
        let entry = |value: f64| (value - self.min) * self.entries_a_unit;
        let first = ((entry(low) - 1e-2).floor().max(0.0) as usize).min(last);
        let end = ((entry(high) + 1e-2).ceil().max(0.0) as usize).clamp(first, last) + 1;
        let level = (end - first).ilog2() as usize;
        let run = &self.runs[level];
        run[first].union(run[end - (1 << level)])
    }
}
