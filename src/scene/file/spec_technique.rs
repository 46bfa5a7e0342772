//! What may stand under `technique` in a scene file. Doc comments become the schema's descriptions.

use schemars::JsonSchema;
use serde::Deserialize;

use super::spec::AutoWord;
use crate::scene::{Gather, LightCache, Lighting, RadianceCache, SurfaceShading, Tube};

/// The technique and its parameters.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct TechniqueSpec {
    /// Which technique renders. Default: `ray_march`.
    pub name: Option<TechniqueName>,
    /// Parameters of `ray_march`.
    pub ray_march: RayMarchSpec,
    /// Parameters of `path_trace`.
    pub path_trace: PathTraceSpec,
    /// Parameters of `single_scatter`.
    pub single_scatter: SingleScatterSpec,
    /// Parameters of `ambient_occlusion`.
    pub ambient_occlusion: AmbientOcclusionSpec,
    /// Parameters of `ambient_scattering`.
    pub ambient_scattering: AmbientScatteringSpec,
    /// Parameters of `half_angle`.
    pub half_angle: HalfAngleSpec,
}

/// The techniques.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[allow(missing_docs, reason = "the words say it")]
pub enum TechniqueName {
    RayMarch,
    PathTrace,
    SingleScatter,
    AmbientOcclusion,
    AmbientScattering,
    HalfAngle,
}

/// Emission-absorption and gradient shading.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct RayMarchSpec {
    /// Largest distance between samples in voxels of the smallest spacing, in [1/64, 64]. Default: 0.5.
    #[schemars(range(min = 0.015625, max = 64))]
    pub step: Option<f64>,
    /// `false`: the colour is source radiance; `true` (default): it is lit; or the factors.
    pub shading: Option<ShadingSpec>,
    /// A ray ends once its opacity reaches this, in (0, 1]; 1 switches it off. Default: 0.98.
    pub early_termination: Option<f64>,
    /// Skip cells that the transfer function makes empty. Default: true.
    pub empty_space_skipping: Option<bool>,
}

/// The unbiased reference: multiple scattering along random paths.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct PathTraceSpec {
    /// Samples a pixel, at most, 1 to 1048576. Default: 64, or no other limit than the ones below.
    #[schemars(range(min = 1, max = 1_048_576))]
    pub samples: Option<u32>,
    /// Seconds after which it ends.
    pub seconds: Option<f64>,
    /// It ends when the pixels' standard errors (root mean square) are this share of the image's mean
    /// radiance.
    pub target_error: Option<f64>,
    /// Most scattering events a path may have, at least 1; 1 is single scattering. Default: no limit.
    #[schemars(range(min = 1))]
    pub max_scatter: Option<u32>,
    /// Chooses the random numbers. Default: 0.
    pub seed: Option<u32>,
}

/// Single scattering with shadows.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SingleScatterSpec {
    /// Largest distance between samples in voxels of the smallest spacing, in [1/64, 64]. Default: 0.5.
    #[schemars(range(min = 0.015625, max = 64))]
    pub step: Option<f64>,
    /// The same along shadow rays. Default: 1.
    #[schemars(range(min = 0.015625, max = 64))]
    pub shadow_step: Option<f64>,
    /// How densely the depths to the lights are kept: `full`, a node a voxel; `half` (default), one every
    /// two voxels; `none`: a shadow ray for every sample.
    pub cache: Option<LightCache>,
    /// A ray ends once its opacity reaches this, in (0, 1]; 1 switches it off. Default: 0.999.
    pub early_termination: Option<f64>,
    /// Skip cells that the transfer function makes empty. Default: true.
    pub empty_space_skipping: Option<bool>,
}

/// Light from all around, dimmed by what is near.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct AmbientOcclusionSpec {
    /// Largest distance between samples in voxels of the smallest spacing, in [1/64, 64]. Default: 0.5.
    #[schemars(range(min = 0.015625, max = 64))]
    pub step: Option<f64>,
    /// Radius within which the medium dims the environment's light: `auto` (default, 14 voxels), voxels, or a
    /// table `{ world = 2.5 }`; at most half the volume's longest side is looked at.
    pub radius: Option<RadiusSpec>,
    /// A ray ends once its opacity reaches this, in (0, 1]; 1 switches it off. Default: 0.98.
    pub early_termination: Option<f64>,
    /// Skip cells that the transfer function makes empty. Default: true.
    pub empty_space_skipping: Option<bool>,
}

/// Multiple scattering near every sample, from a table.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct AmbientScatteringSpec {
    /// Largest distance between samples in voxels of the smallest spacing, in [1/64, 64]. Default: 0.5.
    #[schemars(range(min = 0.015625, max = 64))]
    pub step: Option<f64>,
    /// Radius of the sphere about a sample within which light is scattered: `auto` (default, one mean
    /// free path within a voxel and a sixteenth of the volume), voxels, or a table `{ world = 2.5 }`.
    pub radius: Option<RadiusSpec>,
    /// How light is dimmed on its way: `slab` (default), `normalized`, or `literal`, the paper's.
    pub tube: Option<Tube>,
    /// How light is gathered along a camera ray: `split` (default), or `literal`, the paper's.
    pub gather: Option<Gather>,
    /// How densely the light that arrives is kept: `full`, a node a voxel; `half`, one every two voxels;
    /// `auto` (default), that or coarser where the radius is wide; `none`: a tube for every look.
    pub cache: Option<RadianceCache>,
    /// Factor of highlights where the gradient mirrors a light, >= 0. Default: 0.
    pub specular: Option<f32>,
    /// Exponent of the highlights, in [1, 1000]. Default: 20.
    #[schemars(range(min = 1, max = 1000))]
    pub shininess: Option<f32>,
    /// Radius of the ambient occlusion by which environments light the medium: `auto` (default, 14
    /// voxels), voxels, or a table `{ world = 2.5 }`.
    pub occlusion_radius: Option<RadiusSpec>,
    /// A ray ends once its opacity reaches this, in (0, 1]; 1 switches it off. Default: 0.98.
    pub early_termination: Option<f64>,
    /// Skip cells that the transfer function makes empty. Default: true.
    pub empty_space_skipping: Option<bool>,
}

/// Light propagated slice by slice, half way between light and view.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct HalfAngleSpec {
    /// Distance between slices in voxels of the smallest spacing, or in 64ths of the volume's longest side where
    /// these are smaller, in [1/64, 64]. Default: 1.
    #[schemars(range(min = 0.015625, max = 64))]
    pub slice_spacing: Option<f64>,
    /// Texels along the longer side of a light buffer, 1 to 8192. Default: one a voxel, 64 to 512.
    #[schemars(range(min = 1, max = 8192))]
    pub light_buffer: Option<u32>,
    /// What of the light is computed: `none` (the colour is source radiance), `surface` (gradient shading
    /// without shadows), `direct`, or `indirect` (default: direct and indirect).
    pub lighting: Option<Lighting>,
    /// What scattered light becomes on its way: `auto` (default: by the colour's albedo), the share of red,
    /// green and blue that is left after a mean free path, in [0, 1], or rows of data value and that share,
    /// ascending in value.
    pub transport_color: Option<TransportSpec>,
    /// Full angle of the cone that scattered light spreads into, in degrees, 0 to 170. Default: 60.
    #[schemars(range(min = 0, max = 170))]
    pub blur_angle_deg: Option<f64>,
    /// Looks at a light buffer that the spread is made of: 4 (default), 8 or 16.
    pub blur_samples: Option<u32>,
    /// Phase function of direct light in place of `medium.phase`: rows of red, green and blue for cosines
    /// from -1 (straight back) to 1 (straight on) in equal steps, 2 to 1024 rows; it is normalised.
    pub phase_table: Option<Vec<[f64; 3]>>,
    /// Which samples are shaded as surfaces: `none` (default), or `gradient`, those where it is steep.
    pub surface: Option<SurfaceShading>,
    /// Gradient, in shares of the data range a voxel, from which on a sample is all surface, > 0.
    /// Default: 0.1.
    pub surface_gradient: Option<f64>,
    /// Factor of a surface's highlights, >= 0. Default: 0.2.
    pub specular: Option<f32>,
    /// Exponent of the highlights, in [1, 1000]. Default: 20.
    #[schemars(range(min = 1, max = 1000))]
    pub shininess: Option<f32>,
    /// A ray seen from the front ends once its opacity reaches this, in (0, 1]; 1 switches it off.
    /// Default: 0.999.
    pub early_termination: Option<f64>,
    /// Skip cells that the transfer function makes empty. Default: true.
    pub empty_space_skipping: Option<bool>,
}

/// `auto`, a colour, or rows of value and colour.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(
    untagged,
    expecting = "`auto`, a colour [r, g, b], or rows [value, r, g, b]"
)]
#[allow(missing_docs, reason = "the words say it")]
pub enum TransportSpec {
    Word(AutoWord),
    Color([f64; 3]),
    Points(Vec<[f64; 4]>),
}

/// `auto`, a number of voxels, or a table of world units.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(
    untagged,
    expecting = "`auto`, a number of voxels, or a table { world = UNITS }"
)]
#[allow(missing_docs, reason = "the words say it")]
pub enum RadiusSpec {
    Voxels(f64),
    Word(AutoWord),
    World(WorldLength),
}

/// A length in world units.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WorldLength {
    /// World units, > 0.
    pub world: f64,
}

/// A switch, or factors of Blinn-Phong shading.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(
    untagged,
    expecting = "true, false, or a table of ambient, diffuse, specular, shininess, merge_opacity"
)]
#[allow(missing_docs, reason = "the words say it")]
pub enum ShadingSpec {
    Switch(bool),
    Factors(ShadingFactors),
}

/// Factors of Blinn-Phong shading.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ShadingFactors {
    /// Share of the environment's radiance, >= 0. Default: 1.
    pub ambient: Option<f32>,
    /// Diffuse reflectance factor, >= 0. Default: 0.9.
    pub diffuse: Option<f32>,
    /// Specular factor, >= 0. Default: 0.2.
    pub specular: Option<f32>,
    /// Exponent, in [1, 1000]. Default: 20.
    #[schemars(range(min = 1, max = 1000))]
    pub shininess: Option<f32>,
    /// Opacity, in [0, 1], that neighbouring samples gather under one gradient: more is faster, 0 gives
    /// each its own. Default: 1/64.
    #[schemars(range(min = 0, max = 1))]
    pub merge_opacity: Option<f32>,
}
