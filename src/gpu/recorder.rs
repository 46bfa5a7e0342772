//! Recording one submission: labelled, timed stages and explicit barriers.

use std::ffi::CString;
use std::marker::PhantomData;
use std::sync::atomic::Ordering;

use ash::vk;
use glam::UVec3;
use serde::Serialize;

use super::error::Context;
use super::{Access, Binding, Buffer, ComputePipeline, Device, GpuError, Image};

/// How long the device took for one stage.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StageTime {
    /// `technique.stage`.
    pub name: String,
    /// Device seconds; 0 where the queue has no timestamps.
    pub seconds: f64,
}

/// Timed stages one recorder can hold.
const MAX_STAGES: u32 = 64;

/// A command buffer being recorded. What it uses is borrowed until [`Recorder::submit`] has waited
/// for the device.
pub struct Recorder<'a> {
    device: Device,
    pool: vk::CommandPool,
    cmd: vk::CommandBuffer,
    queries: vk::QueryPool,
    fence: vk::Fence,
    stages: Vec<String>,
    barriers: usize,
    borrows: PhantomData<&'a ()>,
}

impl<'a> Recorder<'a> {
    /// Begins a command buffer.
    ///
    /// # Errors
    /// The driver's refusal.
    pub fn new(device: &Device) -> Result<Self, GpuError> {
        let mut recorder = Self {
            device: device.clone(),
            pool: vk::CommandPool::null(),
            cmd: vk::CommandBuffer::null(),
            queries: vk::QueryPool::null(),
            fence: vk::Fence::null(),
            stages: Vec::new(),
            barriers: 0,
            borrows: PhantomData,
        };
        recorder.create()?;
        Ok(recorder)
    }

    fn create(&mut self) -> Result<(), GpuError> {
        let shared = &self.device.shared;
        let raw = &shared.raw;
        let pool = vk::CommandPoolCreateInfo::default()
            .queue_family_index(shared.queue_family)
            .flags(vk::CommandPoolCreateFlags::TRANSIENT);
        let queries = vk::QueryPoolCreateInfo::default()
            .query_type(vk::QueryType::TIMESTAMP)
            .query_count(2 * MAX_STAGES);
        // SAFETY: a live device; `self` destroys whatever has been made, also on failure.
        unsafe {
            self.pool = raw
                .create_command_pool(&pool, None)
                .context("vkCreateCommandPool", "frame")?;
            self.queries = raw
                .create_query_pool(&queries, None)
                .context("vkCreateQueryPool", "frame")?;
            self.fence = raw
                .create_fence(&vk::FenceCreateInfo::default(), None)
                .context("vkCreateFence", "frame")?;
            let info = vk::CommandBufferAllocateInfo::default()
                .command_pool(self.pool)
                .command_buffer_count(1);
            let list = raw
                .allocate_command_buffers(&info)
                .context("vkAllocateCommandBuffers", "frame")?;
            self.cmd = list.first().copied().unwrap_or_default();
            let begin = vk::CommandBufferBeginInfo::default()
                .flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
            raw.begin_command_buffer(self.cmd, &begin)
                .context("vkBeginCommandBuffer", "frame")?;
            raw.cmd_reset_query_pool(self.cmd, self.queries, 0, 2 * MAX_STAGES);
        }
        Ok(())
    }

    /// A compute stage: a debug label and a pair of timestamps around what `record` records.
    pub fn compute_stage(&mut self, name: &str, record: impl FnOnce(&mut Self)) {
        self.stage(name, vk::PipelineStageFlags2::COMPUTE_SHADER, record);
    }

    /// A copy stage: a debug label and a pair of timestamps around what `record` records.
    pub fn copy_stage(&mut self, name: &str, record: impl FnOnce(&mut Self)) {
        self.stage(name, vk::PipelineStageFlags2::COPY, record);
    }

    /// A debug label around what `record` records, within a stage that alternates shaders.
    pub fn labelled(&mut self, name: &str, record: impl FnOnce(&mut Self)) {
        self.label(Some(name));
        record(self);
        self.label(None);
    }

    fn stage(&mut self, name: &str, kind: vk::PipelineStageFlags2, record: impl FnOnce(&mut Self)) {
        let index = u32::try_from(self.stages.len()).unwrap_or(MAX_STAGES);
        let timed = index < MAX_STAGES && self.device.info().timestamp_period_ns > 0.0;
        self.stages.push(name.to_owned());
        self.label(Some(name));
        if timed {
            self.timestamp(kind, 2 * index);
        }
        record(self);
        if timed {
            self.timestamp(kind, 2 * index + 1);
        }
        self.label(None);
    }

    fn timestamp(&self, stage: vk::PipelineStageFlags2, query: u32) {
        // SAFETY: the query was reset at the beginning and is written once.
        unsafe {
            self.device
                .shared
                .raw
                .cmd_write_timestamp2(self.cmd, stage, self.queries, query)
        };
    }

    fn label(&self, name: Option<&str>) {
        let Some(debug_utils) = &self.device.shared.debug_utils else {
            return;
        };
        // SAFETY: the command buffer is being recorded; labels are strictly nested.
        unsafe {
            match name.map(CString::new) {
                Some(Ok(name)) => {
                    let label = vk::DebugUtilsLabelEXT::default().label_name(&name);
                    debug_utils.cmd_begin_debug_utils_label(self.cmd, &label);
                }
                Some(Err(_)) => debug_utils
                    .cmd_begin_debug_utils_label(self.cmd, &vk::DebugUtilsLabelEXT::default()),
                None => debug_utils.cmd_end_debug_utils_label(self.cmd),
            }
        }
    }

    /// Binds a pipeline with its resources and dispatches enough workgroups to cover `domain`.
    pub fn dispatch(
        &mut self,
        pipeline: &'a ComputePipeline,
        binding: &'a Binding,
        push: &[u8],
        domain: UVec3,
    ) {
        let raw = &self.device.shared.raw;
        let [x, y, z] = pipeline.groups(domain);
        let point = vk::PipelineBindPoint::COMPUTE;
        // SAFETY: pipeline, set and what the set refers to outlive the submission (lifetime `'a`,
        // `Binding` owns its resources); the layouts match by construction.
        unsafe {
            raw.cmd_bind_pipeline(self.cmd, point, pipeline.raw);
            raw.cmd_bind_descriptor_sets(
                self.cmd,
                point,
                pipeline.pipeline_layout,
                0,
                &[binding.set],
                &[],
            );
            if !push.is_empty() {
                let stage = vk::ShaderStageFlags::COMPUTE;
                raw.cmd_push_constants(self.cmd, pipeline.pipeline_layout, stage, 0, push);
            }
            raw.cmd_dispatch(self.cmd, x, y, z);
        }
    }

    /// An image barrier with layout transition: what was done `before`, what comes `after`.
    pub fn image_barrier(&mut self, image: &'a Image, before: Access, after: Access) {
        let (src, dst) = (before.scope(), after.scope());
        let barrier = [vk::ImageMemoryBarrier2::default()
            .src_stage_mask(src.stage)
            .src_access_mask(src.mask)
            .dst_stage_mask(dst.stage)
            .dst_access_mask(dst.mask)
            .old_layout(src.layout)
            .new_layout(dst.layout)
            .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .image(image.raw)
            .subresource_range(Image::whole())];
        self.barrier(&vk::DependencyInfo::default().image_memory_barriers(&barrier));
    }

    /// A buffer barrier: what was done `before`, what comes `after`.
    pub fn buffer_barrier(&mut self, buffer: &'a Buffer, before: Access, after: Access) {
        let (src, dst) = (before.scope(), after.scope());
        let barrier = [vk::BufferMemoryBarrier2::default()
            .src_stage_mask(src.stage)
            .src_access_mask(src.mask)
            .dst_stage_mask(dst.stage)
            .dst_access_mask(dst.mask)
            .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .buffer(buffer.raw)
            .size(vk::WHOLE_SIZE)];
        self.barrier(&vk::DependencyInfo::default().buffer_memory_barriers(&barrier));
    }

    fn barrier(&mut self, info: &vk::DependencyInfo<'_>) {
        let index = self.barriers;
        self.barriers += 1;
        if self.device.shared.omitted_barrier.load(Ordering::Relaxed) != index {
            // SAFETY: the command buffer is being recorded and the objects outlive it (`'a`).
            unsafe { self.device.shared.raw.cmd_pipeline_barrier2(self.cmd, info) };
        }
    }

    /// Copies tightly packed texels from `buffer` to `extent` texels at `offset` of an image.
    pub fn copy_to_image(
        &mut self,
        buffer: &'a Buffer,
        image: &'a Image,
        offset: UVec3,
        extent: UVec3,
    ) {
        let copy = [copy_region(offset, extent)];
        let layout = Access::CopyWrite.scope().layout;
        // SAFETY: as in `dispatch`; callers size the buffer for the region.
        unsafe {
            self.device
                .shared
                .raw
                .cmd_copy_buffer_to_image(self.cmd, buffer.raw, image.raw, layout, &copy);
        }
    }

    /// Copies a whole image into `buffer`, tightly packed.
    pub fn copy_to_buffer(&mut self, image: &'a Image, buffer: &'a Buffer) {
        let copy = [copy_region(UVec3::ZERO, image.desc().extent)];
        let layout = Access::CopyRead.scope().layout;
        // SAFETY: as in `dispatch`; callers size the buffer for the image.
        unsafe {
            self.device
                .shared
                .raw
                .cmd_copy_image_to_buffer(self.cmd, image.raw, layout, buffer.raw, &copy);
        }
    }

    /// Sets every texel of a float image, in the layout of [`Access::Clear`], to 0.
    pub fn clear_image(&mut self, image: &'a Image) {
        let (layout, zero) = (Access::Clear.scope().layout, vk::ClearColorValue::default());
        let raw = &self.device.shared.raw;
        // SAFETY: as in `dispatch`.
        unsafe {
            raw.cmd_clear_color_image(self.cmd, image.raw, layout, &zero, &[Image::whole()]);
        }
    }

    /// Barriers recorded so far.
    #[must_use]
    pub const fn barrier_count(&self) -> usize {
        self.barriers
    }

    /// Submits, waits for the device and returns each stage's time in order.
    ///
    /// # Errors
    /// The driver's refusal, a lost device, or a validation message.
    pub fn submit(self) -> Result<Vec<StageTime>, GpuError> {
        let shared = &self.device.shared;
        let raw = &shared.raw;
        let commands = [vk::CommandBufferSubmitInfo::default().command_buffer(self.cmd)];
        let submits = [vk::SubmitInfo2::default().command_buffer_infos(&commands)];
        // SAFETY: everything recorded lives (`'a`); the queue is locked for the submission.
        unsafe {
            raw.end_command_buffer(self.cmd)
                .context("vkEndCommandBuffer", "frame")?;
            {
                let queue = shared
                    .queue
                    .lock()
                    .unwrap_or_else(std::sync::PoisonError::into_inner);
                raw.queue_submit2(*queue, &submits, self.fence)
                    .context("vkQueueSubmit2", "frame")?;
            }
            raw.wait_for_fences(&[self.fence], true, u64::MAX)
                .context("vkWaitForFences", "frame")?;
        }
        let times = self.times()?;
        self.device.check_validation()?;
        Ok(times)
    }

    fn times(&self) -> Result<Vec<StageTime>, GpuError> {
        let period = f64::from(self.device.info().timestamp_period_ns) * 1e-9;
        let timed = if period > 0.0 {
            self.stages.len().min(MAX_STAGES as usize)
        } else {
            0
        };
        let mut ticks = vec![0u64; 2 * timed];
        if timed > 0 {
            let flags = vk::QueryResultFlags::TYPE_64 | vk::QueryResultFlags::WAIT;
            // SAFETY: the submission is complete and wrote these queries.
            unsafe {
                self.device
                    .shared
                    .raw
                    .get_query_pool_results(self.queries, 0, &mut ticks, flags)
            }
            .context("vkGetQueryPoolResults", "frame")?;
        }
        let seconds = |i: usize| {
            ticks
                .get(2 * i..2 * i + 2)
                .map_or(0.0, |t| t[1].wrapping_sub(t[0]) as f64 * period)
        };
        let named = self.stages.iter().enumerate();
        Ok(named
            .map(|(i, name)| StageTime {
                name: name.clone(),
                seconds: seconds(i),
            })
            .collect())
    }
}

fn copy_region(offset: UVec3, extent: UVec3) -> vk::BufferImageCopy {
    let signed = offset.as_ivec3();
    vk::BufferImageCopy::default()
        .image_subresource(vk::ImageSubresourceLayers {
            aspect_mask: vk::ImageAspectFlags::COLOR,
            mip_level: 0,
            base_array_layer: 0,
            layer_count: 1,
        })
        .image_offset(vk::Offset3D {
            x: signed.x,
            y: signed.y,
            z: signed.z,
        })
        .image_extent(vk::Extent3D {
            width: extent.x,
            height: extent.y,
            depth: extent.z,
        })
}

impl Drop for Recorder<'_> {
    fn drop(&mut self) {
        let raw = &self.device.shared.raw;
        // SAFETY: either never submitted or waited for; null handles are ignored.
        unsafe {
            raw.destroy_fence(self.fence, None);
            raw.destroy_query_pool(self.queries, None);
            raw.destroy_command_pool(self.pool, None);
        }
    }
}
