//! Pipelines that stay, and the tables themselves, which do not.

use std::sync::Arc;

use super::scan::{Scan, Table};
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
    pub(super) scan: Scan,
    area: Arc<Buffer>,
}

/// Tables on the device, one texel a cell: 32-bit levels, each the sum of all cells up to and with it along x, y
/// and z.
pub struct Sums {
    /// Of extinctions, then of their squares where the plan wants them.
    pub(super) tables: Vec<Table>,
    pub(super) extinction: Binding,
}

impl Sums {
    /// The tables: of extinctions, then of their squares where the plan wants them.
    pub fn tables(&self) -> impl Iterator<Item = &Arc<Image>> {
        self.tables.iter().map(|table| &table.image)
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
        let (mut extinction, mut scan, mut area) = (None, None, None);
        if let Some(old) = old {
            let same = old.plan.constants == plan.constants
                && old.plan.extinction().shader.name == plan.extinction().shader.name;
            extinction = same.then_some(old.extinction);
            scan = (old.scan.form == plan.scan).then_some(old.scan);
            area = Some(old.area);
        }
        let extinction = extinction.map_or_else(
            || ComputePipeline::new(device, plan.extinction(), &plan.constants),
            Ok,
        )?;
        let scan = scan.map_or_else(|| Scan::new(device, plan.scan), Ok)?;
        let uniform = || {
            let bytes = size_of::<AreaUniform>() as u64;
            Buffer::new(device, "area", bytes, BufferUse::Uniform).map(Arc::new)
        };
        let area = area.map_or_else(uniform, Ok)?;
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
        let tables = tables.into_iter().map(|image| self.scan.bind(image));
        Ok(Sums {
            tables: tables.collect::<Result<_, GpuError>>()?,
            extinction: self.extinction.bind(medium.with_material(list))?,
        })
    }
}
