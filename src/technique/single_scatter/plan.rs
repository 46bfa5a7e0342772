//! What `single_scatter` does for a scene.

use glam::UVec3;

use super::cache::{CachePlan, shadow_samples};
use super::{NAME, layout};
use crate::gpu::{Limits, Specialization, StageLayout};
use crate::scene::{Light, LightCache, Scene, SingleScatterParams};
use crate::technique::albedo_volume::AlbedoPlan;
use crate::technique::medium::MediumPlan;
use crate::technique::{
    Input, Inputs, Omission, Plan, PlanError, StagePlan, Tiles, lights, target,
};

/// Stage names of the technique.
pub mod stage {
    /// Depths to the lights, the volume read through the device's filter.
    pub const LIGHT_CACHE: &str = "single_scatter.light_cache";
    /// The same by loads of 8-bit texels.
    pub const LIGHT_CACHE_R8: &str = "single_scatter.light_cache_r8";
    /// The same by loads of 16-bit texels.
    pub const LIGHT_CACHE_R16: &str = "single_scatter.light_cache_r16";
    /// The same by loads of float texels.
    pub const LIGHT_CACHE_R32F: &str = "single_scatter.light_cache_r32f";
    /// The radiance of every pixel, the volume read through the device's filter.
    pub const MARCH: &str = "single_scatter.march";
    /// The same by loads of 8-bit texels.
    pub const MARCH_R8: &str = "single_scatter.march_r8";
    /// The same by loads of 16-bit texels.
    pub const MARCH_R16: &str = "single_scatter.march_r16";
    /// The same by loads of float texels.
    pub const MARCH_R32F: &str = "single_scatter.march_r32f";
    /// Transfer of the albedo volume.
    pub const UPLOAD_ALBEDO: &str = "single_scatter.upload_albedo";
    /// Copy of the image to the host.
    pub const READ_BACK: &str = "single_scatter.read_back";
}

/// Constants of `single_scatter.light_cache`, in the order of their ids; the march has them too.
pub const CACHE_CONSTANTS: [Specialization; 6] = [
    Specialization::new(0, "SKIP_EMPTY"),
    Specialization::new(1, "MASKED"),
    Specialization::new(2, "CLIP_BOX"),
    Specialization::new(3, "CLIP_PLANE"),
    Specialization::new(4, "POINT_LIGHTS"),
    Specialization::new(5, "SPREAD"),
];

/// Constants of `single_scatter.march`, in the order of their ids.
pub const MARCH_CONSTANTS: [Specialization; 11] = [
    CACHE_CONSTANTS[0],
    CACHE_CONSTANTS[1],
    CACHE_CONSTANTS[2],
    CACHE_CONSTANTS[3],
    CACHE_CONSTANTS[4],
    CACHE_CONSTANTS[5],
    Specialization::new(6, "LIGHT_COUNT"),
    Specialization::new(7, "CACHED"),
    Specialization::new(8, "ISOTROPIC"),
    Specialization::new(9, "EMISSION"),
    Specialization::new(10, "ALBEDO_VOLUME"),
];

/// Loop rounds an invocation: lavapipe silently stops a shader after 65,535 in all loops together.
pub(super) const MAX_ROUNDS: f64 = 60_000.0;

/// Samples in a row, as in the shader.
const BLOCK: f64 = 4.0;

/// Pure data: everything decided for one scene.
#[derive(Clone, Debug, PartialEq)]
pub struct SingleScatterPlan {
    /// The medium's part.
    pub medium: MediumPlan,
    /// Constants of `single_scatter.light_cache`.
    pub cache_constants: Vec<Specialization>,
    /// Constants of `single_scatter.march`.
    pub march_constants: Vec<Specialization>,
    /// The light cache; none: shadow rays at each sample, or no light.
    pub cache: Option<CachePlan>,
    pub(super) albedo: AlbedoPlan,
    /// Image width and height.
    pub image: [u32; 2],
    /// How the image is marched.
    pub tiles: Tiles,
    /// Ranges of samples that a ray is split into, one dispatch each, and samples a range.
    pub ranges: [u32; 2],
    omitted: Vec<Omission>,
}

/// Plans the technique for a scene.
///
/// # Errors
/// The scene exceeds a limit of the device or the shader.
pub fn plan(
    scene: &Scene,
    params: &SingleScatterParams,
    limits: &Limits,
) -> Result<SingleScatterPlan, PlanError> {
    let image = &scene.image;
    target::check(image, limits)?;
    let (lights, points) = lights::count(scene, NAME)?;
    let no_skipping = (!params.empty_space_skipping).then_some("empty_space_skipping is off");
    let medium = MediumPlan::new(scene, no_skipping, limits)?;
    let albedo = AlbedoPlan::new(scene);
    let cache = CachePlan::new(scene, params, lights, limits)?;
    // Samples that a shadow ray takes more than a look into the cache.
    let shadow = match params.cache {
        LightCache::None => shadow_samples(scene, params)? as f64,
        _ => 0.0,
    };
    let samples = longest_ray(scene, params)?;
    let range = samples_a_range(samples, f64::from(lights), shadow);
    let a_sample = 1.0 + f64::from(lights) * (1.0 + 1.25 * shadow);
    let tiles = Tiles::new(image, samples + range * a_sample, limits);
    let values = [
        u32::from(medium.cells.is_some()),
        u32::from(medium.masked),
        u32::from(scene.clip.bounds.is_some()),
        u32::from(scene.clip.plane.is_some()),
        u32::from(points),
        limits.worker_threads,
        lights,
        u32::from(cache.is_some()),
        u32::from(scene.medium.phase_g == 0.0),
        u32::from(scene.medium.emission > 0.0),
        u32::from(albedo.is_there),
    ];
    Ok(SingleScatterPlan {
        cache_constants: medium.with_constants(&CACHE_CONSTANTS, &values),
        march_constants: medium.with_constants(&MARCH_CONSTANTS, &values),
        cache,
        albedo,
        image: [image.width, image.height],
        tiles,
        ranges: [(samples / range).ceil() as u32, range as u32],
        omitted: omitted(scene, params, &medium, (lights, points)),
        medium,
    })
}

/// Samples on the longest possible camera ray.
fn longest_ray(scene: &Scene, params: &SingleScatterParams) -> Result<f64, PlanError> {
    let samples = (scene.volume.grid.diagonal() / layout::step_length(scene, params)).ceil();
    // Half of the rounds are for looks at the cells and blocks; the rest are for light.
    if samples > 0.5 * MAX_ROUNDS {
        return Err(PlanError::Limit {
            what: "technique.single_scatter.step".to_owned(),
            found: format!("{samples} samples on the longest ray"),
            limit: format!("a ray takes at most {}", 0.5 * MAX_ROUNDS),
            fix: format!(
                "raise the step to at least {:.4}",
                params.step * samples / (0.5 * MAX_ROUNDS)
            ),
        });
    }
    Ok(samples.max(1.0))
}

/// Samples of a camera ray whose light one invocation can gather within its rounds.
fn samples_a_range(samples: f64, lights: f64, shadow: f64) -> f64 {
    let looks = 1.25 * samples;
    // A block has a round a light; uncached, its five shadow rays have theirs.
    let a_block = lights * (1.0 + (BLOCK + 1.0) * (1.0 + 1.25 * shadow));
    let blocks = ((MAX_ROUNDS - looks) / a_block.max(1.0)).floor().max(1.0);
    (BLOCK * blocks).min(samples)
}

/// What the scene cannot show, and why.
fn omitted(
    scene: &Scene,
    params: &SingleScatterParams,
    medium: &MediumPlan,
    (lights, points): (u32, bool),
) -> Vec<Omission> {
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
    let no_light = "the scene has no directional or point light";
    omit("light_depth", lights == 0, no_light);
    let direct = "cache is none: a shadow ray for every sample";
    omit(
        "light_depth",
        lights > 0 && params.cache == LightCache::None,
        direct,
    );
    omit("point lights", lights > 0 && !points, none);
    omit("phase function", scene.medium.phase_g == 0.0, "g is 0");
    omit("emission", scene.medium.emission <= 0.0, "its factor is 0");
    let no_colors = scene.medium.albedo_volume.is_none();
    omit("albedo volume", no_colors, none);
    let environment =
        |l: &Light| matches!(l, Light::Environment { .. } | Light::EnvironmentMap { .. });
    omit(
        "environment lights",
        scene.lights.iter().any(environment),
        "single_scatter has none: the image lacks their light, path_trace shows it",
    );
    list
}

impl SingleScatterPlan {
    /// The stage that fills the cache: the one that reads the volume as the medium holds it.
    #[must_use]
    pub fn light_cache(&self) -> StageLayout {
        layout::light_cache_for(&self.medium)
    }

    /// The stage that marches, likewise.
    #[must_use]
    pub fn march(&self) -> StageLayout {
        layout::march_for(&self.medium)
    }

    /// What the light cache is made from. Other parameters of the cache make another plan of it, and a
    /// new cache holds nothing.
    pub(super) const CACHED: Inputs = Inputs::of(&[
        Input::Volume,
        Input::TransferFunction,
        Input::Light,
        Input::Clip,
    ]);

    /// The plan as shown to the user.
    #[must_use]
    pub fn summary(&self, _scene: &Scene) -> Plan {
        let mut stages = self.medium.stages();
        stages.extend(self.albedo.stage(stage::UPLOAD_ALBEDO));
        if let Some(cache) = &self.cache {
            stages.push(StagePlan {
                name: self.light_cache().shader.name,
                depends_on: Self::CACHED,
                domain: cache.nodes,
                dispatches: cache.lights * cache.submissions(),
                specialization: self.cache_constants.clone(),
            });
        }
        let pixels = UVec3::new(self.image[0], self.image[1], 1);
        let [ranges, _] = self.ranges;
        stages.push(StagePlan {
            name: self.march().shader.name,
            depends_on: Inputs::of(&Input::ALL),
            domain: pixels,
            dispatches: self.tiles.bands() * ranges * self.tiles.sub_samples,
            specialization: self.march_constants.clone(),
        });
        stages.push(StagePlan {
            name: stage::READ_BACK,
            depends_on: Inputs::of(&Input::ALL),
            domain: pixels,
            dispatches: 1,
            specialization: Vec::new(),
        });
        let mut resources = self.medium.resources();
        resources.extend(self.cache.iter().map(CachePlan::resource));
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
