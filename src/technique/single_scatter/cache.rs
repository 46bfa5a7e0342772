//! The light cache: a grid of nodes over the kept part of the volume, one block of nodes a light.

use glam::{DVec3, UVec3};

use super::plan::{MAX_ROUNDS, MAX_SAMPLES};
use crate::gpu::{Format, Limits};
use crate::scene::{LightCache, Scene, SingleScatterParams};
use crate::technique::{PlanError, ResourceKind, ResourcePlan};

/// Nodes span this many voxels at least, where a clip box keeps less.
const THINNEST: f64 = 4e-3;

/// Intervals along the longest side, at least: depths also bend at the volume's edges, whatever the
/// voxels.
const MIN_INTERVALS: f64 = 63.0;

/// Most slices of nodes a dispatch: Vulkan guarantees 65,535 workgroups along z.
const MAX_SLICES: u64 = 32_768;

/// What would make the cache smaller.
const SHRINK: &str = "set technique.single_scatter.cache = \"half\" or \"none\"";

/// Where the nodes are, and how they are filled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CachePlan {
    /// Nodes along x, y, z, at least two.
    pub nodes: UVec3,
    /// Grid coordinates of the first node (voxel centres at whole numbers).
    pub first: DVec3,
    /// Voxels from node to node.
    pub spacing: DVec3,
    /// Lights, stacked along z.
    pub lights: u32,
    /// Slices of nodes a submission, so that none runs long.
    pub slices_per_submission: u32,
    /// Largest step of shadow rays, voxels.
    shadow_step: f64,
}

impl CachePlan {
    /// Plans the nodes for a scene with `lights` lights; none where nothing is cached.
    ///
    /// # Errors
    /// The nodes of all lights exceed a 3D image, or the device cannot filter them.
    pub(super) fn new(
        scene: &Scene,
        params: &SingleScatterParams,
        lights: u32,
        limits: &Limits,
    ) -> Result<Option<Self>, PlanError> {
        let voxels = match params.cache {
            LightCache::None => return Ok(None),
            LightCache::Half => 2.0,
            LightCache::Full => 1.0,
        };
        if lights == 0 {
            return Ok(None);
        }
        let (low, high) = kept(scene);
        let size = high - low;
        let world = size * scene.volume.grid.spacing();
        let widest = world.max_element() / MIN_INTERVALS / scene.volume.grid.spacing();
        // Rounding does not add an interval to a whole number of them.
        let intervals = (size / widest.min(DVec3::splat(voxels)) - 1e-6).ceil();
        let nodes = intervals.max(DVec3::ONE).as_uvec3() + 1;
        let samples = shadow_samples(scene, params)?;
        let per_slice = samples * u64::from(nodes.x) * u64::from(nodes.y);
        let slices = (MAX_SAMPLES / per_slice.max(1)).clamp(1, MAX_SLICES.min(u64::from(nodes.z)));
        let plan = Self {
            nodes,
            first: low,
            spacing: size / (nodes - 1).as_dvec3(),
            lights,
            slices_per_submission: u32::try_from(slices).unwrap_or(1),
            shadow_step: params.shadow_step,
        };
        plan.check(limits).map(|()| Some(plan))
    }

    /// Nodes along x, y and z of all lights.
    #[must_use]
    pub fn extent(&self) -> UVec3 {
        let z = self.nodes.z.saturating_mul(self.lights);
        UVec3::new(self.nodes.x, self.nodes.y, z)
    }

    /// The cache's memory.
    #[must_use]
    pub fn resource(&self) -> ResourcePlan {
        let extent = self.extent();
        ResourcePlan {
            name: "light_depth",
            kind: ResourceKind::Auxiliary,
            extent,
            format: Format::R32_SFLOAT,
            bytes: 4 * extent.as_u64vec3().element_product(),
            shrink: SHRINK,
        }
    }

    /// Submissions that fill one light's nodes.
    #[must_use]
    pub const fn submissions(&self) -> u32 {
        self.nodes.z.div_ceil(self.slices_per_submission)
    }

    fn check(&self, limits: &Limits) -> Result<(), PlanError> {
        let extent = self.extent();
        let limit = |found, limit, fix: &str| PlanError::Limit {
            what: "light_depth".to_owned(),
            found,
            limit,
            fix: fix.to_owned(),
        };
        if extent.max_element() > limits.max_image_3d {
            let lights = self.lights;
            return Err(limit(
                format!(
                    "{} x {} x {} nodes for {lights} lights",
                    extent.x, extent.y, extent.z
                ),
                format!(
                    "the device's 3D images reach {} along an axis",
                    limits.max_image_3d
                ),
                &format!("{SHRINK}, or remove lights"),
            ));
        }
        if !limits.prefers_loads && !limits.linear_r32_sfloat {
            return Err(limit(
                "needs linear filtering of 32-bit float images".to_owned(),
                "the device has none".to_owned(),
                "set technique.single_scatter.cache = \"none\"",
            ));
        }
        Ok(())
    }
}

/// Corners, in grid coordinates, of a box around all that the clip box keeps of the volume.
fn kept(scene: &Scene) -> (DVec3, DVec3) {
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

/// Samples on the longest possible shadow ray.
///
/// # Errors
/// There are more than a shader can take.
pub(super) fn shadow_samples(
    scene: &Scene,
    params: &SingleScatterParams,
) -> Result<u64, PlanError> {
    let grid = &scene.volume.grid;
    let step = params.shadow_step * grid.spacing().min_element();
    let samples = (grid.diagonal() / step).ceil().max(1.0);
    // A look at the cells leaps a sample at least, or ends with a block of four.
    let rounds = 1.25 * samples;
    if rounds > MAX_ROUNDS {
        return Err(PlanError::Limit {
            what: "technique.single_scatter.shadow_step".to_owned(),
            found: format!("{samples} samples on the longest shadow ray"),
            limit: format!("a ray takes at most {}", MAX_ROUNDS / 1.25),
            fix: format!(
                "raise the step to at least {:.4}",
                params.shadow_step * rounds / MAX_ROUNDS
            ),
        });
    }
    Ok(samples as u64)
}
