//! Physical devices: what there is, what it can do, which one to take.

use ash::vk;
use serde::Serialize;

use super::error::Context;
use super::{GpuError, Instance};

/// What kind of processor a device is, in order of preference.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum DeviceKind {
    /// A card with its own memory.
    Discrete,
    /// Shares memory with the host.
    Integrated,
    /// A slice of a device given to a virtual machine.
    Virtual,
    /// A software driver.
    Cpu,
    /// Unknown.
    Other,
}

/// Limits that plans depend on.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Limits {
    /// Largest extent of a 3D image along an axis.
    pub max_image_3d: u32,
    /// Largest extent of a 2D image along an axis.
    pub max_image_2d: u32,
    /// Largest extent of a 1D image.
    pub max_image_1d: u32,
    /// Largest single allocation, bytes.
    pub max_allocation: u64,
    /// Bytes of the largest device-local heap, or what it has left where the driver tells.
    pub heap_bytes: u64,
    /// Threads of a software driver, which gives each one contiguous run of workgroups; 1 on GPUs.
    pub worker_threads: u32,
    /// Whether loading texels and filtering in the shader is faster than the device's filter: so on
    /// software drivers, where the formats of volumes can be storage images.
    pub prefers_loads: bool,
    /// Whether running sums are faster by scans over subgroups than by one invocation a line: so on GPUs
    /// whose compute shaders can add over a subgroup.
    pub prefers_subgroups: bool,
    /// Whether 16-bit unsigned normalised images can be filtered linearly.
    pub linear_r16_unorm: bool,
    /// Whether 32-bit float images can be filtered linearly.
    pub linear_r32_sfloat: bool,
    /// Whether four-channel 32-bit float images can be filtered linearly.
    pub linear_rgba32_sfloat: bool,
}

/// A device as the user sees it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DeviceInfo {
    /// Position in the loader's list; what `--device` takes.
    pub index: usize,
    /// The driver's name of the device.
    pub name: String,
    /// What kind of processor it is.
    pub kind: DeviceKind,
    /// Driver name and version.
    pub driver: String,
    /// Vulkan version, `1.3.230`.
    pub api: String,
    /// Limits that plans depend on.
    pub limits: Limits,
    /// Nanoseconds a timestamp tick; 0 where the queue has no timestamps.
    pub timestamp_period_ns: f32,
    /// Invocations a subgroup.
    pub subgroup_size: u32,
    /// Why this device cannot be used; `None` if it can.
    pub unusable: Option<String>,
    /// Identifies device and driver for the pipeline cache.
    #[serde(skip)]
    pub cache_key: String,
}

/// A physical device with its queue family.
#[derive(Clone)]
pub(super) struct Physical {
    pub(super) raw: vk::PhysicalDevice,
    pub(super) queue_family: u32,
    pub(super) info: DeviceInfo,
}

impl Instance {
    /// Every device the loader finds, usable or not, in the loader's order.
    ///
    /// # Errors
    /// The loader's refusal.
    pub fn devices(&self) -> Result<Vec<DeviceInfo>, GpuError> {
        Ok(self
            .physical_devices()?
            .into_iter()
            .map(|p| p.info)
            .collect())
    }

    pub(super) fn physical_devices(&self) -> Result<Vec<Physical>, GpuError> {
        // SAFETY: `self.raw` is a live instance.
        let list = unsafe { self.raw.enumerate_physical_devices() }
            .context("vkEnumeratePhysicalDevices", "tyndall")?;
        Ok(list
            .into_iter()
            .enumerate()
            .map(|(i, raw)| self.describe(i, raw))
            .collect())
    }

    /// The device the user named (index or part of the name), else the best usable one:
    /// discrete, integrated, virtual, CPU.
    pub(super) fn choose(&self, wanted: Option<&str>) -> Result<Physical, GpuError> {
        let mut devices = self.physical_devices()?;
        let listing = devices
            .iter()
            .map(|d| format!("{} ({})", d.info.index, d.info.name))
            .collect::<Vec<_>>()
            .join(", ");
        if let Some(wanted) = wanted {
            let matches = |d: &Physical| {
                wanted.parse::<usize>().map_or_else(
                    |_| d.info.name.to_lowercase().contains(&wanted.to_lowercase()),
                    |index| d.info.index == index,
                )
            };
            devices.retain(matches);
            if devices.is_empty() {
                return Err(GpuError::UnknownDevice {
                    wanted: wanted.to_owned(),
                    available: if listing.is_empty() {
                        "none".to_owned()
                    } else {
                        listing
                    },
                });
            }
        }
        let reasons: Vec<_> = devices
            .iter()
            .filter_map(|d| {
                d.info
                    .unusable
                    .as_ref()
                    .map(|why| format!("{}: {why}", d.info.name))
            })
            .collect();
        devices.retain(|d| d.info.unusable.is_none());
        devices
            .into_iter()
            .min_by_key(|d| d.info.kind)
            .ok_or_else(|| {
                GpuError::NoDevice(if reasons.is_empty() {
                    "the loader finds no driver; on Debian: apt-get install mesa-vulkan-drivers"
                        .to_owned()
                } else {
                    reasons.join("; ")
                })
            })
    }

    fn describe(&self, index: usize, raw: vk::PhysicalDevice) -> Physical {
        let mut driver = vk::PhysicalDeviceDriverProperties::default();
        let mut v11 = vk::PhysicalDeviceVulkan11Properties::default();
        let mut maintenance3 = vk::PhysicalDeviceMaintenance3Properties::default();
        let mut properties = vk::PhysicalDeviceProperties2::default();
        // SAFETY: `raw` comes from this instance; Vulkan 1.1 properties exist on any 1.1 device, and
        // the loader emulates `vkGetPhysicalDeviceProperties2` for older ones.
        let core = unsafe { self.raw.get_physical_device_properties(raw) };
        if core.api_version >= vk::API_VERSION_1_2 {
            properties = properties
                .push_next(&mut driver)
                .push_next(&mut v11)
                .push_next(&mut maintenance3);
            // SAFETY: as above.
            unsafe {
                self.raw
                    .get_physical_device_properties2(raw, &mut properties)
            };
        }
        let text = |c: Result<&std::ffi::CStr, _>| {
            c.map_or_else(|_| String::new(), |c| c.to_string_lossy().into_owned())
        };
        // SAFETY: as above.
        let families = unsafe { self.raw.get_physical_device_queue_family_properties(raw) };
        let queue_family = compute_family(&families);
        let unusable = self.unusable(raw, core.api_version, queue_family);
        let queue_family = queue_family.unwrap_or(0);
        let timestamps = families
            .get(queue_family as usize)
            .is_some_and(|f| f.timestamp_valid_bits > 0);
        let limits = self.limits(raw, &core, &v11, maintenance3.max_memory_allocation_size);
        let version = core.api_version;
        let info = DeviceInfo {
            index,
            name: text(core.device_name_as_c_str().map_err(|_| ())),
            kind: kind(core.device_type),
            driver: format!(
                "{} {}",
                text(driver.driver_name_as_c_str().map_err(|_| ())),
                text(driver.driver_info_as_c_str().map_err(|_| ()))
            ),
            api: format!(
                "{}.{}.{}",
                vk::api_version_major(version),
                vk::api_version_minor(version),
                vk::api_version_patch(version)
            ),
            limits,
            timestamp_period_ns: if timestamps {
                core.limits.timestamp_period
            } else {
                0.0
            },
            subgroup_size: v11.subgroup_size,
            unusable,
            cache_key: core
                .pipeline_cache_uuid
                .iter()
                .map(|b| format!("{b:02x}"))
                .collect::<String>(),
        };
        Physical {
            raw,
            queue_family,
            info,
        }
    }

    fn unusable(
        &self,
        raw: vk::PhysicalDevice,
        api: u32,
        queue_family: Option<u32>,
    ) -> Option<String> {
        if api < vk::API_VERSION_1_3 {
            return Some("Vulkan 1.3 is needed".to_owned());
        }
        if queue_family.is_none() {
            return Some("no compute queue".to_owned());
        }
        let mut v13 = vk::PhysicalDeviceVulkan13Features::default();
        let mut features = vk::PhysicalDeviceFeatures2::default().push_next(&mut v13);
        // SAFETY: a 1.3 device knows this structure.
        unsafe { self.raw.get_physical_device_features2(raw, &mut features) };
        let write = features.features.shader_storage_image_write_without_format == vk::TRUE;
        let mut missing = Vec::new();
        if v13.synchronization2 != vk::TRUE {
            missing.push("synchronization2");
        }
        if v13.maintenance4 != vk::TRUE {
            missing.push("maintenance4");
        }
        if !write {
            missing.push("shaderStorageImageWriteWithoutFormat");
        }
        (!missing.is_empty()).then(|| format!("lacks {}", missing.join(", ")))
    }

    /// What the largest device-local heap has left for this process, where the driver tells
    /// (`VK_EXT_memory_budget`), else its size.
    fn heap_bytes(&self, raw: vk::PhysicalDevice) -> u64 {
        // SAFETY: `raw` comes from this instance.
        let extensions =
            unsafe { self.raw.enumerate_device_extension_properties(raw) }.unwrap_or_default();
        let tells = extensions
            .iter()
            .any(|e| e.extension_name_as_c_str() == Ok(ash::ext::memory_budget::NAME));
        let mut budget = vk::PhysicalDeviceMemoryBudgetPropertiesEXT::default();
        let mut memory = vk::PhysicalDeviceMemoryProperties2::default();
        if tells {
            memory = memory.push_next(&mut budget);
        }
        // SAFETY: as above; the structure is only chained where the driver knows it.
        unsafe {
            self.raw
                .get_physical_device_memory_properties2(raw, &mut memory)
        };
        let heaps = memory.memory_properties;
        heaps
            .memory_heaps_as_slice()
            .iter()
            .enumerate()
            .filter(|(_, h)| h.flags.contains(vk::MemoryHeapFlags::DEVICE_LOCAL))
            .map(|(i, h)| {
                if tells {
                    h.size.min(budget.heap_budget[i])
                } else {
                    h.size
                }
            })
            .max()
            .unwrap_or(0)
    }

    fn limits(
        &self,
        raw: vk::PhysicalDevice,
        properties: &vk::PhysicalDeviceProperties,
        v11: &vk::PhysicalDeviceVulkan11Properties<'_>,
        max_allocation: u64,
    ) -> Limits {
        let core = &properties.limits;
        let cpu = kind(properties.device_type) == DeviceKind::Cpu;
        let threads = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
        let worker_threads = if cpu {
            u32::try_from(threads).unwrap_or(1)
        } else {
            1
        };
        let heap_bytes = self.heap_bytes(raw);
        let linear = |format| {
            // SAFETY: `raw` comes from this instance.
            let p = unsafe { self.raw.get_physical_device_format_properties(raw, format) };
            p.optimal_tiling_features
                .contains(vk::FormatFeatureFlags::SAMPLED_IMAGE_FILTER_LINEAR)
        };
        let storage = |format| {
            // SAFETY: `raw` comes from this instance.
            let p = unsafe { self.raw.get_physical_device_format_properties(raw, format) };
            p.optimal_tiling_features
                .contains(vk::FormatFeatureFlags::STORAGE_IMAGE)
        };
        Limits {
            max_image_3d: core.max_image_dimension3_d,
            max_image_2d: core.max_image_dimension2_d,
            max_image_1d: core.max_image_dimension1_d,
            max_allocation: if max_allocation == 0 {
                1 << 30
            } else {
                max_allocation
            },
            heap_bytes,
            worker_threads,
            prefers_loads: cpu
                && [
                    vk::Format::R8_UNORM,
                    vk::Format::R16_UNORM,
                    vk::Format::R32_SFLOAT,
                ]
                .into_iter()
                .all(storage),
            prefers_subgroups: !cpu && adds_over_subgroups(v11),
            linear_r16_unorm: linear(vk::Format::R16_UNORM),
            linear_r32_sfloat: linear(vk::Format::R32_SFLOAT),
            linear_rgba32_sfloat: linear(vk::Format::R32G32B32A32_SFLOAT),
        }
    }
}

/// Whether compute shaders have `subgroupInclusiveAdd`.
fn adds_over_subgroups(v11: &vk::PhysicalDeviceVulkan11Properties<'_>) -> bool {
    v11.subgroup_supported_stages
        .contains(vk::ShaderStageFlags::COMPUTE)
        && v11
            .subgroup_supported_operations
            .contains(vk::SubgroupFeatureFlags::BASIC | vk::SubgroupFeatureFlags::ARITHMETIC)
}

/// A family with compute, graphics too if possible (those have timestamps everywhere).
fn compute_family(families: &[vk::QueueFamilyProperties]) -> Option<u32> {
    let with = |flags: vk::QueueFlags| {
        families
            .iter()
            .position(|f| f.queue_flags.contains(flags))
            .and_then(|i| u32::try_from(i).ok())
    };
    with(vk::QueueFlags::COMPUTE | vk::QueueFlags::GRAPHICS)
        .or_else(|| with(vk::QueueFlags::COMPUTE))
}

fn kind(device_type: vk::PhysicalDeviceType) -> DeviceKind {
    match device_type {
        vk::PhysicalDeviceType::DISCRETE_GPU => DeviceKind::Discrete,
        vk::PhysicalDeviceType::INTEGRATED_GPU => DeviceKind::Integrated,
        vk::PhysicalDeviceType::VIRTUAL_GPU => DeviceKind::Virtual,
        vk::PhysicalDeviceType::CPU => DeviceKind::Cpu,
        _ => DeviceKind::Other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_over_subgroups_need_arithmetic_in_compute_shaders() {
        let (stages, operations) = (
            vk::ShaderStageFlags::COMPUTE,
            vk::SubgroupFeatureFlags::BASIC,
        );
        let with = vk::PhysicalDeviceVulkan11Properties::default()
            .subgroup_supported_stages(stages)
            .subgroup_supported_operations(operations | vk::SubgroupFeatureFlags::ARITHMETIC);
        assert!(adds_over_subgroups(&with));
        assert!(!adds_over_subgroups(
            &with.subgroup_supported_operations(operations)
        ));
        let elsewhere = with.subgroup_supported_stages(vk::ShaderStageFlags::FRAGMENT);
        assert!(!adds_over_subgroups(&elsewhere));
    }
}
