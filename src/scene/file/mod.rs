//! Scene files: TOML in, a resolved [`Scene`](super::Scene) out.
//!
//! The text is parsed, overrides are applied, keys are compared with the schema, values with their
//! ranges; then the volume is read and whatever was left open is chosen. Every error names file,
//! line, column and key, what was found and what was expected.

mod check_medium;
mod check_technique;
mod color;
mod describe;
mod error;
mod height_field;
mod keys;
mod load;
mod overrides;
mod resolve;
mod resolve_technique;
mod spec;
mod spec_medium;
mod spec_technique;
mod steps;
mod validate;
mod wording;

pub use color::Rgb;
pub use describe::describe;
pub use error::SceneError;
pub use height_field::{HeightFieldSpec, HeightFormulaSpec, MapFileSpec};
pub use load::SceneFile;
pub use overrides::Override;
pub use resolve::Progress;
pub use spec::{
    BoxSpec, CameraSpec, ClipSpec, ColorSpace, DirectionalSpec, Endian, EnvironmentSpec,
    ExposureSpec, ImageSpec, LightSpec, ProceduralSpec, SceneSpec, TransferFunctionSpec,
    VolumeSpec,
};
pub use spec_medium::{MediumSpec, OctaveSpec, PerturbationSpec, PrimitiveSpec};
pub use spec_technique::{RayMarchSpec, ShadingSpec, TechniqueSpec};

/// The JSON Schema of scene files, also published as `assets/scene.schema.json`.
#[must_use]
pub fn schema() -> serde_json::Value {
    schemars::schema_for!(SceneSpec).to_value()
}
