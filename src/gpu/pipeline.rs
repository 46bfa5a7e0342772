//! Compute pipelines and the descriptor sets they read.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use ash::vk;

use super::error::Context;
use super::shader::Shader;
use super::{Buffer, Device, GpuError, Image, Sampler};

/// What a shader's binding holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BindingKind {
    /// `sampler1D`, `sampler3D`, ...
    SampledImage,
    /// `image2D`, `image3D`, ...
    StorageImage,
    /// A `uniform` block.
    UniformBuffer,
    /// A `buffer` block.
    StorageBuffer,
}

impl BindingKind {
    const fn descriptor_type(self) -> vk::DescriptorType {
        match self {
            Self::SampledImage => vk::DescriptorType::COMBINED_IMAGE_SAMPLER,
            Self::StorageImage => vk::DescriptorType::STORAGE_IMAGE,
            Self::UniformBuffer => vk::DescriptorType::UNIFORM_BUFFER,
            Self::StorageBuffer => vk::DescriptorType::STORAGE_BUFFER,
        }
    }
}

/// A stage's interface: its shader, the bindings of set 0 in order, and its push constants.
#[derive(Clone, Copy, Debug)]
pub struct StageLayout {
    /// The shader.
    pub shader: Shader,
    /// Bindings 0, 1, ... of set 0.
    pub bindings: &'static [BindingKind],
    /// Bytes of push constants, at most 128.
    pub push_bytes: u32,
}

/// A specialisation constant: its `constant_id`, name and value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Specialization {
    /// `constant_id` in the shader.
    pub id: u32,
    /// The constant's name in the shader.
    pub name: &'static str,
    /// Its value (booleans: 0 or 1).
    pub value: u32,
}

impl Specialization {
    /// A constant without a value yet.
    #[must_use]
    pub const fn new(id: u32, name: &'static str) -> Self {
        Self { id, name, value: 0 }
    }

    /// The constants with these values, in the same order.
    #[must_use]
    pub fn with_values(constants: &[Self], values: &[u32]) -> Vec<Self> {
        let pairs = constants.iter().zip(values);
        pairs
            .map(|(constant, &value)| Self { value, ..*constant })
            .collect()
    }
}

/// Something to put into a binding.
#[derive(Clone)]
pub enum Resource {
    /// An image in the sampled layout, with how to sample it.
    Sampled(Arc<Image>, Arc<Sampler>),
    /// The same for an image that is a storage image too, in the general layout.
    SampledGeneral(Arc<Image>, Arc<Sampler>),
    /// An image in the general layout.
    Storage(Arc<Image>),
    /// A whole uniform buffer.
    Uniform(Arc<Buffer>),
    /// A whole storage buffer.
    StorageBuffer(Arc<Buffer>),
}

impl Resource {
    const fn kind(&self) -> BindingKind {
        match self {
            Self::Sampled(..) | Self::SampledGeneral(..) => BindingKind::SampledImage,
            Self::Storage(_) => BindingKind::StorageImage,
            Self::Uniform(_) => BindingKind::UniformBuffer,
            Self::StorageBuffer(_) => BindingKind::StorageBuffer,
        }
    }
}

/// A compute pipeline; destroys itself.
pub struct ComputePipeline {
    device: Device,
    layout: StageLayout,
    local_size: [u32; 3],
    set_layout: vk::DescriptorSetLayout,
    pub(super) pipeline_layout: vk::PipelineLayout,
    pub(super) raw: vk::Pipeline,
}

/// A filled descriptor set; keeps what it refers to alive and destroys itself.
pub struct Binding {
    device: Device,
    pool: vk::DescriptorPool,
    pub(super) set: vk::DescriptorSet,
    resources: Vec<Resource>,
}

impl ComputePipeline {
    /// Compiles a stage's shader with its specialisation constants.
    ///
    /// # Errors
    /// The module is no SPIR-V, or the driver's refusal.
    pub fn new(
        device: &Device,
        layout: StageLayout,
        specialization: &[Specialization],
    ) -> Result<Self, GpuError> {
        let words = layout.shader.words()?;
        let mut pipeline = Self {
            device: device.clone(),
            layout,
            local_size: layout.shader.local_size()?,
            set_layout: vk::DescriptorSetLayout::null(),
            pipeline_layout: vk::PipelineLayout::null(),
            raw: vk::Pipeline::null(),
        };
        pipeline.create_layouts()?;
        pipeline.create(&words, specialization)?;
        Ok(pipeline)
    }

    fn create_layouts(&mut self) -> Result<(), GpuError> {
        let raw = &self.device.shared.raw;
        let name = self.layout.shader.name;
        let bindings: Vec<_> = (0u32..)
            .zip(self.layout.bindings)
            .map(|(i, kind)| {
                vk::DescriptorSetLayoutBinding::default()
                    .binding(i)
                    .descriptor_type(kind.descriptor_type())
                    .descriptor_count(1)
                    .stage_flags(vk::ShaderStageFlags::COMPUTE)
            })
            .collect();
        let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
        // SAFETY: a live device; `self` destroys what is made, also when a later call fails.
        self.set_layout = unsafe { raw.create_descriptor_set_layout(&info, None) }
            .context("vkCreateDescriptorSetLayout", name)?;
        let sets = [self.set_layout];
        let push = [vk::PushConstantRange::default()
            .stage_flags(vk::ShaderStageFlags::COMPUTE)
            .size(self.layout.push_bytes)];
        let mut info = vk::PipelineLayoutCreateInfo::default().set_layouts(&sets);
        if self.layout.push_bytes > 0 {
            info = info.push_constant_ranges(&push);
        }
        // SAFETY: as above.
        self.pipeline_layout = unsafe { raw.create_pipeline_layout(&info, None) }
            .context("vkCreatePipelineLayout", name)?;
        Ok(())
    }

    fn create(&mut self, words: &[u32], specialization: &[Specialization]) -> Result<(), GpuError> {
        let shared = &self.device.shared;
        let name = self.layout.shader.name;
        let info = vk::ShaderModuleCreateInfo::default().code(words);
        // SAFETY: the module was checked to be SPIR-V; it is destroyed below.
        let module = unsafe { shared.raw.create_shader_module(&info, None) }
            .context("vkCreateShaderModule", name)?;
        let entries: Vec<_> = (0u32..)
            .zip(specialization)
            .map(|(i, s)| vk::SpecializationMapEntry {
                constant_id: s.id,
                offset: 4 * i,
                size: 4,
            })
            .collect();
        let values: Vec<u32> = specialization.iter().map(|s| s.value).collect();
        let constants = vk::SpecializationInfo::default()
            .map_entries(&entries)
            .data(bytemuck::cast_slice(&values));
        let stage = vk::PipelineShaderStageCreateInfo::default()
            .stage(vk::ShaderStageFlags::COMPUTE)
            .module(module)
            .name(c"main")
            .specialization_info(&constants);
        let info = vk::ComputePipelineCreateInfo::default()
            .stage(stage)
            .layout(self.pipeline_layout);
        let cache = shared
            .cache
            .as_ref()
            .map_or(vk::PipelineCache::null(), |c| c.raw);
        // SAFETY: every pointer in `info` lives until the call returns.
        let made = unsafe { shared.raw.create_compute_pipelines(cache, &[info], None) };
        // SAFETY: pipelines do not need their module once made.
        unsafe { shared.raw.destroy_shader_module(module, None) };
        let pipelines = made
            .map_err(|(_, result)| result)
            .context("vkCreateComputePipelines", name)?;
        self.raw = pipelines.first().copied().unwrap_or_default();
        shared.name(self.raw, name);
        shared.created.fetch_add(1, Ordering::Relaxed);
        Ok(())
    }

    /// The stage's name.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        self.layout.shader.name
    }

    /// Workgroups that cover `domain` invocations.
    #[must_use]
    pub fn groups(&self, domain: glam::UVec3) -> [u32; 3] {
        [0, 1, 2].map(|i| domain[i].div_ceil(self.local_size[i].max(1)))
    }

    /// Fills a descriptor set of this pipeline.
    ///
    /// # Errors
    /// The resources do not fit the layout, or the driver's refusal.
    pub fn bind(&self, resources: Vec<Resource>) -> Result<Binding, GpuError> {
        let name = self.name();
        let found: Vec<_> = resources.iter().map(Resource::kind).collect();
        if found != self.layout.bindings {
            return Err(GpuError::Shader {
                name: name.to_owned(),
                message: format!("bound {found:?}, its layout is {:?}", self.layout.bindings),
            });
        }
        let sizes: Vec<_> = found
            .iter()
            .map(|k| vk::DescriptorPoolSize {
                ty: k.descriptor_type(),
                descriptor_count: 1,
            })
            .collect();
        let raw = &self.device.shared.raw;
        let info = vk::DescriptorPoolCreateInfo::default()
            .max_sets(1)
            .pool_sizes(&sizes);
        // SAFETY: a live device; `Binding` destroys the pool.
        let pool = unsafe { raw.create_descriptor_pool(&info, None) }
            .context("vkCreateDescriptorPool", name)?;
        let mut binding = Binding {
            device: self.device.clone(),
            pool,
            set: vk::DescriptorSet::null(),
            resources,
        };
        let layouts = [self.set_layout];
        let info = vk::DescriptorSetAllocateInfo::default()
            .descriptor_pool(pool)
            .set_layouts(&layouts);
        // SAFETY: the pool has room for exactly this set.
        let sets = unsafe { raw.allocate_descriptor_sets(&info) }
            .context("vkAllocateDescriptorSets", name)?;
        binding.set = sets.first().copied().unwrap_or_default();
        binding.write();
        Ok(binding)
    }
}

impl Binding {
    fn write(&self) {
        for (binding, resource) in (0u32..).zip(&self.resources) {
            let write = vk::WriteDescriptorSet::default()
                .dst_set(self.set)
                .dst_binding(binding)
                .descriptor_type(resource.kind().descriptor_type());
            let image = |view, sampler, layout| {
                [vk::DescriptorImageInfo::default()
                    .image_view(view)
                    .sampler(sampler)
                    .image_layout(layout)]
            };
            // SAFETY: the set was allocated with this layout, is in no submission, and `resources`
            // keeps what it refers to alive.
            let update = |w| unsafe { self.device.shared.raw.update_descriptor_sets(&[w], &[]) };
            match resource {
                Resource::Sampled(i, s) => {
                    let info = image(i.view, s.raw, vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL);
                    update(write.image_info(&info));
                }
                Resource::SampledGeneral(i, s) => {
                    let info = image(i.view, s.raw, vk::ImageLayout::GENERAL);
                    update(write.image_info(&info));
                }
                Resource::Storage(i) => {
                    let info = image(i.view, vk::Sampler::null(), vk::ImageLayout::GENERAL);
                    update(write.image_info(&info));
                }
                Resource::Uniform(b) | Resource::StorageBuffer(b) => {
                    let info = [vk::DescriptorBufferInfo::default()
                        .buffer(b.raw)
                        .range(vk::WHOLE_SIZE)];
                    update(write.buffer_info(&info));
                }
            }
        }
    }
}

impl Drop for Binding {
    fn drop(&mut self) {
        // SAFETY: submissions are waited for, so the device does not use the set any more.
        unsafe {
            self.device
                .shared
                .raw
                .destroy_descriptor_pool(self.pool, None)
        };
    }
}

impl Drop for ComputePipeline {
    fn drop(&mut self) {
        let raw = &self.device.shared.raw;
        // SAFETY: submissions are waited for; null handles are ignored.
        unsafe {
            raw.destroy_pipeline(self.raw, None);
            raw.destroy_pipeline_layout(self.pipeline_layout, None);
            raw.destroy_descriptor_set_layout(self.set_layout, None);
        }
    }
}
