//! Images.

use std::sync::atomic::Ordering;

use ash::vk;
use glam::UVec3;
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::Allocation;

use super::error::Context;
use super::{Device, GpuError};

/// Everything that makes an image.
#[derive(Clone, Copy, Debug)]
pub struct ImageDesc {
    /// 1D, 2D or 3D.
    pub image_type: vk::ImageType,
    /// Texels along x, y, z; 1 where the type has no such axis.
    pub extent: UVec3,
    /// Texel format.
    pub format: vk::Format,
    /// Everything it is used for.
    pub usage: vk::ImageUsageFlags,
}

/// An image with its memory and one view of the whole; destroys itself.
pub struct Image {
    device: Device,
    pub(super) raw: vk::Image,
    pub(super) view: vk::ImageView,
    allocation: Option<Allocation>,
    desc: ImageDesc,
    name: String,
}

impl Image {
    /// Creates an image in device memory, its layout undefined.
    ///
    /// # Errors
    /// The driver's refusal, or no memory.
    pub fn new(device: &Device, name: &str, desc: ImageDesc) -> Result<Self, GpuError> {
        let info = vk::ImageCreateInfo::default()
            .image_type(desc.image_type)
            .format(desc.format)
            .extent(vk::Extent3D {
                width: desc.extent.x,
                height: desc.extent.y,
                depth: desc.extent.z,
            })
            .mip_levels(1)
            .array_layers(1)
            .samples(vk::SampleCountFlags::TYPE_1)
            .tiling(vk::ImageTiling::OPTIMAL)
            .usage(desc.usage);
        let shared = &device.shared;
        // SAFETY: a live device; the memory is bound before any use.
        let raw = unsafe { shared.raw.create_image(&info, None) }.context("vkCreateImage", name)?;
        shared.name(raw, name);
        let mut image = Self {
            device: device.clone(),
            raw,
            view: vk::ImageView::null(),
            allocation: None,
            desc,
            name: name.to_owned(),
        };
        // SAFETY: `raw` was just created by this device.
        let requirements = unsafe { shared.raw.get_image_memory_requirements(raw) };
        let allocation = shared.allocate(name, requirements, MemoryLocation::GpuOnly, false)?;
        // SAFETY: the memory fits the requirements and is bound once.
        let bound = unsafe {
            shared
                .raw
                .bind_image_memory(raw, allocation.memory(), allocation.offset())
        };
        image.allocation = Some(allocation);
        bound.context("vkBindImageMemory", name)?;
        image.view = image.create_view()?;
        shared.name(image.view, name);
        shared.created.fetch_add(1, Ordering::Relaxed);
        Ok(image)
    }

    fn create_view(&self) -> Result<vk::ImageView, GpuError> {
        let view_type = match self.desc.image_type {
            vk::ImageType::TYPE_1D => vk::ImageViewType::TYPE_1D,
            vk::ImageType::TYPE_2D => vk::ImageViewType::TYPE_2D,
            _ => vk::ImageViewType::TYPE_3D,
        };
        let info = vk::ImageViewCreateInfo::default()
            .image(self.raw)
            .view_type(view_type)
            .format(self.desc.format)
            .subresource_range(Self::whole());
        // SAFETY: the image is bound to memory and outlives the view.
        unsafe { self.device.shared.raw.create_image_view(&info, None) }
            .context("vkCreateImageView", &self.name)
    }

    /// What the image was made from.
    #[must_use]
    pub const fn desc(&self) -> &ImageDesc {
        &self.desc
    }

    /// The image's name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Bytes of device memory it takes.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.allocation.as_ref().map_or(0, Allocation::size)
    }

    /// The one mip level and layer every image here has.
    pub(super) const fn whole() -> vk::ImageSubresourceRange {
        vk::ImageSubresourceRange {
            aspect_mask: vk::ImageAspectFlags::COLOR,
            base_mip_level: 0,
            level_count: 1,
            base_array_layer: 0,
            layer_count: 1,
        }
    }
}

impl Drop for Image {
    fn drop(&mut self) {
        let raw = &self.device.shared.raw;
        // SAFETY: submissions are waited for, so the device does not use the image any more.
        unsafe {
            raw.destroy_image_view(self.view, None);
            raw.destroy_image(self.raw, None);
        }
        if let Some(allocation) = self.allocation.take() {
            self.device.shared.free(allocation);
        }
    }
}
