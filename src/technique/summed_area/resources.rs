//! Pipelines that stay, and the tables themselves, which do not.

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

/// Tables on the device, one texel a cell: 32-bit levels, each the sum of all cells up to and with it along x, y
/// and z.
pub struct Sums {
    /// Of extinctions, then of their squares where the plan wants them; with what scans each.
    pub(super) scans: Vec<(Arc<Image>, Binding)>,
    pub(super) extinction: Binding,
}

impl Sums {
    /// The tables: of extinctions, then of their squares where the plan wants them.
    pub fn tables(&self) -> impl Iterator<Item = &Arc<Image>> {
        self.scans.iter().map(|(image, _)| image)
    }
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

    /// Creates empty tables.
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
        let table = |name| Image::new(device, name, desc).map(Arc::new);
        let mut tables = vec![table("sums")?];
        if self.plan.squares {
            tables.push(table("squares")?);
        }
        let mut recorder = Recorder::new(device)?;
        for image in &tables {
            // Nothing was there before.
            recorder.image_barrier(image, Access::Undefined, Access::ComputeWrite);
        }
        recorder.submit()?;
        let mut list = vec![
            Resource::Uniform(target.view.clone()),
            Resource::Uniform(self.area.clone()),
            medium.volume.clone(),
            medium.transfer_function.clone(),
            medium.cell_distance.clone(),
            medium.mask.clone(),
        ];
        // Without squares the first table takes their place, where the shader then writes nothing.
        let places = tables.iter().cycle().take(2);
        list.extend(places.map(|image| Resource::Storage(image.clone())));
        let scans = tables.into_iter().map(|image| {
            let binding = self.scan.bind(vec![Resource::Storage(image.clone())])?;
            Ok((image, binding))
        });
        Ok(Sums {
            scans: scans.collect::<Result<_, GpuError>>()?,
            extinction: self.extinction.bind(medium.with_material(list))?,
        })
    }
}
