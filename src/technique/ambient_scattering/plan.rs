//! What `ambient_scattering` does for a scene.

use glam::UVec3;

use super::cache::CachePlan;
use super::gather::GatherPlan;
use super::lookup::{ANGLES, DEPTHS, Key};
use super::{NAME, choice, layout};
use crate::gpu::{Format, Limits, Specialization, StageLayout};
use crate::scene::{AmbientScatteringParams, Gather, Light, RadianceCache, Scene, Tube};
use crate::technique::albedo_volume::AlbedoPlan;
use crate::technique::medium::MediumPlan;
use crate::technique::summed_area::{FieldKind, FieldPlan, occlusion_radius};
use crate::technique::{
    Input, Inputs, Omission, Plan, PlanError, ResourceKind, ResourcePlan, StagePlan, Tiles, lights,
    target,
};

/// Stage names of the technique.
pub mod stage {
    /// Copy of the tables for the scene's phase function and albedo.
    pub const UPLOAD_TABLES: &str = "ambient_scattering.upload_tables";
    /// Light that arrives at every node of the cache.
    pub const RADIANCE_CACHE: &str = "ambient_scattering.radiance_cache";
    /// What the cache's nodes scatter towards the viewer.
    pub const GATHER: &str = "ambient_scattering.gather";
    /// The radiance of every pixel, the volume read through the device's filter.
    pub const MARCH: &str = "ambient_scattering.march";
    /// The same by loads of 8-bit texels.
    pub const MARCH_R8: &str = "ambient_scattering.march_r8";
    /// The same by loads of 16-bit texels.
    pub const MARCH_R16: &str = "ambient_scattering.march_r16";
    /// The same by loads of float texels.
    pub const MARCH_R32F: &str = "ambient_scattering.march_r32f";
    /// Transfer of the albedo volume.
    pub const UPLOAD_ALBEDO: &str = "ambient_scattering.upload_albedo";
    /// Copy of the image to the host.
    pub const READ_BACK: &str = "ambient_scattering.read_back";
}

/// Constants of `ambient_scattering.radiance_cache`, in the order of their ids; the march has all but the last too.
pub const CACHE_CONSTANTS: [Specialization; 6] = [
    Specialization::new(0, "CLIP_BOX"),
    Specialization::new(1, "CLIP_PLANE"),
    Specialization::new(2, "POINT_LIGHTS"),
    Specialization::new(3, "LINEAR_TUBE"),
    Specialization::new(4, "SPREAD"),
    Specialization::new(19, "NEAR_ONLY"),
];

/// Constants of `ambient_scattering.march`, in the order of their ids.
pub const MARCH_CONSTANTS: [Specialization; 19] = [
    CACHE_CONSTANTS[0],
    CACHE_CONSTANTS[1],
    CACHE_CONSTANTS[2],
    CACHE_CONSTANTS[3],
    CACHE_CONSTANTS[4],
    Specialization::new(5, "SKIP_EMPTY"),
    Specialization::new(6, "MASKED"),
    Specialization::new(7, "LIGHT_COUNT"),
    Specialization::new(8, "CACHED"),
    Specialization::new(9, "ISOTROPIC"),
    Specialization::new(10, "EMISSION"),
    Specialization::new(11, "ALBEDO_VOLUME"),
    Specialization::new(12, "LITERAL_GATHER"),
    Specialization::new(13, "SPECULAR"),
    Specialization::new(14, "ENVIRONMENT"),
    Specialization::new(15, "INTERVAL"),
    Specialization::new(16, "HAS_LIGHTS"),
    Specialization::new(17, "APART"),
    Specialization::new(18, "GATHERED"),
];

/// Constants of `ambient_scattering.gather`, in the order of their ids; the march has them too.
pub const GATHER_CONSTANTS: [Specialization; 7] = [
    MARCH_CONSTANTS[2],
    MARCH_CONSTANTS[7],
    MARCH_CONSTANTS[9],
    MARCH_CONSTANTS[12],
    MARCH_CONSTANTS[14],
    MARCH_CONSTANTS[16],
    MARCH_CONSTANTS[17],
];

/// Loop rounds an invocation: lavapipe silently stops a shader after 65,535 in all loops together.
const MAX_ROUNDS: f64 = 60_000.0;

/// Looks at the light across a radius: what is looked at hardly changes over less.
const LOOKS_A_RADIUS: f64 = 2.0;

/// Samples between two looks, at most, and in a row, as in the shader.
const MAX_INTERVAL: f64 = 32.0;
const BLOCK: f64 = 4.0;

/// Pure data: everything decided for one scene.
#[derive(Clone, Debug, PartialEq)]
pub struct AmbientScatteringPlan {
    /// The medium's part.
    pub medium: MediumPlan,
    /// Mean extinction about every point; none without lights.
    pub extinction: Option<FieldPlan>,
    /// Ambient occlusion; none without environment.
    pub occlusion: Option<FieldPlan>,
    /// The radiance cache; none: tubes at each look, or no light.
    pub cache: Option<CachePlan>,
    /// Looks at the light that the cache's nodes take for rays; none: rays look themselves.
    pub gather: Option<GatherPlan>,
    /// What decides the tables.
    pub tables: Key,
    /// Radius of the sphere about a sample, world units.
    pub radius: f64,
    /// Constants of `ambient_scattering.radiance_cache`.
    pub cache_constants: Vec<Specialization>,
    /// Constants of `ambient_scattering.march`.
    pub march_constants: Vec<Specialization>,
    /// Constants of `ambient_scattering.gather`.
    pub gather_constants: Vec<Specialization>,
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
    params: &AmbientScatteringParams,
    limits: &Limits,
) -> Result<AmbientScatteringPlan, PlanError> {
    let image = &scene.image;
    target::check(image, limits)?;
    let (lights, points) = lights::count(scene, NAME)?;
    let no_skipping = (!params.empty_space_skipping).then_some("empty_space_skipping is off");
    let medium = MediumPlan::new(scene, no_skipping, limits)?;
    let radius = choice::radius(scene, params.radius);
    let environment = lights::mean_environment(&scene.lights).max_element() > 0.0;
    let field = |kind, radius, wanted: bool| {
        wanted
            .then(|| FieldPlan::new(scene, &medium, kind, radius, limits))
            .transpose()
    };
    let extinction = field(FieldKind::AmbientExtinction, radius, lights > 0)?;
    let far = occlusion_radius(scene, params.occlusion_radius);
    let occlusion = field(FieldKind::Occlusion, far, environment)?;
    let steps = (scene.volume.grid.diagonal() / (2.0 * radius))
        .ceil()
        .max(1.0);
    let cache = CachePlan::new(scene, params, radius, (lights, steps as u64), limits)?;
    let tube = if cache.is_none() {
        f64::from(lights) * steps
    } else {
        0.0
    };
    let samples = longest_ray(scene, params)?;
    let interval = interval(scene, params, radius);
    let apart = if lights::weaken(scene) { lights } else { 0 };
    let gather = GatherPlan::new(scene, cache.as_ref(), apart + 1, limits);
    let looks = 2.0 * samples / f64::from(interval) * (1.0 + tube);
    check_rounds(1.5 * samples + looks)?;
    let tiles = Tiles::new(image, samples * (1.0 + f64::from(lights)) + looks, limits);
    let albedo = AlbedoPlan::new(scene);
    let flag = u32::from;
    let values = [
        flag(scene.clip.bounds.is_some()),
        flag(scene.clip.plane.is_some()),
        flag(points),
        flag(params.tube != Tube::Slab),
        limits.worker_threads,
        flag(medium.cells.is_some()),
        flag(medium.masked),
        lights,
        flag(cache.is_some()),
        flag(scene.medium.phase_g == 0.0),
        flag(scene.medium.emission > 0.0),
        flag(albedo.is_there),
        flag(params.gather == Gather::Literal),
        flag(params.specular > 0.0 && lights > 0),
        flag(environment),
        interval,
        flag(lights > 0),
        apart,
        flag(gather.is_ok()),
    ];
    let near_only = flag(cache.is_some_and(|c| c.near_only));
    let of_cache = [
        values[0], values[1], values[2], values[3], values[4], near_only,
    ];
    let cache_constants = Specialization::with_values(&CACHE_CONSTANTS, &of_cache);
    let march_constants = medium.with_constants(&MARCH_CONSTANTS, &values);
    let is_gathers = |c: &&Specialization| GATHER_CONSTANTS.iter().any(|own| own.id == c.id);
    Ok(AmbientScatteringPlan {
        cache_constants,
        gather_constants: march_constants.iter().filter(is_gathers).copied().collect(),
        march_constants,
        tables: Key {
            g: f64::from(scene.medium.phase_g as f32),
            albedo: choice::albedo(scene),
            tube: params.tube,
            gather: params.gather,
        },
        extinction,
        occlusion,
        cache,
        gather: gather.ok(),
        radius,
        albedo,
        image: [image.width, image.height],
        tiles,
        omitted: omitted(
            scene,
            params,
            &medium,
            gather,
            (lights, points, environment),
        ),
        medium,
    })
}

/// Samples between two looks at the light: whole blocks.
fn interval(scene: &Scene, params: &AmbientScatteringParams, radius: f64) -> u32 {
    let samples = radius / LOOKS_A_RADIUS / layout::step_length(scene, params);
    ((samples / BLOCK).round() * BLOCK).clamp(BLOCK, MAX_INTERVAL) as u32
}

/// Samples on the longest possible camera ray.
fn longest_ray(scene: &Scene, params: &AmbientScatteringParams) -> Result<f64, PlanError> {
    let samples = (scene.volume.grid.diagonal() / layout::step_length(scene, params)).ceil();
    if samples > 0.5 * MAX_ROUNDS {
        return Err(PlanError::Limit {
            what: "technique.ambient_scattering.step".to_owned(),
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

fn check_rounds(rounds: f64) -> Result<(), PlanError> {
    if rounds <= MAX_ROUNDS {
        return Ok(());
    }
    Err(PlanError::Limit {
        what: "technique.ambient_scattering".to_owned(),
        found: format!("{rounds:.0} loop rounds on the longest ray"),
        limit: format!("a shader takes at most {MAX_ROUNDS}"),
        fix: "set its cache = \"auto\", or raise step or radius".to_owned(),
    })
}

/// What the scene cannot show, and why.
fn omitted(
    scene: &Scene,
    params: &AmbientScatteringParams,
    medium: &MediumPlan,
    gather: Result<GatherPlan, &str>,
    (lights, points, environment): (u32, bool, bool),
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
    omit("ambient_extinction", lights == 0, no_light);
    omit("radiance_cache", lights == 0, no_light);
    let direct = "cache is none: a tube for every look at the light";
    omit(
        "radiance_cache",
        lights > 0 && params.cache == RadianceCache::None,
        direct,
    );
    omit("point lights", lights > 0 && !points, none);
    omit("phase function", scene.medium.phase_g == 0.0, "g is 0");
    omit("emission", scene.medium.emission <= 0.0, "its factor is 0");
    let no_colors = scene.medium.albedo_volume.is_none();
    omit("albedo volume", no_colors, none);
    if let Err(why) = gather {
        omit("gathered_light", lights > 0, why);
    }
    omit("highlights", params.specular <= 0.0, "specular is 0");
    let dark = "no environment shines";
    omit("occlusion", !environment, dark);
    let map = |l: &Light| matches!(l, Light::EnvironmentMap { .. });
    omit(
        "environment maps",
        scene.lights.iter().any(map),
        "their mean radiance stands for them: path_trace shows them",
    );
    list
}

impl AmbientScatteringPlan {
    /// The stage that fills the cache.
    #[must_use]
    pub const fn radiance_cache(&self) -> StageLayout {
        layout::RADIANCE_CACHE
    }

    /// The stage in which nodes look.
    #[must_use]
    pub const fn gather_stage(&self) -> StageLayout {
        layout::GATHER
    }

    /// The stage that marches: the one that reads the volume as the medium holds it.
    #[must_use]
    pub fn march(&self) -> StageLayout {
        layout::march_for(&self.medium)
    }

    /// What the tables are made from: the albedo is the mean over what the volume and transfer function show.
    pub(super) const TABLES: Inputs = Inputs::of(&[
        Input::Volume,
        Input::TransferFunction,
        Input::Phase,
        Input::Parameters,
    ]);

    /// What the radiance cache is made from.
    pub(super) const CACHED: Inputs = Inputs::of(&[
        Input::Volume,
        Input::TransferFunction,
        Input::Phase,
        Input::Light,
        Input::Clip,
        Input::Parameters,
    ]);

    fn table_resources(&self) -> [ResourcePlan; 2] {
        let table = |name, extent: UVec3| ResourcePlan {
            name,
            kind: ResourceKind::Auxiliary,
            extent,
            format: Format::R32G32B32A32_SFLOAT,
            bytes: 16 * extent.as_u64vec3().element_product(),
            shrink: "it does not grow with the scene",
        };
        [
            table("scattered", UVec3::new(ANGLES as u32, DEPTHS as u32, 1)),
            table("tube", UVec3::new(DEPTHS as u32, 1, 1)),
        ]
    }

    fn own_stages(&self) -> Vec<StagePlan> {
        let mut stages = Vec::new();
        if self.extinction.is_some() {
            stages.push(StagePlan {
                name: stage::UPLOAD_TABLES,
                depends_on: Self::TABLES,
                domain: UVec3::new(ANGLES as u32, DEPTHS as u32, 1),
                dispatches: 2,
                specialization: Vec::new(),
            });
        }
        stages.extend(self.extinction.iter().flat_map(FieldPlan::stages));
        stages.extend(self.occlusion.iter().flat_map(FieldPlan::stages));
        if let Some(cache) = &self.cache {
            stages.push(StagePlan {
                name: stage::RADIANCE_CACHE,
                depends_on: Self::CACHED,
                domain: cache.nodes.count,
                dispatches: cache.lights * cache.submissions(),
                specialization: self.cache_constants.clone(),
            });
        }
        stages
    }

    /// The plan as shown to the user.
    #[must_use]
    pub fn summary(&self, _scene: &Scene) -> Plan {
        let mut stages = self.medium.stages();
        stages.extend(self.albedo.stage(stage::UPLOAD_ALBEDO));
        stages.extend(self.own_stages());
        stages.extend(self.gather.map(|gather| StagePlan {
            name: stage::GATHER,
            depends_on: Inputs::of(&Input::ALL),
            domain: gather.nodes,
            dispatches: gather.submissions(),
            specialization: self.gather_constants.clone(),
        }));
        let pixels = UVec3::new(self.image[0], self.image[1], 1);
        stages.push(StagePlan {
            name: self.march().shader.name,
            depends_on: Inputs::of(&Input::ALL),
            domain: pixels,
            dispatches: self.tiles.bands() * self.tiles.sub_samples,
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
        resources.extend(self.extinction.iter().flat_map(FieldPlan::resources));
        resources.extend(self.occlusion.iter().flat_map(FieldPlan::resources));
        resources.extend(self.cache.iter().map(CachePlan::resource));
        resources.extend(self.gather.iter().map(GatherPlan::resource));
        resources.extend(self.table_resources());
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
