//! Where voxels lie: dimensions and the affine map from index to world.

use glam::{DAffine3, DMat3, DVec3, UVec3};
use serde::Serialize;

/// What the world's axes mean.
///
/// A file whose header says that its axes are the patient's is brought to RAS (x to the patient's
/// right, y to the front, z to the head); NRRD and MetaImage files in LPS are turned by 180 degrees
/// about z, so that NIfTI and NRRD files of one subject coincide. Everything else keeps its axes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Space {
    /// x to the patient's right, y anterior, z superior.
    PatientRas,
    /// The file does not say.
    Unspecified,
}

/// A regular grid of `dims` voxels under an affine map (spacing, origin and directions).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// Voxels along x (fastest in memory), y and z; each at least 1.
    pub dims: UVec3,
    /// Continuous voxel index to world; index (0, 0, 0) is the *centre* of the first voxel.
    /// Invertible; may mirror (negative determinant).
    pub world_from_index: DAffine3,
    /// What the world's axes mean.
    pub space: Space,
}

impl Grid {
    /// An axis-aligned grid with the centre of its first voxel at `origin`.
    #[must_use]
    pub fn axis_aligned(dims: UVec3, spacing: DVec3, origin: DVec3) -> Self {
        Self {
            dims,
            world_from_index: DAffine3::from_mat3_translation(
                DMat3::from_diagonal(spacing),
                origin,
            ),
            space: Space::Unspecified,
        }
    }

    /// An axis-aligned grid whose box is centred on the world's origin.
    #[must_use]
    pub fn centred(dims: UVec3, spacing: DVec3) -> Self {
        Self::axis_aligned(dims, spacing, (1.0 - dims.as_dvec3()) * spacing * 0.5)
    }

    /// Voxel count.
    #[must_use]
    pub fn voxel_count(&self) -> u64 {
        u64::from(self.dims.x) * u64::from(self.dims.y) * u64::from(self.dims.z)
    }

    /// Position of voxel `i` in storage order.
    #[must_use]
    pub fn linear_index(&self, i: UVec3) -> usize {
        let d = self.dims.as_u64vec3();
        let i = i.as_u64vec3();
        usize::try_from((i.z * d.y + i.y) * d.x + i.x).unwrap_or(usize::MAX)
    }

    /// Distance between neighbouring voxel centres along each index axis, in world units.
    #[must_use]
    pub fn spacing(&self) -> DVec3 {
        let m = self.world_from_index.matrix3;
        DVec3::new(m.x_axis.length(), m.y_axis.length(), m.z_axis.length())
    }

    /// Texture coordinates ([0, 1] over the whole box, voxels being cells) to world.
    #[must_use]
    pub fn world_from_texture(&self) -> DAffine3 {
        let index_from_texture = DAffine3::from_mat3_translation(
            DMat3::from_diagonal(self.dims.as_dvec3()),
            DVec3::splat(-0.5),
        );
        self.world_from_index * index_from_texture
    }

    /// World position of the box's centre.
    #[must_use]
    pub fn centre(&self) -> DVec3 {
        self.world_from_texture()
            .transform_point3(DVec3::splat(0.5))
    }

    /// The eight corners of the box (half a voxel beyond the outer voxel centres), in world units.
    #[must_use]
    pub fn corners(&self) -> [DVec3; 8] {
        let m = self.world_from_texture();
        std::array::from_fn(|i| {
            let uvw = DVec3::new((i & 1) as f64, ((i >> 1) & 1) as f64, (i >> 2) as f64);
            m.transform_point3(uvw)
        })
    }

    /// Smallest axis-aligned world box (min, max) around the volume.
    #[must_use]
    pub fn world_bounds(&self) -> (DVec3, DVec3) {
        self.corners().into_iter().fold(
            (DVec3::splat(f64::INFINITY), DVec3::splat(f64::NEG_INFINITY)),
            |(lo, hi), c| (lo.min(c), hi.max(c)),
        )
    }

    /// Length of the box's longest space diagonal, in world units.
    #[must_use]
    pub fn diagonal(&self) -> f64 {
        let c = self.corners();
        (0..4).map(|i| c[i].distance(c[7 - i])).fold(0.0, f64::max)
    }
}
