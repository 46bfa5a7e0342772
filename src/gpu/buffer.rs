//! Buffers.

use std::sync::{Mutex, PoisonError};

use ash::vk;
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::Allocation;

use super::error::Context;
use super::{Device, GpuError};

/// What a buffer is for; decides usage flags and memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BufferUse {
    /// Written by the host, copied to images or buffers.
    Upload,
    /// Copied to by the device, read by the host.
    Readback,
    /// Small constants, written by the host between submissions.
    Uniform,
    /// Lists that a shader reads, written by the host between submissions.
    StorageUpload,
    /// Lists that a shader writes, read by the host.
    StorageReadback,
}

/// A buffer with its memory; destroys itself.
pub struct Buffer {
    device: Device,
    pub(super) raw: vk::Buffer,
    // Locked while the host reads or writes.
    allocation: Mutex<Option<Allocation>>,
    bytes: u64,
}

impl Buffer {
    /// Creates a buffer of `bytes` bytes.
    ///
    /// # Errors
    /// The driver's refusal, or no memory.
    pub fn new(
        device: &Device,
        name: &str,
        bytes: u64,
        usage: BufferUse,
    ) -> Result<Self, GpuError> {
        use vk::BufferUsageFlags as Usage;
        let (flags, location) = match usage {
            BufferUse::Upload => (Usage::TRANSFER_SRC, MemoryLocation::CpuToGpu),
            BufferUse::Readback => (Usage::TRANSFER_DST, MemoryLocation::GpuToCpu),
            BufferUse::Uniform => (Usage::UNIFORM_BUFFER, MemoryLocation::CpuToGpu),
            BufferUse::StorageUpload => (Usage::STORAGE_BUFFER, MemoryLocation::CpuToGpu),
            BufferUse::StorageReadback => (Usage::STORAGE_BUFFER, MemoryLocation::GpuToCpu),
        };
        let info = vk::BufferCreateInfo::default()
            .size(bytes.max(4))
            .usage(flags);
        let shared = &device.shared;
        // SAFETY: a live device; the memory is bound before any use.
        let raw =
            unsafe { shared.raw.create_buffer(&info, None) }.context("vkCreateBuffer", name)?;
        shared.name(raw, name);
        let mut buffer = Self {
            device: device.clone(),
            raw,
            allocation: Mutex::new(None),
            bytes,
        };
        // SAFETY: `raw` was just created by this device.
        let requirements = unsafe { shared.raw.get_buffer_memory_requirements(raw) };
        let allocation = shared.allocate(name, requirements, location, true)?;
        // SAFETY: the memory fits the requirements and is bound once.
        let bound = unsafe {
            shared
                .raw
                .bind_buffer_memory(raw, allocation.memory(), allocation.offset())
        };
        buffer.allocation = Mutex::new(Some(allocation));
        bound.context("vkBindBufferMemory", name)?;
        Ok(buffer)
    }

    /// Size in bytes.
    #[must_use]
    pub const fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Lets `use_bytes` read or write the host's view of the buffer. No submission is in flight
    /// then: each is waited for.
    pub fn with_bytes<R>(&self, use_bytes: impl FnOnce(&mut [u8]) -> R) -> R {
        let mut guard = self
            .allocation
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        let bytes = guard
            .as_mut()
            .and_then(Allocation::mapped_slice_mut)
            .unwrap_or(&mut []);
        let length = bytes
            .len()
            .min(usize::try_from(self.bytes).unwrap_or(usize::MAX));
        use_bytes(&mut bytes[..length])
    }
}

impl Drop for Buffer {
    fn drop(&mut self) {
        // SAFETY: submissions are waited for, so the device does not use the buffer any more.
        unsafe { self.device.shared.raw.destroy_buffer(self.raw, None) };
        let allocation = self
            .allocation
            .get_mut()
            .unwrap_or_else(PoisonError::into_inner)
            .take();
        if let Some(allocation) = allocation {
            self.device.shared.free(allocation);
        }
    }
}
