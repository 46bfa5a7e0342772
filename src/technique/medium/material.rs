//! What stages read to find the medium's material at a place (`glsl/shared/material.glsl`): the last bindings of
//! every one of them, and constants that leave out what the scene has not.

use bytemuck::{Pod, Zeroable};
use glam::DVec3;

use super::MediumPlan;
use crate::gpu::{BindingKind, Specialization};
use crate::scene::Scene;
use crate::scene::perturbation::{MOST_OCTAVES, Octave};
use crate::technique::view::{grid_rows, vec4};

/// The bindings that follow a stage's own.
pub const MATERIAL: [BindingKind; 4] = [
    BindingKind::UniformBuffer,
    BindingKind::SampledImage,
    BindingKind::SampledImage,
    BindingKind::SampledImage,
];

/// Constants of the material, in the order of their ids; they follow a stage's own.
pub const CONSTANTS: [Specialization; 4] = {
    [
        Specialization::new(32, "GRADIENTS"),
        Specialization::new(33, "DISPLACED"),
        Specialization::new(34, "VARIED"),
        Specialization::new(35, "HEIGHT_FIELD"),
    ]
};

/// A stage's own bindings and the material's: `ALL` is `OWN + MATERIAL.len()`.
#[must_use]
pub const fn with_material<const OWN: usize, const ALL: usize>(
    own: [BindingKind; OWN],
) -> [BindingKind; ALL] {
    let mut all = [BindingKind::SampledImage; ALL];
    let mut i = 0;
    while i < ALL {
        all[i] = if i < OWN { own[i] } else { MATERIAL[i - OWN] };
        i += 1;
    }
    all
}

/// The `Material` block, std140.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[allow(missing_docs, reason = "documented in glsl/shared/material.glsl")]
pub struct MaterialUniform {
    pub gradient: [[f32; 4]; 3],
    pub world_from_grid: [[f32; 4]; 3],
    pub grid_from_world: [[f32; 4]; 3],
    pub displacing: [[f32; 4]; MOST_OCTAVES],
    pub displacement: [[f32; 4]; MOST_OCTAVES],
    pub varying_at: [[f32; 4]; MOST_OCTAVES],
    pub variation: [[f32; 4]; MOST_OCTAVES],
    pub layer: [f32; 4],
}

impl MaterialUniform {
    /// Fills the block for a scene.
    #[must_use]
    pub fn new(scene: &Scene, plan: &MediumPlan) -> Self {
        let scale = plan.encoding.scale;
        let columns = scene
            .volume
            .grid
            .world_from_index
            .matrix3
            .inverse()
            .transpose();
        let (entries, a_unit) = plan.table.gradients.map_or((0.0, 0.0), |axis| {
            // Entries go with the gradient's root.
            let last = f64::from(axis.entries - 1);
            (f64::from(axis.entries), last * last / axis.max)
        });
        Self {
            gradient: [
                vec4(columns.x_axis * scale, entries),
                vec4(columns.y_axis * scale, a_unit),
                vec4(columns.z_axis * scale, 0.0),
            ],
            layer: (scene.volume.height_field.as_ref()).map_or([0.0; 4], |f| {
                vec4(DVec3::new(f.bottom, f.top, 1.0 / f.ramp), 0.0)
            }),
            ..Self::noise(scene)
        }
    }

    /// What the block says of noise.
    fn noise(scene: &Scene) -> Self {
        let grid = &scene.volume.grid;
        let rows = grid.world_from_index.matrix3.inverse().transpose();
        let mut block = Self {
            world_from_grid: grid_rows(grid),
            grid_from_world: [rows.x_axis, rows.y_axis, rows.z_axis].map(|row| vec4(row, 0.0)),
            ..Self::zeroed()
        };
        let Some(p) = &scene.medium.perturbation else {
            return block;
        };
        // From the centre, as places are on the device.
        let place = |o: &Octave| vec4(o.tile_at(grid.centre(), p.time), o.tiles());
        let displacing = p.octaves.iter().filter(|o| o.displacement > 0.0);
        for (i, octave) in displacing.enumerate().take(MOST_OCTAVES) {
            block.displacing[i] = place(octave);
            block.displacement[i][0] = octave.displacement as f32;
        }
        let varying = p.octaves.iter().filter(|o| o.varies());
        for (i, octave) in varying.enumerate().take(MOST_OCTAVES) {
            block.varying_at[i] = place(octave);
            block.variation[i] = octave.color.extend(octave.opacity as f32).to_array();
        }
        block
    }
}

impl MediumPlan {
    /// A stage's own constants with these values, and the material's.
    #[must_use]
    pub fn with_constants(&self, own: &[Specialization], values: &[u32]) -> Vec<Specialization> {
        let mut all = Specialization::with_values(own, values);
        all.extend(self.constants());
        all
    }

    /// What of the material stages compile in.
    #[must_use]
    pub fn constants(&self) -> Vec<Specialization> {
        let values = [
            u32::from(self.table.gradients.is_some()),
            self.displaced,
            self.varied,
            u32::from(self.height_field),
        ];
        Specialization::with_values(&CONSTANTS, &values)
    }
}
