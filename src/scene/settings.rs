//! Image settings and technique parameters.

use std::sync::Arc;

use glam::Vec3;
use serde::{Deserialize, Serialize};

use crate::volume::Grid;

/// How linear radiance is brought to the display's range, after exposure.
#[derive(
    Clone,
    Copy,
    Debug,
    Default,
    PartialEq,
    Eq,
    Serialize,
    Deserialize,
    schemars::JsonSchema,
    clap::ValueEnum,
)]
#[serde(rename_all = "snake_case")]
pub enum ToneMap {
    /// Clamp to [0, 1].
    #[default]
    Clamp,
    /// `x / (1 + x)` on luminance `[Reinhard2002, Eq. 3]`.
    Reinhard,
    /// A filmic curve with toe and shoulder (Narkowicz's fit of ACES).
    Filmic,
}

impl ToneMap {
    /// The name used in scene files, on the command line and in metadata.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Clamp => "clamp",
            Self::Reinhard => "reinhard",
            Self::Filmic => "filmic",
        }
    }
}

/// Factor on radiance before the tone map.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Exposure {
    /// Brings the 99th percentile of the covered pixels' luminance to 0.8.
    #[default]
    Auto,
    /// `2^stops`.
    Stops(f32),
}

/// Size and look of the image.
#[derive(Clone, Debug, PartialEq)]
pub struct ImageSettings {
    /// Pixels across, 1 to 16384.
    pub width: u32,
    /// Pixels down, 1 to 16384.
    pub height: u32,
    /// Rays a pixel are `samples_per_axis`^2, on a regular grid about its centre; 1 to 16.
    pub samples_per_axis: u32,
    /// Radiance behind the volume, linear RGB.
    pub background: Vec3,
    /// Exposure of the PNG.
    pub exposure: Exposure,
    /// Tone map of the PNG.
    pub tone_map: ToneMap,
}

impl Default for ImageSettings {
    fn default() -> Self {
        Self {
            width: 768,
            height: 768,
            samples_per_axis: 1,
            background: Vec3::ZERO,
            exposure: Exposure::Auto,
            tone_map: ToneMap::Clamp,
        }
    }
}

/// Gradient shading of the emission-absorption model (Blinn-Phong).
///
/// `L = colour (ambient L_env + diffuse E / pi max(0, n.l)) + specular E / pi max(0, n.h)^shininess`
/// with E the light's irradiance at the sample, `L_env` the environment's radiance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shading {
    /// Share of the environment's radiance, >= 0.
    pub ambient: f32,
    /// Diffuse reflectance factor, >= 0.
    pub diffuse: f32,
    /// Specular factor, >= 0.
    pub specular: f32,
    /// Blinn-Phong exponent, in [1, 1000].
    pub shininess: f32,
    /// Opacity, in [0, 1], that neighbouring samples gather under one gradient; 0: each has its own.
    pub merge_opacity: f32,
}

impl Default for Shading {
    fn default() -> Self {
        Self {
            ambient: 1.0,
            diffuse: 0.9,
            specular: 0.2,
            shininess: 20.0,
            merge_opacity: 1.0 / 64.0,
        }
    }
}

/// Parameters of `ray_march`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayMarchParams {
    /// Largest distance between samples, in voxels (of the smallest spacing), in [1/64, 64].
    pub step: f64,
    /// `None`: the colour is source radiance (emission-absorption, `[Max1995]`); `Some`: it is lit.
    pub shading: Option<Shading>,
    /// A ray ends once its opacity reaches this, in (0, 1]; 1 switches it off.
    pub early_termination: f64,
    /// Skip cells that the transfer function makes empty.
    pub empty_space_skipping: bool,
}

impl Default for RayMarchParams {
    fn default() -> Self {
        Self {
            step: 0.5,
            shading: Some(Shading::default()),
            early_termination: 0.98,
            empty_space_skipping: true,
        }
    }
}

/// Parameters of `path_trace`. It ends at the first of the goals that it reaches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathTraceParams {
    /// Samples a pixel, at most; in [1, 1048576].
    pub samples: u32,
    /// Seconds after which it ends, > 0.
    pub seconds: Option<f64>,
    /// Root mean square of the pixels' standard errors, relative to the image's mean radiance, at
    /// which it ends, > 0.
    pub target_error: Option<f64>,
    /// Most scattering events a path may have; `None`: no limit.
    pub max_scatter: Option<u32>,
    /// Chooses the random numbers.
    pub seed: u32,
}

impl Default for PathTraceParams {
    fn default() -> Self {
        Self {
            samples: 64,
            seconds: None,
            target_error: None,
            max_scatter: None,
            seed: 0,
        }
    }
}

/// How densely the depths to the lights are kept.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum LightCache {
    /// A node a voxel.
    Full,
    /// A node every two voxels.
    #[default]
    Half,
    /// None: a shadow ray for every sample.
    None,
}

/// Parameters of `single_scatter`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SingleScatterParams {
    /// Largest distance between samples, in voxels (of the smallest spacing), in [1/64, 64].
    pub step: f64,
    /// The same along shadow rays.
    pub shadow_step: f64,
    /// How densely the depths to the lights are kept.
    pub cache: LightCache,
    /// A ray ends once its opacity reaches this, in (0, 1]; 1 switches it off.
    pub early_termination: f64,
    /// Skip cells that the transfer function makes empty.
    pub empty_space_skipping: bool,
}

impl Default for SingleScatterParams {
    fn default() -> Self {
        Self {
            step: 0.5,
            shadow_step: 1.0,
            cache: LightCache::Half,
            early_termination: 0.999,
            empty_space_skipping: true,
        }
    }
}

/// A distance within the volume.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Radius {
    /// What suits the scene; the technique says how it chooses.
    #[default]
    Auto,
    /// In voxels (of the smallest spacing), > 0.
    Voxels(f64),
    /// In world units, > 0.
    World(f64),
}

impl Radius {
    /// World units within a grid, at most half its longest side; none where it is automatic.
    #[must_use]
    pub fn given(self, grid: &Grid) -> Option<f64> {
        let radius = match self {
            Self::Auto => return None,
            Self::Voxels(voxels) => voxels * grid.spacing().min_element(),
            Self::World(world) => world,
        };
        Some(Self::within(grid, radius))
    }

    /// A radius in world units, or half the grid's longest side where that is less.
    #[must_use]
    pub fn within(grid: &Grid, radius: f64) -> f64 {
        let size = grid.spacing() * grid.dims.as_dvec3();
        radius.min(0.5 * size.max_element())
    }
}

/// Parameters of `ambient_occlusion`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AmbientOcclusionParams {
    /// Largest distance between samples, in voxels (of the smallest spacing), in [1/64, 64].
    pub step: f64,
    /// Radius within which the medium dims the environment's light; automatic: 14 voxels.
    pub radius: Radius,
    /// A ray ends once its opacity reaches this, in (0, 1]; 1 switches it off.
    pub early_termination: f64,
    /// Skip cells that the transfer function makes empty.
    pub empty_space_skipping: bool,
}

impl Default for AmbientOcclusionParams {
    fn default() -> Self {
        Self {
            step: 0.5,
            radius: Radius::Auto,
            early_termination: 0.98,
            empty_space_skipping: true,
        }
    }
}

/// How light is dimmed along a tube of `ambient_scattering`.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum Tube {
    /// By the share of a front's power that leaves a slab of the same depth on its far side.
    #[default]
    Slab,
    /// By the table at theta = 0 over its value in vacuum.
    Normalized,
    /// By the table at theta = 0, as printed `[Ament2013, Eq. 16]`.
    Literal,
}

/// How densely `ambient_scattering` keeps the light that arrives.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum RadianceCache {
    /// As `Half`, or a node every third of a radius where that is farther, but no farther than two mean free paths.
    #[default]
    Auto,
    /// A node every two voxels.
    Half,
    /// A node a voxel.
    Full,
    /// None: a tube for every look at the light.
    None,
}

/// How `ambient_scattering` gathers light along a camera ray.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum Gather {
    /// Light that comes straight from the source, light dimmed and spread on its way, and the table's
    /// light that was scattered about the sample: each with its own phase and attenuation.
    #[default]
    Split,
    /// The table alone, attenuated from the sphere's near side on `[Ament2013, Eq. 20]`.
    Literal,
}

/// Parameters of `ambient_scattering`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AmbientScatteringParams {
    /// Largest distance between samples, in voxels (of the smallest spacing), in [1/64, 64].
    pub step: f64,
    /// Radius of the sphere about a sample within which light is scattered.
    pub radius: Radius,
    /// How light is dimmed on its way to the sphere.
    pub tube: Tube,
    /// How light is gathered along a camera ray.
    pub gather: Gather,
    /// How densely the light that arrives is kept.
    pub cache: RadianceCache,
    /// Factor of highlights where the gradient mirrors a light, >= 0; 0: none are looked for.
    pub specular: f32,
    /// Blinn-Phong exponent of the highlights, in [1, 1000].
    pub shininess: f32,
    /// Radius of ambient occlusion, by which environments light the medium.
    pub occlusion_radius: Radius,
    /// A ray ends once its opacity reaches this, in (0, 1]; 1 switches it off.
    pub early_termination: f64,
    /// Skip cells that the transfer function makes empty.
    pub empty_space_skipping: bool,
}

impl Default for AmbientScatteringParams {
    fn default() -> Self {
        Self {
            step: 0.5,
            radius: Radius::Auto,
            tube: Tube::Slab,
            gather: Gather::Split,
            cache: RadianceCache::Auto,
            specular: 0.0,
            shininess: 20.0,
            occlusion_radius: Radius::Auto,
            early_termination: 0.98,
            empty_space_skipping: true,
        }
    }
}

/// What of the light `half_angle` computes.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum Lighting {
    /// None: the colour is source radiance, as in emission-absorption.
    None,
    /// Gradient shading without shadows.
    Surface,
    /// Light that comes straight from the source and is scattered once.
    Direct,
    /// Light that was scattered on its way, too.
    #[default]
    Indirect,
}

/// What scattered light becomes on its way in `half_angle` `[Kniss2003, Eq. 8]`.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum TransportColor {
    /// By the albedo of every sample.
    #[default]
    Auto,
    /// By data value: rows of value and of the share of scattered light, linear RGB in [0, 1], that is left
    /// after a mean free path, ascending in value.
    Points(Arc<[[f64; 4]]>),
}

/// Which samples `half_angle` shades as surfaces `[Kniss2003, Eq. 11]`.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum SurfaceShading {
    /// None: all scatter by the phase function.
    #[default]
    None,
    /// Those where the data's gradient is steep.
    Gradient,
}

/// Parameters of `half_angle`.
#[derive(Clone, Debug, PartialEq)]
pub struct HalfAngleParams {
    /// Distance between slices, in voxels (of the smallest spacing, at most a 64th of the longest side), in
    /// [1/64, 64].
    pub slice_spacing: f64,
    /// Texels along the longer side of a light buffer, in [1, 8192]; `None`: one a voxel, within 64 and 512.
    pub light_buffer: Option<u32>,
    /// What of the light is computed.
    pub lighting: Lighting,
    /// What scattered light becomes on its way.
    pub transport_color: TransportColor,
    /// Full angle of the cone that scattered light spreads into, degrees, in [0, 170].
    pub blur_angle_deg: f64,
    /// Looks at a light buffer that the spread is made of: 4, 8 or 16.
    pub blur_samples: u32,
    /// Phase function of direct light by the cosine, from -1 to 1 in equal steps, RGB, in place of
    /// Henyey and Greenstein's; only ratios count.
    pub phase_table: Option<Arc<[[f64; 3]]>>,
    /// Which samples are shaded as surfaces.
    pub surface: SurfaceShading,
    /// Gradient, in shares of the data range a voxel, from which on a sample is all surface, > 0.
    pub surface_gradient: f64,
    /// Factor of a surface's highlights, >= 0.
    pub specular: f32,
    /// Blinn-Phong exponent of the highlights, in [1, 1000].
    pub shininess: f32,
    /// A ray seen from the front ends once its opacity reaches this, in (0, 1]; 1 switches it off.
    pub early_termination: f64,
    /// Skip cells that the transfer function makes empty.
    pub empty_space_skipping: bool,
}

impl Default for HalfAngleParams {
    fn default() -> Self {
        Self {
            slice_spacing: 1.0,
            light_buffer: None,
            lighting: Lighting::Indirect,
            transport_color: TransportColor::Auto,
            blur_angle_deg: 60.0,
            blur_samples: 4,
            phase_table: None,
            surface: SurfaceShading::None,
            surface_gradient: 0.1,
            specular: 0.2,
            shininess: 20.0,
            early_termination: 0.999,
            empty_space_skipping: true,
        }
    }
}

/// The technique and its parameters.
#[derive(Clone, Debug, PartialEq)]
pub enum TechniqueParams {
    /// Emission-absorption and gradient shading.
    RayMarch(RayMarchParams),
    /// The unbiased reference: multiple scattering.
    PathTrace(PathTraceParams),
    /// Single scattering with shadows.
    SingleScatter(SingleScatterParams),
    /// Light from all around, dimmed by what is near.
    AmbientOcclusion(AmbientOcclusionParams),
    /// Multiple scattering near every sample, from a table.
    AmbientScattering(AmbientScatteringParams),
    /// Light propagated slice by slice, half way between light and view.
    HalfAngle(HalfAngleParams),
}

impl TechniqueParams {
    /// The technique's name everywhere.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        match self {
            Self::RayMarch(_) => "ray_march",
            Self::PathTrace(_) => "path_trace",
            Self::SingleScatter(_) => "single_scatter",
            Self::AmbientOcclusion(_) => "ambient_occlusion",
            Self::AmbientScattering(_) => "ambient_scattering",
            Self::HalfAngle(_) => "half_angle",
        }
    }

    /// Whether the image depends on the scene's lights.
    #[must_use]
    pub const fn uses_lights(&self) -> bool {
        match self {
            Self::RayMarch(p) => p.shading.is_some(),
            Self::HalfAngle(p) => !matches!(p.lighting, Lighting::None),
            Self::PathTrace(_)
            | Self::SingleScatter(_)
            | Self::AmbientOcclusion(_)
            | Self::AmbientScattering(_) => true,
        }
    }
}
