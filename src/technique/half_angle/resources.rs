//! The technique's images, buffers and pipelines.

use std::sync::Arc;

use glam::UVec3;

use super::layout::COMPOSE;
use super::{HalfAnglePlan, SweepUniform, stage, tables};
use crate::gpu::{
    Access, Binding, Buffer, BufferUse, ComputePipeline, Device, Filter, Format, GpuError, Image,
    ImageDesc, ImageType, ImageUsageFlags, Recorder, Resource, StageTime, upload_image,
};
use crate::scene::{HalfAngleParams, Scene};
use crate::technique::albedo_volume::AlbedoImage;
use crate::technique::medium::{Medium, sampler};
use crate::technique::target::{Target, write};

/// Everything of `half_angle` on the device.
pub struct HalfAngle {
    /// What it was made from.
    pub plan: HalfAnglePlan,
    pub(super) shade: ComputePipeline,
    // Both stages read either light buffer as the current one.
    pub(super) shade_bindings: [Binding; 2],
    pub(super) propagate: Option<(ComputePipeline, [Binding; 2])>,
    pub(super) compose: ComputePipeline,
    pub(super) compose_binding: Binding,
    pub(super) light_buffers: [Arc<Image>; 2],
    pub(super) eye: Arc<Image>,
    pub(super) radiance: Arc<Image>,
    pub(super) uniforms: Vec<SweepUniform>,
    phase: Arc<Image>,
    transport: Arc<Image>,
    // The tables that the images hold.
    held: Option<[Vec<[f32; 4]>; 2]>,
    albedo: AlbedoImage,
    block: Arc<Buffer>,
}

/// What of an older technique still fits.
#[derive(Default)]
struct Kept {
    shade: Option<ComputePipeline>,
    propagate: Option<ComputePipeline>,
    compose: Option<ComputePipeline>,
    images: [Option<Arc<Image>>; 5],
    held: Option<[Vec<[f32; 4]>; 2]>,
    albedo: Option<AlbedoImage>,
    block: Option<Arc<Buffer>>,
}

impl Kept {
    fn new(old: Option<HalfAngle>, plan: &HalfAnglePlan) -> Self {
        let Some(old) = old else {
            return Self::default();
        };
        let same_reading = old.plan.shade().shader.name == plan.shade().shader.name;
        let same_shade = same_reading && old.plan.shade_constants == plan.shade_constants;
        let same_light = same_reading && old.plan.propagate_constants == plan.propagate_constants;
        let same_tables = (old.plan.phase_rows, old.plan.transport_entries)
            == (plan.phase_rows, plan.transport_entries);
        let [a, b] = old
            .light_buffers
            .map(|i| (old.plan.buffer == plan.buffer).then_some(i));
        Self {
            shade: same_shade.then_some(old.shade),
            propagate: old.propagate.filter(|_| same_light).map(|(p, _)| p),
            compose: Some(old.compose),
            images: [
                a,
                b,
                (old.plan.image == plan.image).then_some(old.eye),
                same_tables.then_some(old.phase),
                same_tables.then_some(old.transport),
            ],
            held: old.held.filter(|_| same_tables),
            albedo: Some(old.albedo),
            block: Some(old.block),
        }
    }
}

impl HalfAngle {
    /// Creates what the plan asks for beside medium and target, or takes over from `old` what still
    /// fits.
    ///
    /// # Errors
    /// The driver's refusal or no memory.
    pub fn new(
        device: &Device,
        plan: &HalfAnglePlan,
        medium: &Medium,
        target: &Target,
        old: Option<Self>,
    ) -> Result<Self, GpuError> {
        let kept = Kept::new(old, plan);
        let bytes = size_of::<SweepUniform>() as u64;
        let block = kept.block.map_or_else(
            || Buffer::new(device, "sweep", bytes, BufferUse::Uniform).map(Arc::new),
            Ok,
        )?;
        let [ping, pong, eye, phase, transport] = images(device, plan, kept.images)?;
        let albedo = AlbedoImage::new(device, plan.albedo, kept.albedo)?;
        let linear = sampler(device, "linear", Filter::LINEAR)?;
        let inputs = |last: &[&Arc<Image>]| {
            let mut list = vec![
                Resource::Uniform(target.view.clone()),
                Resource::Uniform(block.clone()),
                medium.volume.clone(),
                medium.transfer_function.clone(),
                medium.cell_distance.clone(),
                medium.mask.clone(),
                albedo.resource(linear.clone()),
                Resource::Storage(transport.clone()),
            ];
            list.extend(last.iter().map(|&i| Resource::Storage(i.clone())));
            medium.with_material(list)
        };
        let shade = kept.shade.map_or_else(
            || ComputePipeline::new(device, plan.shade(), &plan.shade_constants),
            Ok,
        )?;
        let shade_bindings = [
            shade.bind(inputs(&[&ping, &eye, &phase]))?,
            shade.bind(inputs(&[&pong, &eye, &phase]))?,
        ];
        let propagate = if plan.is_shadowed() {
            let pipeline = kept.propagate.map_or_else(
                || ComputePipeline::new(device, plan.propagate(), &plan.propagate_constants),
                Ok,
            )?;
            let bindings = [
                pipeline.bind(inputs(&[&ping, &pong]))?,
                pipeline.bind(inputs(&[&pong, &ping]))?,
            ];
            Some((pipeline, bindings))
        } else {
            None
        };
        let compose = kept
            .compose
            .map_or_else(|| ComputePipeline::new(device, COMPOSE, &[]), Ok)?;
        let compose_binding = compose.bind(vec![
            Resource::Uniform(target.view.clone()),
            Resource::Storage(eye.clone()),
            Resource::Storage(target.radiance.clone()),
        ])?;
        Ok(Self {
            plan: plan.clone(),
            shade,
            shade_bindings,
            propagate,
            compose,
            compose_binding,
            light_buffers: [ping, pong],
            eye,
            radiance: target.radiance.clone(),
            uniforms: Vec::new(),
            phase,
            transport,
            held: kept.held,
            albedo,
            block,
        })
    }

    /// Brings the tables and the albedo volume up to date.
    ///
    /// # Errors
    /// The driver's refusal or no memory for staging.
    pub fn upload(
        &mut self,
        device: &Device,
        scene: &Scene,
        params: &HalfAngleParams,
    ) -> Result<Vec<StageTime>, GpuError> {
        let mut times = self.albedo.upload(device, scene, stage::UPLOAD_ALBEDO)?;
        let table = &self.plan.medium.table;
        let transport = if self.plan.transport_entries > 1 {
            tables::transport(params, table)
        } else {
            vec![[0.0; 4]]
        };
        let wanted = [tables::phase(params), transport];
        if self.held.as_ref() == Some(&wanted) {
            return Ok(times);
        }
        for (image, rows) in [&self.phase, &self.transport].into_iter().zip(&wanted) {
            let fill = |_, _, to: &mut [u8]| to.copy_from_slice(bytemuck::cast_slice(rows));
            let (name, after) = (stage::UPLOAD_TABLES, Access::ComputeRead);
            let one = upload_image(device, image, name, 16, after, fill, &mut |_, _| {})?;
            // A single row is never read: only brought to the layout that its descriptor names.
            if rows.len() > 1 {
                times.extend(one);
            }
        }
        self.held = Some(wanted);
        Ok(times)
    }

    /// Notes what the sweeps' blocks hold; each is written before its sweep.
    pub fn prepare(&mut self, scene: &Scene, params: &HalfAngleParams, medium: &Medium) {
        let uniform = |i| SweepUniform::new(scene, params, &self.plan, medium, i);
        self.uniforms = (0..self.plan.sweeps.len()).map(uniform).collect();
    }

    /// Writes the block of a sweep; no submission is under way then.
    pub(super) fn write_block(&self, sweep: usize) {
        if let Some(uniform) = self.uniforms.get(sweep) {
            write(&self.block, uniform);
        }
    }
}

/// Two light buffers, the eye buffer, and the two tables.
fn images(
    device: &Device,
    plan: &HalfAnglePlan,
    kept: [Option<Arc<Image>>; 5],
) -> Result<[Arc<Image>; 5], GpuError> {
    let buffer = plan.buffer.extend(1);
    let pixels = UVec3::new(plan.image[0], plan.image[1], 1);
    let rows = |n| UVec3::new(n, 1, 1);
    let swept = ImageUsageFlags::STORAGE | ImageUsageFlags::TRANSFER_DST;
    let made = |kept: Option<Arc<Image>>, name, image_type, extent| match kept {
        Some(image) => Ok(image),
        None => image(device, name, (image_type, extent), swept),
    };
    let [ping, pong, eye, phase, transport] = kept;
    let (flat, row) = (ImageType::TYPE_2D, ImageType::TYPE_1D);
    Ok([
        made(ping, "light_buffer", flat, buffer)?,
        made(pong, "light_buffer_pong", flat, buffer)?,
        made(eye, "eye_buffer", flat, pixels)?,
        made(phase, "phase_table", row, rows(plan.phase_rows))?,
        made(transport, "transport", row, rows(plan.transport_entries))?,
    ])
}

fn image(
    device: &Device,
    name: &str,
    (image_type, extent): (ImageType, UVec3),
    usage: ImageUsageFlags,
) -> Result<Arc<Image>, GpuError> {
    let desc = ImageDesc {
        image_type,
        extent,
        format: Format::R32G32B32A32_SFLOAT,
        usage,
    };
    let image = Image::new(device, name, desc)?;
    let mut recorder = Recorder::new(device)?;
    // Nothing was there before; stages find the layout that their descriptors name.
    recorder.image_barrier(&image, Access::Undefined, Access::ComputeRead);
    recorder.submit()?;
    Ok(Arc::new(image))
}
