//! Samplers.

use ash::vk;

use super::error::Context;
use super::{Device, GpuError};

/// How an image is filtered and addressed; coordinates are normalised, one mip level.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SamplerDesc {
    /// Between texels.
    pub filter: vk::Filter,
    /// Beyond the outer texel centres, on every axis.
    pub address_mode: vk::SamplerAddressMode,
}

/// A sampler; destroys itself.
pub struct Sampler {
    device: Device,
    pub(super) raw: vk::Sampler,
}

impl Sampler {
    /// Creates a sampler.
    ///
    /// # Errors
    /// The driver's refusal.
    pub fn new(device: &Device, name: &str, desc: SamplerDesc) -> Result<Self, GpuError> {
        let info = vk::SamplerCreateInfo::default()
            .mag_filter(desc.filter)
            .min_filter(desc.filter)
            .mipmap_mode(vk::SamplerMipmapMode::NEAREST)
            .address_mode_u(desc.address_mode)
            .address_mode_v(desc.address_mode)
            .address_mode_w(desc.address_mode);
        // SAFETY: a live device.
        let raw = unsafe { device.shared.raw.create_sampler(&info, None) }
            .context("vkCreateSampler", name)?;
        device.shared.name(raw, name);
        Ok(Self {
            device: device.clone(),
            raw,
        })
    }
}

impl Drop for Sampler {
    fn drop(&mut self) {
        // SAFETY: submissions are waited for, so the device does not use the sampler any more.
        unsafe { self.device.shared.raw.destroy_sampler(self.raw, None) };
    }
}
