//! What may stand in a scene file of the medium beside numbers of its transfer function.

use schemars::JsonSchema;
use serde::Deserialize;

use super::Rgb;
use super::spec::RawSpec;
use crate::scene::transfer_function::Shape;

/// A shape over data values and gradient magnitudes.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PrimitiveSpec {
    /// `box`: even; `triangle`: from a tip at the middle value and the lowest gradient to all values at the
    /// highest, fading from the middle to the sides; `gaussian`: a bell whose sides are at three standard
    /// deviations.
    pub shape: Shape,
    /// Lowest and highest data value.
    pub value: [f64; 2],
    /// Lowest and highest magnitude of the gradient, data units a world unit. Of a box the highest may be
    /// `inf`. Default: all gradients, for a box.
    pub gradient: Option<[f64; 2]>,
    /// Its colour.
    pub color: [f64; 3],
    /// Its largest opacity, in [0, 1].
    #[schemars(range(min = 0, max = 1))]
    pub opacity: f64,
}

/// Density, albedo and phase function.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct MediumSpec {
    /// Factor on extinction, >= 0. Default: 1.
    #[schemars(range(min = 0))]
    pub density_scale: Option<f64>,
    /// Factor on the colour that gives the scattering albedo, in [0, 1]. Default: 0.9, or 1 beside
    /// `albedo_volume`.
    #[schemars(range(min = 0, max = 1))]
    pub albedo: Option<f64>,
    /// A colour for every voxel that takes the place of the transfer function's in the scattering albedo.
    pub albedo_volume: Option<AlbedoVolumeSpec>,
    /// Factor on the colour that gives the radiance the medium emits, >= 0; not used by `ray_march`, which
    /// takes the whole colour for it. Default: 0.
    #[schemars(range(min = 0))]
    pub emission: Option<f64>,
    /// Noise that moves the places at which the volume is looked up, and varies what is found there.
    pub perturbation: Option<PerturbationSpec>,
    /// The phase function.
    pub phase: PhaseSpec,
}

/// Noise that gives a coarse volume detail: copies, at different scales, of one tile of 32 x 32 x 32 random texels
/// that repeats through the world.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PerturbationSpec {
    /// Chooses the noise. Default: 0.
    pub seed: Option<u32>,
    /// The moment that time step 0 shows; step 1 is a unit of time later. Default: 0.
    pub time: Option<f64>,
    /// The copies, 1 to 8, which add up. At least three make a cloud.
    pub octaves: Vec<OctaveSpec>,
}

/// Noise at one scale.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OctaveSpec {
    /// Texels of the noise a world unit, above 0: its features are about two texels wide.
    pub frequency: f64,
    /// Furthest that places move along each axis of the world, world units. Default: 0.
    #[schemars(range(min = 0))]
    pub displacement: Option<f64>,
    /// Largest change of the extinction, up or down, as a share of it, in [0, 1]; of all octaves together at most
    /// 1. Default: 0.
    #[schemars(range(min = 0, max = 1))]
    pub opacity: Option<f64>,
    /// Largest share by which the transfer function's colour is darkened, in [0, 1]; of all octaves together at
    /// most 1. Default: 0.
    pub color: Option<Rgb>,
    /// Where the noise lies, world units. Default: 0.
    pub offset: Option<[f64; 3]>,
    /// How it moves, world units a unit of time. Default: 0.
    pub velocity: Option<[f64; 3]>,
}

/// A volume of linear RGB colours in [0, 1], with as many voxels as the volume, in the same place.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AlbedoVolumeSpec {
    /// Path of an NRRD file whose first axis holds the 3 colours, or of a headerless file, relative to the
    /// scene file.
    pub file: String,
    /// Layout of a headerless `file`: red, green and blue of a voxel follow one another.
    pub raw: Option<RawSpec>,
}

/// Henyey-Greenstein phase function.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct PhaseSpec {
    /// Mean cosine, in [-0.99, 0.99]; positive is forward. Default: 0.
    #[schemars(range(min = -0.99, max = 0.99))]
    pub g: Option<f64>,
}
