//! The light cache: a grid of nodes over the kept part of the volume, one block of nodes a light.

use glam::{DVec3, UVec3};

use super::plan::MAX_ROUNDS;
use crate::gpu::{Format, Limits};
use crate::scene::{LightCache, Scene, SingleScatterParams};
use crate::technique::nodes::{MIN_INTERVALS, Nodes};
use crate::technique::tiles::MAX_SAMPLES;
use crate::technique::{PlanError, ResourceKind, ResourcePlan};

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
        let Nodes {
            count: nodes,
            first,
            spacing,
        } = Nodes::new(scene, DVec3::splat(voxels), MIN_INTERVALS);
        let samples = shadow_samples(scene, params)?;
        let per_slice = samples * u64::from(nodes.x) * u64::from(nodes.y);
        let slices = (MAX_SAMPLES / per_slice.max(1)).clamp(1, MAX_SLICES.min(u64::from(nodes.z)));
        let plan = Self {
            nodes,
            first,
            spacing,
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
