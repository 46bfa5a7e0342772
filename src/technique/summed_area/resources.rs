//! Pipelines that stay, and the table itself, which does not.

use std::sync::Arc;

use super::layout::SCAN;
use super::{AreaUniform, SummedAreaPlan};
use crate::gpu::{
    Access, Binding, Buffer, BufferUse, ComputePipeline, Device, Format, GpuError, Image,
    ImageDesc, ImageType, ImageUsageFlags, Recorder, Resource,
};
use crate::scene::Scene;
use crate::technique::medium::Medium;
use crate::technique::target::{Target, write};

/// The stages on the device.
pub struct SummedArea {
    /// What it was made from.
    pub plan: SummedAreaPlan,
    pub(super) extinction: ComputePipeline,
    pub(super) scan: ComputePipeline,
    area: Arc<Buffer>,
}

/// A table on the device: 32-bit levels, each the sum of all cells up to and with it along x, y and z.
pub struct Sums {
    /// The table, one texel a cell.
    pub image: Arc<Image>,
    pub(super) extinction: Binding,
    pub(super) scan: Binding,
}

impl SummedArea {
    /// Creates the pipelines, or takes over from `old` what still fits.
    ///
    /// # Errors
    /// The driver's refusal or no memory.
    pub fn new(
        device: &Device,
        plan: &SummedAreaPlan,
        old: Option<Self>,
    ) -> Result<Self, GpuError> {
        let (mut extinction, mut kept) = (None, None);
        if let Some(old) = old {
            let same = old.plan.constants == plan.constants
                && old.plan.extinction().shader.name == plan.extinction().shader.name;
            extinction = same.then_some(old.extinction);
            kept = Some((old.scan, old.area));
        }
        let extinction = extinction.map_or_else(
            || ComputePipeline::new(device, plan.extinction(), &plan.constants),
            Ok,
        )?;
        let (scan, area) = match kept {
            Some(kept) => kept,
            None => {
                let bytes = size_of::<AreaUniform>() as u64;
                let area = Buffer::new(device, "area", bytes, BufferUse::Uniform)?;
                (ComputePipeline::new(device, SCAN, &[])?, Arc::new(area))
            }
        };
        Ok(Self {
            plan: plan.clone(),
            extinction,
            scan,
            area,
        })
    }

    /// Writes what the extinction stage reads of the scene beside view and medium.
    pub fn write_uniforms(&self, scene: &Scene, medium: &Medium) {
        write(&self.area, &AreaUniform::new(scene, &self.plan, medium));
    }

    /// Creates an empty table.
    ///
    /// # Errors
    /// The driver's refusal or no memory.
    pub fn allocate(
        &self,
        device: &Device,
        medium: &Medium,
        target: &Target,
    ) -> Result<Sums, GpuError> {
        let desc = ImageDesc {
            image_type: ImageType::TYPE_3D,
            extent: self.plan.cells,
            format: Format::R32_UINT,
            usage: ImageUsageFlags::STORAGE,
        };
        let image = Arc::new(Image::new(device, "sums", desc)?);
        let mut recorder = Recorder::new(device)?;
        // Nothing was there before.
        recorder.image_barrier(&image, Access::Undefined, Access::ComputeWrite);
        recorder.submit()?;
        let extinction = self.extinction.bind(vec![
            Resource::Uniform(target.view.clone()),
            Resource::Uniform(self.area.clone()),
            medium.volume.clone(),
            medium.transfer_function.clone(),
            medium.cell_distance.clone(),
            medium.mask.clone(),
            Resource::Storage(image.clone()),
        ])?;
        let scan = self.scan.bind(vec![Resource::Storage(image.clone())])?;
        Ok(Sums {
            image,
            extinction,
            scan,
        })
    }
}
