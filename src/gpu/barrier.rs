//! One table from "how something is used" to stage, access mask and image layout.
//!
//! A barrier names both sides at its call site: what was done before, what comes after.
//! `ALL_COMMANDS` and `MEMORY_*` are absent on purpose.

use ash::vk;

/// A use of an image or buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Access {
    /// Contents do not matter (only as the earlier side).
    Undefined,
    /// Destination of a copy.
    CopyWrite,
    /// Cleared by [`super::Recorder::clear_image`].
    Clear,
    /// Source of a copy.
    CopyRead,
    /// Sampled or fetched in a compute shader.
    ComputeSampled,
    /// Sampled, fetched or loaded in a compute shader; the image is a storage image too and stays in
    /// the general layout.
    ComputeSampledOrLoaded,
    /// Written as a storage image or buffer in a compute shader.
    ComputeWrite,
    /// Loaded as a storage image in a compute shader.
    ComputeRead,
    /// Read and written as a storage image in a compute shader.
    ComputeReadWrite,
    /// Read by the host after the submission (only as the later side, buffers).
    HostRead,
}

/// What Vulkan wants to know of an [`Access`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Scope {
    pub(super) stage: vk::PipelineStageFlags2,
    pub(super) mask: vk::AccessFlags2,
    pub(super) layout: vk::ImageLayout,
}

impl Access {
    pub(super) const fn scope(self) -> Scope {
        use vk::{AccessFlags2 as Mask, ImageLayout as Layout, PipelineStageFlags2 as Stage};
        let (stage, mask, layout) = match self {
            Self::Undefined => (Stage::NONE, Mask::NONE, Layout::UNDEFINED),
            Self::CopyWrite => (
                Stage::COPY,
                Mask::TRANSFER_WRITE,
                Layout::TRANSFER_DST_OPTIMAL,
            ),
            Self::Clear => (Stage::CLEAR, Mask::TRANSFER_WRITE, Layout::GENERAL),
            Self::CopyRead => (
                Stage::COPY,
                Mask::TRANSFER_READ,
                Layout::TRANSFER_SRC_OPTIMAL,
            ),
            Self::ComputeSampled => (
                Stage::COMPUTE_SHADER,
                Mask::SHADER_SAMPLED_READ,
                Layout::SHADER_READ_ONLY_OPTIMAL,
            ),
            Self::ComputeSampledOrLoaded => (
                Stage::COMPUTE_SHADER,
                Mask::from_raw(
                    Mask::SHADER_SAMPLED_READ.as_raw() | Mask::SHADER_STORAGE_READ.as_raw(),
                ),
                Layout::GENERAL,
            ),
            Self::ComputeWrite => (
                Stage::COMPUTE_SHADER,
                Mask::SHADER_STORAGE_WRITE,
                Layout::GENERAL,
            ),
            Self::ComputeRead => (
                Stage::COMPUTE_SHADER,
                Mask::SHADER_STORAGE_READ,
                Layout::GENERAL,
            ),
            Self::ComputeReadWrite => (
                Stage::COMPUTE_SHADER,
                Mask::from_raw(
                    Mask::SHADER_STORAGE_READ.as_raw() | Mask::SHADER_STORAGE_WRITE.as_raw(),
                ),
                Layout::GENERAL,
            ),
            Self::HostRead => (Stage::HOST, Mask::HOST_READ, Layout::GENERAL),
        };
        Scope {
            stage,
            mask,
            layout,
        }
    }
}
