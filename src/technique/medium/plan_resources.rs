//! The medium's device memory.

use glam::UVec3;

use super::{CellsPlan, MediumPlan};
use crate::gpu::{Format, staging};
use crate::scene::perturbation::NOISE_SIZE;
use crate::technique::{ResourceKind, ResourcePlan};

/// What makes tables smaller.
const WIDER: &str = "widen the transfer function's narrowest segment";

fn texels(extent: UVec3) -> u64 {
    extent.as_u64vec3().element_product()
}

/// An image of `texel` bytes a texel.
fn image(
    name: &'static str,
    kind: ResourceKind,
    extent: UVec3,
    (format, texel): (Format, u64),
    shrink: &'static str,
) -> ResourcePlan {
    ResourcePlan {
        name,
        kind,
        extent,
        format,
        bytes: texel * texels(extent),
        shrink,
    }
}

impl MediumPlan {
    /// The resources with their sizes.
    #[must_use]
    pub fn resources(&self) -> Vec<ResourcePlan> {
        let mut list = self.of_volume();
        list.extend(self.of_material());
        list.extend(self.cells.iter().flat_map(|c| self.of_cells(c)));
        list
    }

    fn of_volume(&self) -> Vec<ResourcePlan> {
        let texel = self.encoding.texel_bytes();
        let mut list = vec![image(
            "volume",
            ResourceKind::Volume,
            self.stored,
            (self.encoding.format, texel),
            "resample or crop the volume, or store it in fewer bits",
        )];
        // A height field's heights are staged like its data values.
        let staged = if self.height_field { 4 } else { texel };
        let slice = u64::from(self.dims.x) * u64::from(self.dims.y) * staged;
        let (_, bytes) = staging(slice, self.stored.z);
        list.push(ResourcePlan {
            name: "volume staging",
            kind: ResourceKind::Staging,
            extent: UVec3::new(u32::try_from(bytes).unwrap_or(u32::MAX), 1, 1),
            format: Format::UNDEFINED,
            bytes,
            shrink: "resample or crop the volume",
        });
        if self.masked {
            list.push(image(
                "finite_mask",
                ResourceKind::Auxiliary,
                self.stored,
                (Format::R8_UNORM, 1),
                "replace NaN and infinite voxels in the file",
            ));
        }
        if self.height_field {
            list.push(image(
                "surface_heights",
                ResourceKind::Volume,
                self.stored,
                (Format::R32_SFLOAT, 4),
                "raise volume.height_field.level",
            ));
        }
        list
    }

    fn of_material(&self) -> Vec<ResourcePlan> {
        let entries = self.table.entries;
        let colors = |name, extent, shrink| {
            let texel = (Format::R32G32B32A32_SFLOAT, 16);
            image(name, ResourceKind::Auxiliary, extent, texel, shrink)
        };
        let row = UVec3::new(entries, 1, 1);
        let mut list = vec![colors("transfer_function", row, WIDER)];
        if self.octaves() > 0 {
            let tile = UVec3::splat(NOISE_SIZE as u32);
            list.push(colors("noise", tile, "leave medium.perturbation out"));
        }
        if let Some(axis) = self.table.gradients {
            let extent = UVec3::new(entries, axis.entries, 1);
            let wider = "widen the transfer function's narrowest shape";
            list.push(colors("gradient_table", extent, wider));
        }
        list
    }

    fn of_cells(&self, cells: &CellsPlan) -> [ResourcePlan; 4] {
        let of = |name, extent, texel, shrink| {
            image(name, ResourceKind::Auxiliary, extent, texel, shrink)
        };
        let off = "set the technique's empty_space_skipping = false";
        let counts = UVec3::new(self.table.entries + 1, 1, 1);
        let distance = (Format::R8_UINT, 1);
        [
            of("occupied_before", counts, (Format::R32_UINT, 4), WIDER),
            of("cell_min_max", cells.dims, self.encoding.pair_format(), off),
            of("cell_distance", cells.dims, distance, off),
            of("cell_distance_pong", cells.dims, distance, off),
        ]
    }
}
