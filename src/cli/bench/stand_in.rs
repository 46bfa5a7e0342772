//! Scenes that stand in for a paper's: a formula on a grid of the data set's size, the paper's settings.

use std::sync::Arc;

use glam::{DVec3, UVec3, Vec3};

use super::paper::{Model, Row, Setup, Spot};
use crate::scene::file::{Override, SceneError, SceneFile};
use crate::scene::framing::{self, Direction, Wish};
use crate::scene::{
    AmbientOcclusionParams, AmbientScatteringParams, Camera, Clip, Falloff, HalfAngleParams, Light,
    LightCache, Lighting, Octave, Perturbation, Projection, Radius, RayMarchParams, Scene,
    SingleScatterParams, TechniqueParams,
};
use crate::volume::Statistics;

/// Voxels a step.
const STEP: f64 = 1.0;

/// Opacity at which a ray ends.
const EARLY_TERMINATION: f64 = 0.98;

/// Models of rays. A new one is a line here and a function below; what the paper says of it is in the table already.
pub(super) const RAYS: &[(Model, Setup)] = &[
    (Model::EmissionAbsorption, emission_absorption),
    (Model::AmbientOcclusion, ambient_occlusion),
    (Model::SingleScattering, single_scattering),
    (Model::AmbientScattering, ambient_scattering),
];

/// Models of slices, one a voxel; all alike but for their light.
pub(super) const SLICES: &[(Model, Setup)] = &[
    (Model::SlicesUnlit, |_, scene| slices(scene, Lighting::None)),
    (Model::SlicesSurface, |_, scene| {
        slices(scene, Lighting::Surface);
    }),
    (Model::SlicesDirect, |_, scene| {
        slices(scene, Lighting::Direct);
    }),
    (Model::SlicesIndirect, |_, scene| {
        slices(scene, Lighting::Indirect);
    }),
    (Model::SlicesNoise, slices_with_noise),
];

fn slices(scene: &mut Scene, lighting: Lighting) {
    scene.technique = TechniqueParams::HalfAngle(HalfAngleParams {
        lighting,
        ..HalfAngleParams::default()
    });
}

/// One octave, which moves a look by up to a hundredth of the volume's longest side.
fn slices_with_noise(_: &Row, scene: &mut Scene) {
    slices(scene, Lighting::Indirect);
    scene.medium.perturbation = Some(Perturbation {
        seed: 0,
        octaves: vec![Octave {
            frequency: 60.0,
            displacement: 0.02,
            opacity: 0.0,
            color: Vec3::ZERO,
            offset: DVec3::ZERO,
            velocity: DVec3::ZERO,
        }],
        time: 0.0,
    });
}

fn emission_absorption(_: &Row, scene: &mut Scene) {
    scene.technique = TechniqueParams::RayMarch(RayMarchParams {
        step: STEP,
        shading: None,
        early_termination: EARLY_TERMINATION,
        ..RayMarchParams::default()
    });
}

/// Its light is that of an environment, whatever the row's.
fn ambient_occlusion(row: &Row, scene: &mut Scene) {
    scene.lights = vec![Light::Environment {
        radiance: Vec3::ONE,
    }];
    scene.technique = TechniqueParams::AmbientOcclusion(AmbientOcclusionParams {
        step: STEP,
        radius: radius(row),
        early_termination: EARLY_TERMINATION,
        ..AmbientOcclusionParams::default()
    });
}

fn single_scattering(_: &Row, scene: &mut Scene) {
    scene.technique = TechniqueParams::SingleScatter(SingleScatterParams {
        step: STEP,
        shadow_step: STEP,
        cache: LightCache::Half,
        early_termination: EARLY_TERMINATION,
        ..SingleScatterParams::default()
    });
}

fn ambient_scattering(row: &Row, scene: &mut Scene) {
    scene.technique = TechniqueParams::AmbientScattering(AmbientScatteringParams {
        step: STEP,
        radius: radius(row),
        early_termination: EARLY_TERMINATION,
        ..AmbientScatteringParams::default()
    });
}

fn radius(row: &Row) -> Radius {
    row.radius.map_or_else(Radius::default, Radius::Voxels)
}

/// The scene of a row, its technique still open; `image` are keys of the image.
///
/// # Errors
/// A key of the image is wrong.
pub(super) fn scene(row: &Row, image: &[String]) -> Result<Scene, SceneError> {
    let overrides: Vec<_> = image
        .iter()
        .map(|text| Override::parse(text))
        .collect::<Result<_, _>>()?;
    let file = SceneFile::for_procedural(row.stand_in, &overrides)?;
    let volume = row.stand_in.volume_of(UVec3::from_array(row.dims));
    let statistics = Statistics::of(&volume);
    let mut scene = file.resolve_with(Arc::new(volume), Arc::new(statistics))?;
    scene.clip = Clip::default();
    scene.camera = camera(&scene);
    scene.lights = row.lights.iter().map(|spot| light(*spot, &scene)).collect();
    scene.medium.phase_g = row.g;
    Ok(scene)
}

/// The automatic camera, whatever the formula's own scene says: the box has other sides.
fn camera(scene: &Scene) -> Camera {
    let tf = &scene.medium.transfer_function;
    let outline = framing::visible_outline(&scene.volume, tf, &scene.clip);
    let direction = Direction::new(scene.volume.grid.space, None, None);
    let image = &scene.image;
    let wish = Wish {
        target: None,
        up: direction.up,
        projection: Projection::Perspective {
            vfov_deg: framing::VFOV_DEG,
        },
        direction,
        aspect: f64::from(image.width) / f64::from(image.height),
        zoom: 1.0,
    };
    framing::frame(&outline, &wish)
}

fn light(spot: Spot, scene: &Scene) -> Light {
    let power = Vec3::splat(std::f32::consts::PI);
    let view = scene.camera.frame();
    let direction = match spot {
        Spot::Centre => {
            return Light::Point {
                position: scene.volume.grid.centre(),
                intensity: power,
                falloff: Falloff::None,
            };
        }
        Spot::Front => view.forward,
        Spot::Behind => -view.forward,
        Spot::Left => view.right,
        Spot::UpperLeft => view.right - view.up + view.forward,
    };
    Light::Directional {
        direction,
        irradiance: power,
    }
}
