//! What the radiance cache's nodes scatter towards the viewer, made anew for every view: camera rays look that up.

use glam::UVec3;

use super::cache::CachePlan;
use crate::gpu::{Format, Limits};
use crate::scene::Scene;
use crate::technique::{ResourceKind, ResourcePlan};

/// Where there are more nodes a pixel, rays look themselves. One that sees anything looks twice at least, and nodes
/// look cheaper: half of them see nothing, and what arrives at them needs no filter.
const NODES_A_PIXEL: u64 = 4;

/// Looks of nodes a submission, so that none runs long.
const MAX_LOOKS: u64 = 1 << 25;

/// How many nodes look.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GatherPlan {
    /// Nodes along x, y, z: those of the radiance cache.
    pub nodes: UVec3,
    /// Values a node: one, and one for each light that weakens with distance.
    pub looks: u32,
    /// Slices of nodes a submission.
    pub slices_per_submission: u32,
}

impl GatherPlan {
    /// The nodes of `cache` for `looks` values each; none where rays had better look themselves, for the reason
    /// that is given.
    pub(super) fn new(
        scene: &Scene,
        cache: Option<&CachePlan>,
        looks: u32,
        limits: &Limits,
    ) -> Result<Self, &'static str> {
        let cache = cache.ok_or("nothing is cached")?;
        // Then they know what a ray finds between them.
        if !cache.near_only {
            return Err("the cache's nodes are too far apart for the radius");
        }
        let nodes = cache.nodes.count;
        let pixels = u64::from(scene.image.width) * u64::from(scene.image.height);
        let count = nodes.as_u64vec3().element_product() * u64::from(looks);
        let plan = Self {
            nodes,
            looks,
            slices_per_submission: (MAX_LOOKS / (count / u64::from(nodes.z)).max(1))
                .clamp(1, u64::from(nodes.z)) as u32,
        };
        let fits = plan.extent().max_element() <= limits.max_image_3d;
        if count > NODES_A_PIXEL * pixels || !fits {
            return Err("the image has fewer pixels than a quarter of the cache's nodes");
        }
        Ok(plan)
    }

    /// Texels along x, y and z: the nodes of each look, one block after the other.
    #[must_use]
    pub fn extent(&self) -> UVec3 {
        let n = self.nodes;
        UVec3::new(n.x, n.y, n.z.saturating_mul(self.looks))
    }

    /// Its memory, at most four times that of the image.
    #[must_use]
    pub fn resource(&self) -> ResourcePlan {
        let extent = self.extent();
        ResourcePlan {
            name: "gathered_light",
            kind: ResourceKind::Auxiliary,
            extent,
            format: Format::R32G32B32A32_SFLOAT,
            bytes: 16 * extent.as_u64vec3().element_product(),
            shrink: "set technique.ambient_scattering.cache = \"none\"",
        }
    }

    /// Submissions that fill it.
    #[must_use]
    pub const fn submissions(&self) -> u32 {
        self.nodes.z.div_ceil(self.slices_per_submission)
    }
}
