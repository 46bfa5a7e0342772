//! What `ambient_occlusion` does for a scene.

use glam::UVec3;

use super::{NAME, layout};
use crate::gpu::{Limits, Specialization, StageLayout};
use crate::scene::{AmbientOcclusionParams, Light, Scene};
use crate::technique::albedo_volume::AlbedoPlan;
use crate::technique::medium::MediumPlan;
use crate::technique::summed_area::{FieldKind, FieldPlan, occlusion_radius};
use crate::technique::{
    Input, Inputs, Omission, Plan, PlanError, StagePlan, Tiles, lights, target,
};

/// Stage names of the technique.
pub mod stage {
    /// The radiance of every pixel, the volume read through the device's filter.
    pub const MARCH: &str = "ambient_occlusion.march";
    /// The same by loads of 8-bit texels.
    pub const MARCH_R8: &str = "ambient_occlusion.march_r8";
    /// The same by loads of 16-bit texels.
    pub const MARCH_R16: &str = "ambient_occlusion.march_r16";
    /// The same by loads of float texels.
    pub const MARCH_R32F: &str = "ambient_occlusion.march_r32f";
    /// Transfer of the albedo volume.
    pub const UPLOAD_ALBEDO: &str = "ambient_occlusion.upload_albedo";
    /// Copy of the image to the host.
    pub const READ_BACK: &str = "ambient_occlusion.read_back";
}

/// Constants of `ambient_occlusion.march`, in the order of their ids.
pub const CONSTANTS: [Specialization; 8] = [
    Specialization::new(0, "SKIP_EMPTY"),
    Specialization::new(1, "MASKED"),
    Specialization::new(2, "CLIP_BOX"),
    Specialization::new(3, "CLIP_PLANE"),
    Specialization::new(4, "SPREAD"),
    Specialization::new(5, "ENVIRONMENT"),
    Specialization::new(6, "EMISSION"),
    Specialization::new(7, "ALBEDO_VOLUME"),
];

/// Samples on a ray: lavapipe silently stops a shader after 65,535 loop rounds, of which a sample takes less
/// than two with its looks at cells.
const MAX_RAY: f64 = 30_000.0;

/// Pure data: everything decided for one scene.
#[derive(Clone, Debug, PartialEq)]
pub struct AmbientOcclusionPlan {
    /// The medium's part.
    pub medium: MediumPlan,
    /// The occlusion of every cell; none without environment.
    pub occlusion: Option<FieldPlan>,
    /// Constants of `ambient_occlusion.march`.
    pub constants: Vec<Specialization>,
    pub(super) albedo: AlbedoPlan,
    /// Image width and height.
    pub image: [u32; 2],
    /// How the image is marched.
    pub tiles: Tiles,
    omitted: Vec<Omission>,
}

/// Plans the technique for a scene.
///
/// # Errors
/// The scene exceeds a limit of the device or the shader.
pub fn plan(
    scene: &Scene,
    params: &AmbientOcclusionParams,
    limits: &Limits,
) -> Result<AmbientOcclusionPlan, PlanError> {
    let image = &scene.image;
    target::check(image, limits)?;
    let no_skipping = (!params.empty_space_skipping).then_some("empty_space_skipping is off");
    let medium = MediumPlan::new(scene, no_skipping, limits)?;
    let radius = occlusion_radius(scene, params.radius);
    let environment = lights::mean_environment(&scene.lights).max_element() > 0.0;
    let occlusion = environment
        .then(|| FieldPlan::new(scene, &medium, FieldKind::Occlusion, radius, limits))
        .transpose()?;
    let samples = longest_ray(scene, params)?;
    let tiles = Tiles::new(image, samples as f64, limits);
    let albedo = AlbedoPlan::new(scene);
    let flag = u32::from;
    let values = [
        flag(medium.cells.is_some()),
        flag(medium.masked),
        flag(scene.clip.bounds.is_some()),
        flag(scene.clip.plane.is_some()),
        limits.worker_threads,
        flag(environment),
        flag(scene.medium.emission > 0.0),
        flag(albedo.is_there),
    ];
    Ok(AmbientOcclusionPlan {
        constants: medium.with_constants(&CONSTANTS, &values),
        occlusion,
        albedo,
        image: [image.width, image.height],
        tiles,
        omitted: omitted(scene, &medium, environment),
        medium,
    })
}

/// Samples on the longest possible camera ray.
fn longest_ray(scene: &Scene, params: &AmbientOcclusionParams) -> Result<u64, PlanError> {
    let samples = (scene.volume.grid.diagonal() / layout::step_length(scene, params)).ceil();
    if samples > MAX_RAY {
        return Err(PlanError::Limit {
            what: "technique.ambient_occlusion.step".to_owned(),
            found: format!("{samples} samples on the longest ray"),
            limit: format!("a ray takes at most {MAX_RAY}"),
            fix: format!(
                "raise the step to at least {:.4}",
                params.step * samples / MAX_RAY
            ),
        });
    }
    Ok(samples.max(1.0) as u64)
}

/// What the scene cannot show, and why.
fn omitted(scene: &Scene, medium: &MediumPlan, environment: bool) -> Vec<Omission> {
    let mut list = medium.omitted();
    let mut omit = |what, left_out: bool, why: &str| {
        if left_out {
            let why = why.to_owned();
            list.push(Omission { what, why });
        }
    };
    let none = "the scene has none";
    omit("clip box", scene.clip.bounds.is_none(), none);
    omit("clip plane", scene.clip.plane.is_none(), none);
    omit(
        "occlusion",
        !environment,
        "no environment shines: the image only shows emission",
    );
    let is_lamp = |l: &Light| matches!(l, Light::Directional { .. } | Light::Point { .. });
    omit(
        "directional and point lights",
        scene.lights.iter().any(is_lamp),
        "ambient_occlusion has none: the image lacks their light, path_trace shows it",
    );
    let is_map = |l: &Light| matches!(l, Light::EnvironmentMap { .. });
    omit(
        "environment maps",
        scene.lights.iter().any(is_map),
        "their mean radiance stands for them: path_trace shows them",
    );
    omit(
        "phase function",
        true,
        "light is taken to come evenly from all around",
    );
    omit("emission", scene.medium.emission <= 0.0, "its factor is 0");
    let no_colors = scene.medium.albedo_volume.is_none();
    omit("albedo volume", no_colors, none);
    list
}

impl AmbientOcclusionPlan {
    /// The stage that marches: the one that reads the volume as the medium holds it.
    #[must_use]
    pub fn march(&self) -> StageLayout {
        layout::march_for(&self.medium)
    }

    /// The plan as shown to the user.
    #[must_use]
    pub fn summary(&self, _scene: &Scene) -> Plan {
        let mut stages = self.medium.stages();
        stages.extend(self.albedo.stage(stage::UPLOAD_ALBEDO));
        stages.extend(self.occlusion.iter().flat_map(FieldPlan::stages));
        let pixels = UVec3::new(self.image[0], self.image[1], 1);
        let last = |name, dispatches, specialization| StagePlan {
            name,
            depends_on: Inputs::of(&Input::ALL),
            domain: pixels,
            dispatches,
            specialization,
        };
        let (name, dispatches) = (
            self.march().shader.name,
            self.tiles.bands() * self.tiles.sub_samples,
        );
        stages.push(last(name, dispatches, self.constants.clone()));
        stages.push(last(stage::READ_BACK, 1, Vec::new()));
        let mut resources = self.medium.resources();
        resources.extend(self.occlusion.iter().flat_map(FieldPlan::resources));
        resources.push(self.albedo.resource());
        resources.extend(target::resources(self.image));
        Plan {
            technique: NAME,
            stages,
            resources,
            omitted: self.omitted.clone(),
        }
    }
}
