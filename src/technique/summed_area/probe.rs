//! Texels of fields and tables on the host, for tests: no technique reads them there.

use std::sync::Arc;

use exr::prelude::f16;
use glam::UVec3;

use super::scan::Scan;
use super::{Field, FieldKind, FieldPlan, ScanForm};
use crate::gpu::{
    Access, Buffer, BufferUse, Device, Format, GpuError, Image, ImageDesc, ImageType,
    ImageUsageFlags, Recorder, StageTime, download_image, upload_image,
};
use crate::scene::Scene;
use crate::technique::RenderError;
use crate::technique::medium::{self, Medium, MediumPlan};
use crate::technique::target::Target;

/// A field of a scene, its texels (x fastest) and the times of the stages that made it; `radius` in world units.
///
/// # Errors
/// The scene exceeds a limit, the driver's refusal, no memory, or a validation message.
#[doc(hidden)]
pub fn probe(
    device: &Device,
    scene: &Scene,
    kind: FieldKind,
    radius: f64,
) -> Result<(FieldPlan, Vec<f32>, Vec<StageTime>), RenderError> {
    let limits = &device.info().limits;
    let medium_plan = MediumPlan::new(scene, None, limits)?;
    let plan = FieldPlan::new(scene, &medium_plan, kind, radius, limits)?;
    let medium = uploaded(device, scene, &medium_plan)?;
    let target = Target::new(device, [scene.image.width, scene.image.height], None)?;
    target.write_view(scene);
    let mut field = Field::new(device, &plan, None)?;
    let times = field.record(device, (scene, &medium, &target), &mut |_, _| {})?;
    let cells = plan.area.cells.as_u64vec3().element_product();
    let read_back = Buffer::new(device, "field_read_back", 2 * cells, BufferUse::Readback)?;
    let mut recorder = Recorder::new(device)?;
    // WAW, and the layout: the copy finds the image as the stages that write it do.
    recorder.image_barrier(
        field.image(),
        Access::ComputeSampledOrLoaded,
        Access::ComputeWrite,
    );
    recorder.submit()?;
    download_image(device, field.image(), &read_back, "summed_area.probe")?;
    device.check_validation()?;
    let texels = read_back.with_bytes(|bytes| {
        let texels = bytes.chunks_exact(2).take(cells as usize);
        texels
            .map(|t| f16::from_bits(u16::from_ne_bytes([t[0], t[1]])).to_f32())
            .collect()
    });
    Ok((plan, texels, times))
}

/// `levels` of `cells` texels (x fastest) after one form has summed them along x, y and z, and the times of its
/// stages.
///
/// # Errors
/// The driver's refusal, no memory, or a validation message.
#[doc(hidden)]
pub fn probe_scan(
    device: &Device,
    form: ScanForm,
    cells: UVec3,
    levels: &[u32],
) -> Result<(Vec<u32>, Vec<StageTime>), GpuError> {
    let desc = ImageDesc {
        image_type: ImageType::TYPE_3D,
        extent: cells,
        format: Format::R32_UINT,
        usage: ImageUsageFlags::STORAGE
            | ImageUsageFlags::TRANSFER_SRC
            | ImageUsageFlags::TRANSFER_DST,
    };
    let image = Arc::new(Image::new(device, "sums", desc)?);
    let (slice, stage) = ((cells.x * cells.y) as usize, "summed_area.probe");
    let fill = |first: u32, _: u32, bytes: &mut [u8]| {
        let levels = levels.iter().skip(first as usize * slice);
        for (texel, level) in bytes.chunks_exact_mut(4).zip(levels) {
            texel.copy_from_slice(&level.to_ne_bytes());
        }
    };
    let ready = Access::ComputeWrite;
    upload_image(device, &image, stage, 4, ready, fill, &mut |_, _| {})?;
    let scan = Scan::new(device, form)?;
    let tables = [scan.bind(image.clone())?];
    let mut recorder = Recorder::new(device)?;
    scan.record(&mut recorder, &tables, cells);
    let times = recorder.submit()?;
    let bytes = 4 * cells.as_u64vec3().element_product();
    let read_back = Buffer::new(device, "sums_read_back", bytes, BufferUse::Readback)?;
    download_image(device, &image, &read_back, stage)?;
    let sums = read_back.with_bytes(|bytes| bytemuck::pod_collect_to_vec(&*bytes));
    Ok((sums, times))
}

fn uploaded(device: &Device, scene: &Scene, plan: &MediumPlan) -> Result<Medium, GpuError> {
    let medium = Medium::new(device, plan)?;
    medium.upload_volume(&scene.volume, &mut |_, _| {})?;
    medium.upload_table(scene)?;
    medium.write_uniforms(scene);
    let mut recorder = Recorder::new(device)?;
    medium::record_ranges(&mut recorder, &medium, &scene.volume);
    medium::record_occupancy(&mut recorder, &medium);
    recorder.submit()?;
    Ok(medium)
}
