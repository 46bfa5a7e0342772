//! What may stand in a scene file. Doc comments become the schema's descriptions.

use schemars::JsonSchema;
use serde::Deserialize;

use super::Rgb;
use super::height_field::HeightFieldSpec;
use super::spec_medium::{MediumSpec, PrimitiveSpec};
use super::spec_technique::TechniqueSpec;
use crate::scene::transfer_function::Preset;
use crate::scene::{Falloff, ToneMap};
use crate::volume::ScalarType;
use crate::volume::procedural::Procedural;

/// A scene. Whatever is left out is chosen to suit the volume.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
#[schemars(title = "Tyndall scene")]
pub struct SceneSpec {
    /// The voxels. Default: the procedural supernova.
    pub volume: VolumeSpec,
    /// Data value to colour and opacity. Default: chosen from the histogram.
    pub transfer_function: TransferFunctionSpec,
    /// Density, albedo and phase function.
    pub medium: MediumSpec,
    /// Light sources. Default: a key light from the camera's upper left and a faint environment.
    pub lights: Option<Vec<LightSpec>>,
    /// Where the image is taken from. Default: a three-quarter view that frames the volume.
    pub camera: CameraSpec,
    /// What is cut away.
    pub clip: ClipSpec,
    /// Size and look of the image.
    pub image: ImageSpec,
    /// The technique and its parameters.
    pub technique: TechniqueSpec,
}

/// The voxels: exactly one of `file`, `procedural` and `height_field`.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct VolumeSpec {
    /// Path of a volume file, relative to the scene file. With `{}` in its name it is a time-dependent
    /// volume: every file with digits in that place is a step, as `flow_{}.vti` for `flow_008.vti`,
    /// `flow_010.vti`, ...; in the order of the numbers, gaps allowed.
    pub file: Option<String>,
    /// Layout of a headerless `file`.
    pub raw: Option<RawSpec>,
    /// Time step of a 4D `file` or of a series of files, from 0 whatever the numbers are.
    pub time: Option<u32>,
    /// A volume from a formula.
    pub procedural: Option<ProceduralSpec>,
    /// A thin layer about a surface, from a map of heights.
    pub height_field: Option<HeightFieldSpec>,
}

/// Everything a headerless file does not say.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RawSpec {
    /// Voxels along x (fastest), y, z.
    pub dims: [u32; 3],
    /// Stored type.
    #[serde(rename = "type")]
    pub scalar_type: ScalarType,
    /// World units between voxel centres. Default: 1.
    pub spacing: Option<[f64; 3]>,
    /// Byte order: `little` (default) or `big`.
    pub endian: Option<Endian>,
    /// Bytes before the first voxel. Default: 0.
    pub skip_bytes: Option<u64>,
}

/// Byte order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[allow(missing_docs, reason = "the words say it")]
pub enum Endian {
    Little,
    Big,
}

/// A volume from a formula, over the world box [-1, 1]^3, z up, values in [0, 1].
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ProceduralSpec {
    /// Which formula.
    pub name: Procedural,
    /// Voxels along each axis, 1 to 1024. Default: 128.
    #[schemars(range(min = 1, max = 1024))]
    pub resolution: Option<u32>,
}

/// Data value to colour and opacity: at most one of `preset`, `file`, `points`, `extinction` and `primitives`.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct TransferFunctionSpec {
    /// A built-in transfer function.
    pub preset: Option<Preset>,
    /// A ParaView colour map (.json) or a Tyndall transfer function (.toml), relative to the scene.
    pub file: Option<String>,
    /// Rows of data value, r, g, b, opacity, ascending in value; opacity in [0, 1].
    pub points: Option<Vec<[f64; 5]>>,
    /// Rows of data value, r, g, b, extinction per world unit, ascending in value: instead of opacities.
    pub extinction: Option<Vec<[f64; 5]>>,
    /// Shapes over data values and gradient magnitudes. Where they overlap their extinctions add up, and the
    /// colour is the mean of theirs weighted by extinction; where there is none the volume is empty.
    pub primitives: Option<Vec<PrimitiveSpec>>,
    /// What the colours of `points`, `extinction` or `primitives` are: `srgb` (default: as picked on a
    /// screen) or `linear`.
    pub color_space: Option<ColorSpace>,
    /// World distance over which the opacity is reached. Default: 1 for `points` and `primitives`.
    pub opacity_unit_distance: Option<f64>,
}

/// Encoding of colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[allow(missing_docs, reason = "the words say it")]
pub enum ColorSpace {
    Srgb,
    Linear,
}

/// A light source: exactly one of its kinds.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct LightSpec {
    /// Parallel light.
    pub directional: Option<DirectionalSpec>,
    /// A point source.
    pub point: Option<PointSpec>,
    /// Light from all around.
    pub environment: Option<EnvironmentSpec>,
}

/// Parallel light.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DirectionalSpec {
    /// The direction the light travels; any length but 0.
    pub direction: [f64; 3],
    /// Irradiance on a plane that faces the light.
    pub irradiance: Rgb,
}

/// A point source.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PointSpec {
    /// World position.
    pub position: [f64; 3],
    /// Radiant intensity: irradiance is intensity / distance^2.
    pub intensity: Rgb,
    /// How it weakens with distance. Default: `inverse_square`.
    #[serde(default)]
    pub falloff: Falloff,
}

/// Light from all around: exactly one of `radiance` and `file`.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct EnvironmentSpec {
    /// The same radiance from everywhere.
    pub radiance: Option<Rgb>,
    /// Path of a picture of the whole sphere in latitude and longitude (OpenEXR or Radiance HDR), relative
    /// to the scene file. Its middle lights what the camera sees of an unturned head: it lies towards -y
    /// where +z is up.
    pub file: Option<String>,
    /// Factor on the radiance of `file`. Default: 1.
    pub scale: Option<Rgb>,
    /// Degrees by which `file` is turned about `up`, counterclockwise from above. Default: 0.
    pub rotation_deg: Option<f64>,
    /// World direction of the top of `file`. Default: +z.
    pub up: Option<[f64; 3]>,
}

/// The camera. `eye` excludes `azimuth_deg`, `elevation_deg` and `zoom`.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct CameraSpec {
    /// World position of the eye.
    pub eye: Option<[f64; 3]>,
    /// World point at the image's centre. Default: the centre of what is visible.
    pub target: Option<[f64; 3]>,
    /// A direction that is up in the image. Default: +z.
    pub up: Option<[f64; 3]>,
    /// Full vertical angle in degrees, in (0, 180). Default: 30.
    pub vfov_deg: Option<f64>,
    /// Parallel projection instead: full vertical extent in world units.
    pub orthographic_height: Option<f64>,
    /// Degrees from the front towards the image's right. Default: 30.
    pub azimuth_deg: Option<f64>,
    /// Degrees above the horizon, in [-90, 90]. Default: 15.
    #[schemars(range(min = -90, max = 90))]
    pub elevation_deg: Option<f64>,
    /// Magnification over the automatic frame, > 0. Default: 1.
    pub zoom: Option<f64>,
}

/// What is cut away: outside the box and behind the plane is vacuum.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ClipSpec {
    /// World-axis-aligned box that is kept.
    #[serde(rename = "box")]
    pub bounds: Option<BoxSpec>,
    /// A plane whose front side is kept.
    pub plane: Option<PlaneSpec>,
}

/// A box in world units.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BoxSpec {
    /// Lower corner.
    pub min: [f64; 3],
    /// Upper corner, above `min` on every axis.
    pub max: [f64; 3],
}

/// A plane in world units.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PlaneSpec {
    /// A point on the plane.
    pub point: [f64; 3],
    /// Points into the kept side; any length but 0.
    pub normal: [f64; 3],
}

/// Size and look of the image.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ImageSpec {
    /// Pixels across, 1 to 16384. Default: 768.
    #[schemars(range(min = 1, max = 16384))]
    pub width: Option<u32>,
    /// Pixels down, 1 to 16384. Default: 768.
    #[schemars(range(min = 1, max = 16384))]
    pub height: Option<u32>,
    /// Rays a pixel along each axis, 1 to 16. Default: 1.
    #[schemars(range(min = 1, max = 16))]
    pub samples_per_axis: Option<u32>,
    /// Radiance behind the volume. Default: 0.
    pub background: Option<Rgb>,
    /// `auto` (default), or stops: radiance is multiplied by 2^stops.
    pub exposure: Option<ExposureSpec>,
    /// Tone map of the PNG. Default: `clamp`.
    pub tone_map: Option<ToneMap>,
}

/// `auto` or a number of stops.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "`auto` or a number of stops")]
#[allow(missing_docs, reason = "the words say it")]
pub enum ExposureSpec {
    Stops(f32),
    Word(AutoWord),
}

/// The word `auto`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[allow(missing_docs, reason = "the word says it")]
pub enum AutoWord {
    Auto,
}
