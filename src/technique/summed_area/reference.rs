//! What the stages of `summed_area` compute, written naively on the CPU in f64: no table, no levels, each box
//! summed cell by cell.

use glam::{DVec3, UVec3};

use super::{FieldKind, FieldPlan};
use crate::scene::Scene;
use crate::technique::reference_medium::ReferenceMedium;

/// Shells that tell occlusion.
const SHELLS: u32 = 3;

/// Extinction of every cell of `cell` voxels, or of `split` to a voxel, per world unit: the mean over its voxels, of which those that are clipped, not finite
/// or beyond the volume count as 0; of a part of a voxel that at its middle.
#[must_use]
pub fn cell_extinctions(scene: &Scene, cell: UVec3, split: UVec3) -> Vec<f64> {
    let volume = scene.volume.grid.dims;
    let medium = ReferenceMedium::new(scene);
    if split.max_element() > 1 {
        let middle = |p: UVec3| (p.as_dvec3() + 0.5) / split.as_dvec3() - 0.5;
        let at = |p: UVec3| extinction(scene, &medium, middle(p));
        return positions(volume * split).map(at).collect();
    }
    let voxels = cell.element_product();
    let of_cell = |at: UVec3| {
        let sum: f64 = positions(cell)
            .map(|p| at * cell + p)
            .filter(|p| p.cmplt(volume).all())
            .map(|p| extinction(scene, &medium, p.as_dvec3()))
            .sum();
        sum / f64::from(voxels)
    };
    positions((volume + cell - 1) / cell).map(of_cell).collect()
}

/// Mean of `values`, one a cell, over the box from `lo` to `hi`, in cells; 0 beyond them.
#[must_use]
pub fn box_mean(values: &[f64], cells: UVec3, lo: DVec3, hi: DVec3) -> f64 {
    let first = lo.floor().max(DVec3::ZERO).as_uvec3();
    let end = hi
        .ceil()
        .clamp(DVec3::ZERO, cells.as_dvec3())
        .as_uvec3()
        .max(first);
    let sum: f64 = positions(end - first)
        .map(|p| {
            let p = first + p;
            let near = p.as_dvec3().max(lo);
            let far = (p.as_dvec3() + 1.0).min(hi);
            let share = (far - near).max(DVec3::ZERO).element_product();
            share * values[(p.x + cells.x * (p.y + cells.y * p.z)) as usize]
        })
        .sum();
    sum / (hi - lo).element_product()
}

/// What a field's texels hold.
#[must_use]
pub fn field(scene: &Scene, plan: &FieldPlan) -> Vec<f64> {
    let cells = plan.area.cells;
    let values = cell_extinctions(scene, plan.area.cell, plan.area.split);
    let squares: Vec<_> = values.iter().map(|v| v * v).collect();
    let mean =
        |of: &[f64], centre: DVec3, half: DVec3| box_mean(of, cells, centre - half, centre + half);
    let texel = |cell: UVec3| {
        let centre = cell.as_dvec3() + 0.5;
        match plan.kind {
            FieldKind::AmbientExtinction => plan.radius * mean(&values, centre, plan.half_box),
            FieldKind::Occlusion => {
                let of = |shell: u32| {
                    let share = f64::from(shell) / f64::from(SHELLS);
                    let half = share * plan.half_box;
                    let volume = share.powi(3);
                    DVec3::new(
                        volume * mean(&values, centre, half),
                        volume * mean(&squares, centre, half),
                        volume,
                    )
                };
                let shell = |i| {
                    let within = if i > 1 { of(i - 1) } else { DVec3::ZERO };
                    let sums = of(i) - within;
                    let thickness = plan.radius / f64::from(SHELLS);
                    share_seen(thickness, sums.x / sums.z, sums.y / sums.z)
                };
                (1..=SHELLS).map(shell).product()
            }
        }
    };
    positions(cells).map(texel).collect()
}

/// Share of light that passes a shell of mean extinction `mean` and mean squared extinction `square`: a part of
/// all directions is as dense as both moments ask for, the rest is free.
fn share_seen(thickness: f64, mean: f64, square: f64) -> f64 {
    if mean <= 0.0 {
        return 1.0;
    }
    let square = square.max(mean * mean);
    1.0 + mean * mean / square * (-square / mean * thickness).exp_m1()
}

/// Extinction at grid coordinates, per world unit.
fn extinction(scene: &Scene, medium: &ReferenceMedium<'_>, q: DVec3) -> f64 {
    let (grid, clip) = (&scene.volume.grid, &scene.clip);
    let x = grid.world_from_index.transform_point3(q);
    let in_box = clip
        .bounds
        .is_none_or(|(lo, hi)| x.cmpge(lo).all() && x.cmple(hi).all());
    let in_front = clip
        .plane
        .is_none_or(|plane| plane.normal.dot(x - plane.point) >= 0.0);
    if in_box && in_front {
        medium.sigma_t(q)
    } else {
        0.0
    }
}

/// Every whole position below `extent`, x fastest.
fn positions(extent: UVec3) -> impl Iterator<Item = UVec3> {
    (0..extent.element_product()).map(move |i| {
        UVec3::new(
            i % extent.x,
            i / extent.x % extent.y,
            i / (extent.x * extent.y),
        )
    })
}
