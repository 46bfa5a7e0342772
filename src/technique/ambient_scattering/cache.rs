//! The radiance cache: a grid of nodes over the kept part of the volume, one block of nodes a light.

use glam::{DVec3, UVec3};

use crate::gpu::{Format, Limits};
use crate::scene::{AmbientScatteringParams, RadianceCache, Scene, Tube};
use crate::technique::nodes::{MIN_INTERVALS, Nodes};
use crate::technique::seen::free_path;
use crate::technique::{PlanError, ResourceKind, ResourcePlan};

/// Tube steps a submission, so that none runs long.
const MAX_STEPS: u64 = 1 << 27;

/// Distance of nodes as a share of the radius, over whose mean extinction light is dimmed. No farther apart, a node
/// beside what a ray looks at has some of it in its own box, which reaches 0.8 radii to each side.
const WIDEST: f64 = 1.0 / 3.0;

/// The same as a share of the mean free path: between nodes light goes straight, in a medium exponentially.
const WIDEST_FREE: f64 = 2.0;

/// Intervals along the longest side, at least, where these decide.
const MIN_INTERVALS_OF_WIDE: f64 = 31.0;

/// Most slices of nodes a dispatch: Vulkan guarantees 65,535 workgroups along z.
const MAX_SLICES: u64 = 32_768;

/// What would make the cache smaller.
const SHRINK: &str = "set technique.ambient_scattering.cache = \"auto\" or \"none\"";

/// Where the nodes are, and how they are filled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CachePlan {
    /// The grid.
    pub nodes: Nodes,
    /// Lights, stacked along z.
    pub lights: u32,
    /// Shares of light to 1/65535, which tells those near 1 apart; half floats where a tube may pass more than
    /// all.
    pub format: Format,
    /// Whether only nodes with something of the medium in their box are filled: rays ask no others.
    pub near_only: bool,
    /// Slices of nodes a submission, so that none runs long.
    pub slices_per_submission: u32,
}

impl CachePlan {
    /// Plans the nodes for a scene with `lights` lights and tubes of at most `steps` steps of two
    /// radii; none where nothing is cached.
    ///
    /// # Errors
    /// The nodes of all lights exceed a 3D image.
    pub(super) fn new(
        scene: &Scene,
        params: &AmbientScatteringParams,
        radius: f64,
        (lights, steps): (u32, u64),
        limits: &Limits,
    ) -> Result<Option<Self>, PlanError> {
        let Some(voxels) = voxels(params.cache).filter(|_| lights > 0) else {
            return Ok(None);
        };
        let grid = scene.volume.grid.spacing();
        let wide = (WIDEST * radius).min(WIDEST_FREE * free_path(scene)) / grid;
        let nodes = if params.cache == RadianceCache::Auto && wide.max_element() > voxels {
            Nodes::new(scene, wide.max(DVec3::splat(voxels)), MIN_INTERVALS_OF_WIDE)
        } else {
            Nodes::new(scene, DVec3::splat(voxels), MIN_INTERVALS)
        };
        let near_only = (nodes.spacing * grid).max_element() <= 1.01 * WIDEST * radius;
        let per_slice = steps * u64::from(nodes.count.x) * u64::from(nodes.count.y);
        let slices = MAX_STEPS / per_slice.max(1);
        let slices = slices.clamp(1, MAX_SLICES.min(u64::from(nodes.count.z)));
        let plan = Self {
            nodes,
            lights,
            near_only,
            format: match params.tube {
                Tube::Slab => Format::R16G16B16A16_UNORM,
                Tube::Normalized | Tube::Literal => Format::R16G16B16A16_SFLOAT,
            },
            slices_per_submission: u32::try_from(slices).unwrap_or(1),
        };
        let extent = plan.extent();
        if extent.max_element() > limits.max_image_3d {
            return Err(PlanError::Limit {
                what: "radiance_cache".to_owned(),
                found: format!(
                    "{} x {} x {} nodes for {lights} lights",
                    extent.x, extent.y, extent.z
                ),
                limit: format!(
                    "the device's 3D images reach {} along an axis",
                    limits.max_image_3d
                ),
                fix: format!("{SHRINK}, or remove lights"),
            });
        }
        Ok(Some(plan))
    }

    /// Nodes along x, y and z of all lights.
    #[must_use]
    pub fn extent(&self) -> UVec3 {
        let n = self.nodes.count;
        UVec3::new(n.x, n.y, n.z.saturating_mul(self.lights))
    }

    /// The cache's memory.
    #[must_use]
    pub fn resource(&self) -> ResourcePlan {
        let extent = self.extent();
        ResourcePlan {
            name: "radiance_cache",
            kind: ResourceKind::Auxiliary,
            extent,
            format: self.format,
            bytes: 8 * extent.as_u64vec3().element_product(),
            shrink: SHRINK,
        }
    }

    /// Submissions that fill one light's nodes.
    #[must_use]
    pub const fn submissions(&self) -> u32 {
        self.nodes.count.z.div_ceil(self.slices_per_submission)
    }
}

/// Voxels from node to node, at least.
const fn voxels(cache: RadianceCache) -> Option<f64> {
    match cache {
        RadianceCache::None => None,
        RadianceCache::Auto | RadianceCache::Half => Some(2.0),
        RadianceCache::Full => Some(1.0),
    }
}
