//! The only module with `unsafe` and raw Vulkan: device, memory, shaders, pipelines, barriers,
//! timed stages and transfers. Everything here destroys itself; everything above is safe Rust.
#![allow(unsafe_code, reason = "raw Vulkan lives here and nowhere else")]

mod allocation;
pub mod barrier;
mod buffer;
mod device;
mod error;
mod image;
mod instance;
mod physical;
mod pipeline;
mod pipeline_cache;
mod recorder;
mod sampler;
pub mod shader;
mod transfer;

pub use allocation::LiveAllocation;
pub use barrier::Access;
pub use buffer::{Buffer, BufferUse};
pub use device::Device;
pub use error::GpuError;
pub use image::{Image, ImageDesc};
pub use instance::{Instance, Validation};
pub use physical::{DeviceInfo, DeviceKind, Limits};
pub use pipeline::{Binding, BindingKind, ComputePipeline, Resource, Specialization, StageLayout};
pub use recorder::{Recorder, StageTime};
pub use sampler::{Sampler, SamplerDesc};
pub use transfer::{download_image, staging, upload_image};

// Raw Vulkan words that plans and resources are written in.
pub use ash::vk::{Filter, Format, ImageType, ImageUsageFlags, SamplerAddressMode};
