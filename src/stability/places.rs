//! Extremes of size, shape and place.

use glam::{DVec3, UVec3};

use super::Extreme;
use super::scenes::{cube, even, filled, medium};
use crate::volume::Grid;

pub(super) fn extremes() -> Vec<Extreme> {
    let one = DVec3::ONE;
    let mut list = Vec::new();
    let mut shape = |name: &str, dims: UVec3, spacing: DVec3, origin: DVec3| {
        let depth = f64::from(dims.y) * spacing.y;
        let mut grid = Grid::centred(dims, spacing);
        grid.world_from_index.translation += origin;
        // 4 optical depths along the view, whatever the size.
        let mut e = cube(name, 0.5);
        e.scene = filled(even(grid), medium(4.0 / depth));
        // Light leaves narrow volumes sideways, but what enters from the front is a slab's.
        list.push(e);
    };
    shape("1 x 1 x 64 voxels", UVec3::new(1, 1, 64), one, DVec3::ZERO);
    shape("1 x 64 x 1 voxels", UVec3::new(1, 64, 1), one, DVec3::ZERO);
    shape("64 x 1 x 1 voxels", UVec3::new(64, 1, 1), one, DVec3::ZERO);
    shape("one voxel", UVec3::ONE, one, DVec3::ZERO);
    let flat = DVec3::new(1.0, 1.0, 30.0);
    shape("spacing 1 : 1 : 30", UVec3::splat(8), flat, DVec3::ZERO);
    let deep = DVec3::new(1.0, 30.0, 1.0);
    shape("spacing 1 : 30 : 1", UVec3::splat(8), deep, DVec3::ZERO);
    let far = DVec3::new(1e6, -1e6, 1e6);
    shape("origin at 1e6", UVec3::splat(8), one, far);
    shape(
        "world of size 1e-6",
        UVec3::splat(8),
        1e-6 / 8.0 * one,
        DVec3::ZERO,
    );
    shape(
        "world of size 1e6",
        UVec3::splat(8),
        1e6 / 8.0 * one,
        DVec3::ZERO,
    );
    list
}
