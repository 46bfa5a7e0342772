//! The medium as the CPU references see it, in f64: no table, no cells.

use glam::{DAffine3, DVec3};

use crate::scene::perturbation::{Noise, Perturbed};
use crate::scene::{Perturbation, Scene};

/// The medium of a scene at any place.
pub(super) struct ReferenceMedium<'a> {
    scene: &'a Scene,
    index_from_world: DAffine3,
    noise: Option<(&'a Perturbation, Noise)>,
}

impl<'a> ReferenceMedium<'a> {
    pub(super) fn new(scene: &'a Scene) -> Self {
        Self {
            scene,
            index_from_world: scene.volume.grid.world_from_index.inverse(),
            noise: (scene.medium.perturbation.as_ref()).map(|p| (p, Noise::new(p.seed))),
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
            self.gradient_magnitude(self.looked_up(q))
        } else {
            0.0
        };
        let (color, sigma_t) = function.material(self.value(q), gradient);
        let share = self.scene.volume.share_at(self.looked_up(q));
        let (color, sigma_t) = (color.as_dvec3(), share * sigma_t * m.density_scale);
        self.perturbed(q).map_or((color, sigma_t), |p| {
            (color * p.color, sigma_t * p.extinction)
        })
    }

    /// Extinction per world unit at grid coordinates.
    pub(super) fn sigma_t(&self, q: DVec3) -> f64 {
        self.material(q).1
    }

    /// Albedo over the medium's factor, where the colour is `color`.
    pub(super) fn albedo(&self, q: DVec3, color: DVec3) -> DVec3 {
        let colors = self.scene.medium.albedo_volume.as_ref();
        colors.map_or(color, |c| c.sample_index(self.looked_up(q)))
    }

    /// Differences between one voxel ahead and one behind, clamped at the faces, of the medium as it is seen: of data
    /// values, or of the height above a height field's surface.
    pub(super) fn differences(&self, q: DVec3) -> DVec3 {
        let volume = &self.scene.volume;
        match &volume.height_field {
            Some(field) => {
                let above = |q| field.above(&volume.grid, self.looked_up(q));
                // Slopes are whole at the sides too, and along z nothing ends at the box.
                let (behind, ahead) = self.beside(q);
                let whole = 2.0 / (ahead - behind).max(DVec3::splat(1e-6));
                let differences = whole * self.differences_of(q, above);
                differences.with_z(above(q + DVec3::Z) - above(q - DVec3::Z))
            }
            None => self.differences_of(q, |q| self.value(q)),
        }
    }

    fn differences_of(&self, q: DVec3, value: impl Fn(DVec3) -> f64) -> DVec3 {
        let (behind, ahead) = self.beside(q);
        let along = |axis: usize| {
            let (mut a, mut b) = (q, q);
            (a[axis], b[axis]) = (behind[axis], ahead[axis]);
            value(b) - value(a)
        };
        DVec3::new(along(0), along(1), along(2))
    }

    /// What noise does at grid coordinates.
    fn perturbed(&self, q: DVec3) -> Option<Perturbed> {
        let (perturbation, noise) = self.noise.as_ref()?;
        let x = self.scene.volume.grid.world_from_index.transform_point3(q);
        Some(perturbation.at(noise, x))
    }

    /// Where the medium at grid coordinates is looked up in the volume.
    fn looked_up(&self, q: DVec3) -> DVec3 {
        let index_from_world = self.index_from_world;
        let volume = &self.scene.volume;
        let last = volume.grid.dims.as_dvec3() - 1.0;
        self.perturbed(q).map_or(q, |p| {
            let moved = q + index_from_world.transform_vector3(p.displacement);
            let inside = moved.clamp(DVec3::ZERO, last);
            // A height field's surface is where it is, above and below the box too.
            match &volume.height_field {
                Some(_) => inside.with_z(moved.z),
                None => inside,
            }
        })
    }

    /// World direction of differences along the grid's axes, as long as the gradient a voxel of 1.
    pub(super) fn world_direction(&self, differences: DVec3) -> DVec3 {
        self.index_from_world.matrix3.transpose() * differences
    }

    pub(super) fn value(&self, q: DVec3) -> f64 {
        self.stored(self.looked_up(q))
    }

    /// NaN where the volume is not finite.
    fn stored(&self, q: DVec3) -> f64 {
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
        let differences = self.differences_of(q, |q| self.stored(q));
        self.world_direction(differences / across).length()
    }
}
