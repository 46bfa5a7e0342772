//! The logical device: one queue, one allocator, one pipeline cache.

use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};

use ash::{ext, vk};
use gpu_allocator::vulkan::{Allocator, AllocatorCreateDesc};

use super::allocation::LiveAllocation;
use super::error::Context;
use super::pipeline_cache::PipelineCache;
use super::{DeviceInfo, GpuError, Instance, Validation};

/// A Vulkan device with one compute queue. Cheap to clone; lives until its last object is gone.
#[derive(Clone)]
pub struct Device {
    pub(super) shared: Arc<Shared>,
}

pub(super) struct Shared {
    // `None` only while dropping: the allocator must go before the device.
    pub(super) allocator: Mutex<Option<Allocator>>,
    pub(super) cache: Option<PipelineCache>,
    pub(super) debug_utils: Option<ext::debug_utils::Device>,
    // Submission needs external synchronisation.
    pub(super) queue: Mutex<vk::Queue>,
    pub(super) queue_family: u32,
    // Index of the barrier every recorder leaves out; `usize::MAX` for none.
    pub(super) omitted_barrier: AtomicUsize,
    // Images and pipelines made so far.
    pub(super) created: AtomicUsize,
    pub(super) raw: ash::Device,
    pub(super) info: DeviceInfo,
    pub(super) instance: Instance,
}

impl Device {
    /// Opens a device: `wanted` is an index or part of a name, `None` takes the best one.
    ///
    /// # Errors
    /// No loader, no matching device, or the driver's refusal.
    pub fn open(wanted: Option<&str>, validation: Validation) -> Result<Self, GpuError> {
        Self::open_with_cache(wanted, validation, PipelineCache::default_folder())
    }

    /// As [`Device::open`], with the pipeline cache in `cache_folder` (`None`: not kept on disk).
    ///
    /// # Errors
    /// As [`Device::open`].
    pub fn open_with_cache(
        wanted: Option<&str>,
        validation: Validation,
        cache_folder: Option<PathBuf>,
    ) -> Result<Self, GpuError> {
        let instance = Instance::new(validation)?;
        let physical = instance.choose(wanted)?;
        let priorities = [1.0];
        let queues = [vk::DeviceQueueCreateInfo::default()
            .queue_family_index(physical.queue_family)
            .queue_priorities(&priorities)];
        let features =
            vk::PhysicalDeviceFeatures::default().shader_storage_image_write_without_format(true);
        let mut v13 = vk::PhysicalDeviceVulkan13Features::default()
            .synchronization2(true)
            .maintenance4(true);
        let info = vk::DeviceCreateInfo::default()
            .queue_create_infos(&queues)
            .enabled_features(&features)
            .push_next(&mut v13);
        let name = physical.info.name.clone();
        // SAFETY: the physical device has every feature asked for (`choose` checked).
        let raw = unsafe { instance.raw.create_device(physical.raw, &info, None) }
            .context("vkCreateDevice", &name)?;
        let allocator = Allocator::new(&AllocatorCreateDesc {
            instance: instance.raw.clone(),
            device: raw.clone(),
            physical_device: physical.raw,
            // Leaks are found through `live_allocations`, which tests assert on.
            debug_settings: gpu_allocator::AllocatorDebugSettings::default(),
            buffer_device_address: false,
            allocation_sizes: gpu_allocator::AllocationSizes::default(),
        });
        // SAFETY: the queue was asked for above.
        let queue = unsafe { raw.get_device_queue(physical.queue_family, 0) };
        let debug_utils = instance
            .debug_utils
            .then(|| ext::debug_utils::Device::new(&instance.raw, &raw));
        // From here on `Shared::drop` unwinds whatever exists.
        let mut shared = Shared {
            allocator: Mutex::new(None),
            cache: None,
            debug_utils,
            queue: Mutex::new(queue),
            queue_family: physical.queue_family,
            omitted_barrier: AtomicUsize::new(usize::MAX),
            created: AtomicUsize::new(0),
            raw,
            info: physical.info,
            instance,
        };
        let allocator = allocator.map_err(|e| GpuError::Allocation {
            object: "allocator".to_owned(),
            bytes: 0,
            reason: e.to_string(),
        })?;
        shared.allocator = Mutex::new(Some(allocator));
        shared.cache = Some(PipelineCache::new(
            &shared.raw,
            &shared.info.cache_key,
            cache_folder,
        )?);
        Ok(Self {
            shared: Arc::new(shared),
        })
    }

    /// What the device is and can do.
    #[must_use]
    pub fn info(&self) -> &DeviceInfo {
        &self.shared.info
    }

    /// Fails with every validation message since the last call, if there is one.
    ///
    /// # Errors
    /// [`GpuError::Validation`].
    pub fn check_validation(&self) -> Result<(), GpuError> {
        let messages = self.shared.instance.take_messages();
        if messages.is_empty() {
            Ok(())
        } else {
            Err(GpuError::Validation(messages))
        }
    }

    /// Device memory in use: one entry for every live buffer and image.
    #[must_use]
    pub fn live_allocations(&self) -> Vec<LiveAllocation> {
        let Ok(guard) = self.shared.allocator.lock() else {
            return Vec::new();
        };
        guard.as_ref().map_or_else(Vec::new, |allocator| {
            allocator
                .generate_report()
                .allocations
                .into_iter()
                .map(|a| LiveAllocation {
                    name: a.name,
                    bytes: a.size,
                })
                .collect()
        })
    }

    /// How many images and pipelines were made so far, for tests that prove that none is made twice.
    #[doc(hidden)]
    #[must_use]
    pub fn created(&self) -> usize {
        self.shared.created.load(Ordering::Relaxed)
    }

    /// Makes every recorder leave out its `index`-th barrier, for tests that prove that
    /// synchronization validation sees a missing one.
    #[doc(hidden)]
    pub fn omit_barrier(&self, index: Option<usize>) {
        self.shared
            .omitted_barrier
            .store(index.unwrap_or(usize::MAX), Ordering::Relaxed);
    }

    /// Makes plans use the device's filter even where loads are faster, for tests that compare both.
    /// Only before the device is shared.
    #[doc(hidden)]
    pub fn prefer_filter(&mut self) {
        if let Some(shared) = Arc::get_mut(&mut self.shared) {
            shared.info.limits.prefers_loads = false;
        }
    }

    /// Makes plans use scans over subgroups even where they are slower, for tests that compare both: the
    /// driver has to have them. Only before the device is shared.
    #[doc(hidden)]
    pub fn prefer_subgroups(&mut self) {
        if let Some(shared) = Arc::get_mut(&mut self.shared) {
            shared.info.limits.prefers_subgroups = true;
        }
    }

    /// Writes the pipeline cache to disk; a failure only costs time at the next start.
    pub fn save_pipeline_cache(&self) {
        if let Some(cache) = &self.shared.cache {
            cache.save(&self.shared.raw);
        }
    }
}

impl Shared {
    /// Gives a Vulkan object its name in validation messages and captures.
    pub(super) fn name<T: vk::Handle>(&self, object: T, name: &str) {
        let Some(debug_utils) = &self.debug_utils else {
            return;
        };
        let Ok(name) = std::ffi::CString::new(name) else {
            return;
        };
        let info = vk::DebugUtilsObjectNameInfoEXT::default()
            .object_handle(object)
            .object_name(&name);
        // SAFETY: `object` was made by this device. A failure only loses a name.
        let _ = unsafe { debug_utils.set_debug_utils_object_name(&info) };
    }
}

impl Drop for Shared {
    fn drop(&mut self) {
        // SAFETY: every object made from this device holds an `Arc` of it, so none is left; the
        // device is idle because each submission is waited for.
        unsafe {
            let _ = self.raw.device_wait_idle();
            if let Some(cache) = self.cache.take() {
                cache.save(&self.raw);
                cache.destroy(&self.raw);
            }
            if let Ok(allocator) = self.allocator.get_mut() {
                drop(allocator.take());
            }
            self.raw.destroy_device(None);
        }
    }
}
