//! The scene that every extreme departs from.

use std::sync::Arc;

use glam::{DVec3, UVec3, Vec3};

use super::Extreme;
use crate::scene::transfer_function::Quantity;
use crate::scene::{
    Camera, Clip, ControlPoint, ImageSettings, Light, Medium, PathTraceParams, Projection, Scene,
    TechniqueParams, TransferFunction,
};
use crate::volume::{Grid, Rescale, Statistics, Volume, Voxels};

/// Irradiance of the light of [`cube`].
pub(super) const IRRADIANCE: f32 = 2.0;

/// The colour of [`cube`]'s medium.
pub(super) const COLOR: Vec3 = Vec3::new(0.8, 0.5, 0.25);

/// Pixels along an edge of the image.
const PIXELS: u32 = 8;

/// A volume of the given values, x fastest.
pub(super) fn volume(grid: Grid, voxels: Voxels) -> Volume {
    Volume {
        name: "extreme".to_owned(),
        grid,
        voxels,
        rescale: Rescale::IDENTITY,
        spatial_unit: None,
        height_field: None,
    }
}

/// An even volume of 8-bit ones.
pub(super) fn even(grid: Grid) -> Volume {
    let voxels = grid.dims.element_product() as usize;
    volume(grid, Voxels::U8(vec![1; voxels]))
}

/// The same colour and extinction, per world unit, for every value.
pub(super) fn medium(sigma_t: f64) -> Medium {
    table(&[(0.0, sigma_t), (1.0, sigma_t)])
}

/// Rows of value and extinction, in one colour.
pub(super) fn table(rows: &[(f64, f64)]) -> Medium {
    let point = |(value, opacity): &(f64, f64)| ControlPoint {
        value: *value,
        color: COLOR,
        opacity: *opacity,
    };
    Medium {
        transfer_function: TransferFunction {
            name: "extreme".to_owned(),
            quantity: Quantity::Extinction,
            points: rows.iter().map(point).collect(),
            primitives: Vec::new(),
            opacity_unit_distance: 1.0,
        },
        density_scale: 1.0,
        albedo: 0.9,
        perturbation: None,
        albedo_volume: None,
        emission: 0.0,
        phase_g: 0.0,
    }
}

/// A volume seen along +y by parallel rays that all cross it in full, lit along the view.
pub(super) fn filled(volume: Volume, medium: Medium) -> Scene {
    let grid = volume.grid;
    let size = grid.spacing() * grid.dims.as_dvec3();
    let statistics = Statistics::of(&volume);
    let centre = grid.centre();
    Scene {
        volume: Arc::new(volume),
        statistics: Arc::new(statistics),
        medium,
        lights: vec![along(DVec3::Y)],
        camera: Camera {
            eye: centre - DVec3::Y * grid.diagonal(),
            target: centre,
            up: DVec3::Z,
            projection: Projection::Orthographic {
                height: 0.5 * size.x.min(size.z),
            },
        },
        clip: Clip::default(),
        image: ImageSettings {
            width: PIXELS,
            height: PIXELS,
            ..ImageSettings::default()
        },
        technique: TechniqueParams::PathTrace(PathTraceParams::default()),
    }
}

/// Parallel light.
pub(super) fn along(direction: DVec3) -> Light {
    Light::Directional {
        direction,
        irradiance: Vec3::splat(IRRADIANCE),
    }
}

/// The scene that most extremes depart from: a cube of 8^3 even voxels, `tau` deep a voxel.
pub(super) fn cube(name: &str, tau: f64) -> Extreme {
    let grid = Grid::centred(UVec3::splat(8), DVec3::ONE);
    Extreme {
        name: name.to_owned(),
        scene: filled(even(grid), medium(tau)),
        tau: Some(8.0 * tau),
        irradiance: IRRADIANCE.into(),
        step: None,
        front_lit: true,
    }
}

/// A copy of [`cube`], changed.
pub(super) fn changed(name: &str, tau: f64, change: impl FnOnce(&mut Extreme)) -> Extreme {
    let mut extreme = cube(name, tau);
    change(&mut extreme);
    extreme
}
