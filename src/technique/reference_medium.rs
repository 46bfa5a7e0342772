//! The medium as the CPU references see it, in f64: no table, no cells.

use glam::{DAffine3, DVec3};

use crate::scene::Scene;

/// The medium of a scene at any place.
pub(super) struct ReferenceMedium<'a> {
    scene: &'a Scene,
    index_from_world: DAffine3,
}

impl<'a> ReferenceMedium<'a> {
    pub(super) fn new(scene: &'a Scene) -> Self {
        Self {
            scene,
            index_from_world: scene.volume.grid.world_from_index.inverse(),
        }
    }

    /// Grid coordinates of a world position.
    pub(super) fn index(&self, x: DVec3) -> DVec3 {
        self.index_from_world.transform_point3(x)
    }

    /// Colour, and extinction per world unit, at grid coordinates; nothing where the volume is not finite.
    pub(super) fn material(&self, q: DVec3) -> (DVec3, f64) {
        let m = &self.scene.medium;
        let function = &m.transfer_function;
        let gradient = if function.has_gradients() {
            self.gradient_magnitude(q)
        } else {
            0.0
        };
        let (color, sigma_t) = function.material(self.value(q), gradient);
        (color.as_dvec3(), sigma_t * m.density_scale)
    }

    /// Extinction per world unit at grid coordinates.
    pub(super) fn sigma_t(&self, q: DVec3) -> f64 {
        self.material(q).1
    }

    /// Albedo over the medium's factor, where the colour is `color`.
    pub(super) fn albedo(&self, q: DVec3, color: DVec3) -> DVec3 {
        let colors = self.scene.medium.albedo_volume.as_ref();
        colors.map_or(color, |c| c.sample_index(q))
    }

    /// Differences between one voxel ahead and one behind, clamped at the faces.
    pub(super) fn differences(&self, q: DVec3) -> DVec3 {
        let (behind, ahead) = self.beside(q);
        let along = |axis: usize| {
            let (mut a, mut b) = (q, q);
            (a[axis], b[axis]) = (behind[axis], ahead[axis]);
            self.value(b) - self.value(a)
        };
        DVec3::new(along(0), along(1), along(2))
    }

    /// World direction of differences along the grid's axes, as long as the gradient a voxel of 1.
    pub(super) fn world_direction(&self, differences: DVec3) -> DVec3 {
        self.index_from_world.matrix3.transpose() * differences
    }

    /// NaN where the volume is not finite.
    fn value(&self, q: DVec3) -> f64 {
        let value = self.scene.volume.sample_index(q);
        if value.is_finite() { value } else { f64::NAN }
    }

    /// One voxel behind and ahead.
    fn beside(&self, q: DVec3) -> (DVec3, DVec3) {
        let last = self.scene.volume.grid.dims.as_dvec3() - 1.0;
        let q = q.clamp(DVec3::ZERO, last);
        ((q - 1.0).max(DVec3::ZERO), (q + 1.0).min(last))
    }

    fn gradient_magnitude(&self, q: DVec3) -> f64 {
        let (behind, ahead) = self.beside(q);
        let across = (ahead - behind).max(DVec3::splat(1e-6));
        self.world_direction(self.differences(q) / across).length()
    }
}
