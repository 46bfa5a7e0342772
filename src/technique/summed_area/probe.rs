//! A field's texels on the host, for tests: no technique reads them there.

use exr::prelude::f16;

use super::{Field, FieldKind, FieldPlan};
use crate::gpu::{
    Access, Buffer, BufferUse, Device, GpuError, Recorder, StageTime, download_image,
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

fn uploaded(device: &Device, scene: &Scene, plan: &MediumPlan) -> Result<Medium, GpuError> {
    let medium = Medium::new(device, plan)?;
    medium.upload_volume(&scene.volume, &mut |_, _| {})?;
    medium.upload_table(scene)?;
    medium.write_uniforms(scene);
    let mut recorder = Recorder::new(device)?;
    medium::record_ranges(&mut recorder, &medium);
    medium::record_occupancy(&mut recorder, &medium);
    recorder.submit()?;
    Ok(medium)
}
