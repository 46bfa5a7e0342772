//! Grids of nodes over what the clip box keeps of the volume, for what techniques keep of light.

use glam::{DVec3, UVec3};

use crate::scene::Scene;

/// Nodes span this many voxels at least, where a clip box keeps less.
const THINNEST: f64 = 4e-3;

/// Intervals along the longest side, at least, where nothing wider than a voxel decides how light bends: it also
/// does at the volume's edges, whatever the voxels.
pub(super) const MIN_INTERVALS: f64 = 63.0;

/// Where nodes are: from face to face, the outermost on the faces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nodes {
    /// Nodes along x, y, z, at least two.
    pub count: UVec3,
    /// Grid coordinates of the first node (voxel centres at whole numbers).
    pub first: DVec3,
    /// Voxels from node to node.
    pub spacing: DVec3,
}

impl Nodes {
    /// One node every so many voxels along x, y, z, or closer: at least
    /// `min_intervals` intervals along the longest side.
    #[must_use]
    pub fn new(scene: &Scene, voxels: DVec3, min_intervals: f64) -> Self {
        let (low, high) = kept(scene);
        let size = high - low;
        let world = size * scene.volume.grid.spacing();
        let widest = world.max_element() / min_intervals / scene.volume.grid.spacing();
        // Rounding does not add an interval to a whole number of them.
        let intervals = (size / widest.min(voxels) - 1e-6).ceil();
        let count = intervals.max(DVec3::ONE).as_uvec3() + 1;
        Self {
            count,
            first: low,
            spacing: size / (count - 1).as_dvec3(),
        }
    }
}

/// Corners, in grid coordinates, of a box around all that the clip box keeps of the volume.
pub(super) fn kept(scene: &Scene) -> (DVec3, DVec3) {
    let grid = &scene.volume.grid;
    let (mut low, mut high) = (DVec3::splat(-0.5), grid.dims.as_dvec3() - 0.5);
    if let Some((min, max)) = scene.clip.bounds {
        let inverse = grid.world_from_index.inverse();
        let corner = |i: u32| {
            let upper = (UVec3::new(i, i >> 1, i >> 2) & 1).as_dvec3();
            inverse.transform_point3(min + upper * (max - min))
        };
        let corners = (0..8).map(corner);
        let (clip_low, clip_high) = corners
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| {
                (low.min(p), high.max(p))
            });
        // A clip box beside the volume keeps nothing: one cell of nodes that nobody reads.
        low = low.max(clip_low).min(high - 1.0);
        high = high.min(clip_high).max(low + THINNEST);
    }
    (low, high)
}
