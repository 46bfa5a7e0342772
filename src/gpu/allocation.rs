//! Memory behind buffers and images.

use ash::vk;
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::{Allocation, AllocationCreateDesc, AllocationScheme};

use super::GpuError;
use super::device::Shared;

/// One live piece of device memory.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LiveAllocation {
    /// The object's name.
    pub name: String,
    /// Its size in bytes.
    pub bytes: u64,
}

impl Shared {
    pub(super) fn allocate(
        &self,
        name: &str,
        requirements: vk::MemoryRequirements,
        location: MemoryLocation,
        linear: bool,
    ) -> Result<Allocation, GpuError> {
        let fail = |reason: String| GpuError::Allocation {
            object: name.to_owned(),
            bytes: requirements.size,
            reason,
        };
        let mut guard = self.allocator.lock().map_err(|e| fail(e.to_string()))?;
        let allocator = guard
            .as_mut()
            .ok_or_else(|| fail("device is closing".to_owned()))?;
        allocator
            .allocate(&AllocationCreateDesc {
                name,
                requirements,
                location,
                linear,
                allocation_scheme: AllocationScheme::GpuAllocatorManaged,
            })
            .map_err(|e| fail(e.to_string()))
    }

    pub(super) fn free(&self, allocation: Allocation) {
        if let Ok(mut guard) = self.allocator.lock()
            && let Some(allocator) = guard.as_mut()
        {
            // Freeing fails only for an allocation of another allocator, which cannot be had here.
            let _ = allocator.free(allocation);
        }
    }
}
