//! The scene: what is rendered, from where, under which light. Pure data, no Vulkan.

mod camera;
mod clip;
mod color;
pub mod file;
pub mod framing;
mod lat_long_map;
mod light;
mod medium;
pub mod perturbation;
mod settings;
pub mod transfer_function;

pub use camera::{Camera, Projection};
pub use clip::{Clip, Plane};
pub use color::{linear_from_srgb, srgb_from_linear};
pub use lat_long_map::{LatLongMap, LatLongMapError};
pub use light::{Falloff, Light, world_from_map};
pub use medium::Medium;
pub use perturbation::{Octave, Perturbation};
pub use settings::{
    AmbientOcclusionParams, AmbientScatteringParams, Exposure, Gather, HalfAngleParams,
    ImageSettings, LightCache, Lighting, PathTraceParams, RadianceCache, Radius, RayMarchParams,
    Shading, SingleScatterParams, SurfaceShading, TechniqueParams, ToneMap, TransportColor, Tube,
};
pub use transfer_function::{ControlPoint, TransferFunction};

use std::sync::Arc;

use crate::volume::{Statistics, Volume};

/// Everything a technique needs to know, resolved: no automatic choice is left open.
#[derive(Clone, Debug)]
pub struct Scene {
    /// The voxels.
    pub volume: Arc<Volume>,
    /// Range, histogram and non-finite count of `volume`; in a sequence of time steps, of all of them,
    /// so that they look alike.
    pub statistics: Arc<Statistics>,
    /// How data values become extinction and colour.
    pub medium: Medium,
    /// Light sources.
    pub lights: Vec<Light>,
    /// Where the image is taken from.
    pub camera: Camera,
    /// What is cut away.
    pub clip: Clip,
    /// Size and look of the image.
    pub image: ImageSettings,
    /// The technique and its parameters.
    pub technique: TechniqueParams,
}
