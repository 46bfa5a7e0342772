//! What stages depend on, and what changed between two scenes.

use std::sync::Arc;

use serde::{Serialize, Serializer};

use crate::scene::Scene;

/// A part of the scene that can change on its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Input {
    /// Voxels or their place in the world.
    Volume,
    /// Colour, opacity, density scale and noise.
    TransferFunction,
    /// Phase function, albedo and emission.
    Phase,
    /// Light sources.
    Light,
    /// The camera.
    Camera,
    /// Clip box and plane.
    Clip,
    /// Size, samples and background of the image.
    Image,
    /// The technique's parameters.
    Parameters,
}

impl Input {
    /// All inputs.
    pub const ALL: [Self; 8] = [
        Self::Volume,
        Self::TransferFunction,
        Self::Phase,
        Self::Light,
        Self::Camera,
        Self::Clip,
        Self::Image,
        Self::Parameters,
    ];
}

/// A set of [`Input`]s.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Inputs(u16);

impl Inputs {
    /// No input.
    pub const NONE: Self = Self(0);
    /// Every input.
    pub const ALL: Self = Self((1 << Input::ALL.len()) - 1);

    /// The set of the given inputs.
    #[must_use]
    pub const fn of(inputs: &[Input]) -> Self {
        let mut bits = 0;
        let mut i = 0;
        while i < inputs.len() {
            bits |= 1 << inputs[i] as u16;
            i += 1;
        }
        Self(bits)
    }

    /// Whether the two sets share an input.
    #[must_use]
    pub const fn intersects(self, other: Self) -> bool {
        self.0 & other.0 != 0
    }

    /// Whether `input` is in the set.
    #[must_use]
    pub const fn contains(self, input: Input) -> bool {
        self.0 & (1 << input as u16) != 0
    }

    /// The inputs of either set.
    #[must_use]
    pub const fn union(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// The inputs in order of declaration.
    pub fn iter(self) -> impl Iterator<Item = Input> {
        Input::ALL.into_iter().filter(move |i| self.contains(*i))
    }

    /// What differs between two scenes. Volumes are compared by identity, not by voxel.
    #[must_use]
    pub fn changed(old: &Scene, new: &Scene) -> Self {
        let (a, b) = (&old.medium, &new.medium);
        let image = |s: &Scene| {
            (
                s.image.width,
                s.image.height,
                s.image.samples_per_axis,
                s.image.background,
            )
        };
        let colors = |s: &Scene| s.medium.albedo_volume.as_ref().map(Arc::as_ptr);
        let differs = [
            (
                Input::Volume,
                !Arc::ptr_eq(&old.volume, &new.volume) || colors(old) != colors(new),
            ),
            (
                Input::TransferFunction,
                a.transfer_function.points != b.transfer_function.points
                    || a.transfer_function.primitives != b.transfer_function.primitives
                    || a.transfer_function.quantity != b.transfer_function.quantity
                    || a.transfer_function.opacity_unit_distance
                        != b.transfer_function.opacity_unit_distance
                    || a.density_scale != b.density_scale
                    || a.perturbation != b.perturbation,
            ),
            (
                Input::Phase,
                (a.phase_g, a.albedo, a.emission) != (b.phase_g, b.albedo, b.emission),
            ),
            (Input::Light, old.lights != new.lights),
            (Input::Camera, old.camera != new.camera),
            (Input::Clip, old.clip != new.clip),
            (Input::Image, image(old) != image(new)),
            (Input::Parameters, old.technique != new.technique),
        ];
        let changed: Vec<_> = differs.into_iter().filter(|d| d.1).map(|d| d.0).collect();
        Self::of(&changed)
    }
}

impl Serialize for Inputs {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.iter())
    }
}
