//! What GPU tests share: a validated device and small scenes built in memory.
#![allow(
    dead_code,
    unreachable_pub,
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic
)]

use std::sync::Arc;

use glam::{DVec3, UVec3, Vec3};
use tyndall::gpu::{Device, Validation};
use tyndall::output::Image;
use tyndall::scene::transfer_function::Quantity;
use tyndall::scene::{
    Camera, Clip, ControlPoint, ImageSettings, Light, Medium, Projection, RayMarchParams, Scene,
    TechniqueParams, TransferFunction,
};
use tyndall::technique::Renderer;
use tyndall::volume::{Grid, Rescale, ScalarType, Statistics, Volume, Voxels};

/// The device under test, with validation and synchronization validation; nothing kept on disk.
pub fn device() -> Device {
    Device::open_with_cache(None, Validation::On, None)
        .expect("a Vulkan 1.3 driver and the validation layer (ci/test.sh installs both)")
}

/// Renders once; fails on any validation message and on memory left behind.
pub fn render(device: &Device, scene: &Scene) -> Image {
    let mut renderer = Renderer::new(device, scene.clone()).unwrap();
    let (image, _) = renderer.render(&mut |_, _, _| {}).unwrap();
    drop(renderer);
    device.check_validation().unwrap();
    assert_eq!(device.live_allocations(), vec![], "memory left behind");
    image
}

/// Renders once beside other live renderers of the device.
pub fn render_beside(device: &Device, scene: &Scene) -> Image {
    let mut renderer = Renderer::new(device, scene.clone()).unwrap();
    renderer.render(&mut |_, _, _| {}).unwrap().0
}

/// A volume of one type whose stored values are `value(i)`, `i` being the voxel's index.
pub fn volume(grid: Grid, scalar_type: ScalarType, value: impl Fn(UVec3) -> f64) -> Volume {
    let d = grid.dims;
    let values: Vec<f64> = (0..grid.voxel_count())
        .map(|i| {
            let i = u32::try_from(i).unwrap();
            value(UVec3::new(i % d.x, i / d.x % d.y, i / (d.x * d.y)))
        })
        .collect();
    macro_rules! typed {
        ($variant:ident, $t:ty) => {
            Voxels::$variant(values.iter().map(|v| *v as $t).collect())
        };
    }
    let voxels = match scalar_type {
        ScalarType::U8 => typed!(U8, u8),
        ScalarType::I8 => typed!(I8, i8),
        ScalarType::U16 => typed!(U16, u16),
        ScalarType::I16 => typed!(I16, i16),
        ScalarType::U32 => typed!(U32, u32),
        ScalarType::I32 => typed!(I32, i32),
        ScalarType::F32 => typed!(F32, f32),
        ScalarType::F64 => typed!(F64, f64),
    };
    Volume {
        name: "test".to_owned(),
        grid,
        voxels,
        rescale: Rescale::IDENTITY,
        spatial_unit: None,
        height_field: None,
    }
}

/// A cube of `n`^3 voxels of spacing 1 about the origin.
pub fn cube(n: u32) -> Grid {
    Grid::centred(UVec3::splat(n), DVec3::ONE)
}

/// The same colour and opacity for every data value.
pub fn constant(color: Vec3, opacity: f64) -> TransferFunction {
    points(&[(0.0, color, opacity)])
}

/// A transfer function over data values.
pub fn points(list: &[(f64, Vec3, f64)]) -> TransferFunction {
    let points = list.iter().map(|&(value, color, opacity)| ControlPoint {
        value,
        color,
        opacity,
    });
    TransferFunction {
        name: "test".to_owned(),
        points: points.collect(),
        quantity: Quantity::Opacity,
        primitives: Vec::new(),
        opacity_unit_distance: 1.0,
    }
}

/// Emission-absorption, no early end, orthographic along -y from the front, z up: the image's
/// right is +x. 32 x 32 pixels over the volume and a margin.
pub fn scene(volume: Volume, transfer_function: TransferFunction) -> Scene {
    let statistics = Statistics::of(&volume);
    let grid = volume.grid;
    let size = grid.diagonal();
    let camera = Camera {
        eye: grid.centre() - DVec3::Y * size,
        target: grid.centre(),
        up: DVec3::Z,
        projection: Projection::Orthographic { height: size },
    };
    Scene {
        volume: Arc::new(volume),
        statistics: Arc::new(statistics),
        medium: Medium {
            transfer_function,
            density_scale: 1.0,
            albedo: 1.0,
            perturbation: None,
            albedo_volume: None,
            emission: 0.0,
            phase_g: 0.0,
        },
        lights: vec![Light::Directional {
            direction: DVec3::new(1.0, 1.0, -1.0),
            irradiance: Vec3::splat(std::f32::consts::PI),
        }],
        camera,
        clip: Clip::default(),
        image: ImageSettings {
            width: 32,
            height: 32,
            ..ImageSettings::default()
        },
        technique: TechniqueParams::RayMarch(params()),
    }
}

/// Exact parameters: one sample a voxel, no shading, no early end.
pub fn params() -> RayMarchParams {
    RayMarchParams {
        step: 1.0,
        shading: None,
        early_termination: 1.0,
        empty_space_skipping: true,
    }
}

/// Changes the parameters of `ray_march`.
pub fn with(mut scene: Scene, edit: impl FnOnce(&mut RayMarchParams)) -> Scene {
    let TechniqueParams::RayMarch(params) = &mut scene.technique else {
        panic!("not ray_march");
    };
    edit(params);
    scene
}

/// The parameters of `ray_march`.
pub fn params_of(scene: &Scene) -> RayMarchParams {
    let TechniqueParams::RayMarch(params) = scene.technique else {
        panic!("not ray_march");
    };
    params
}

/// The pixel nearest to the image's centre.
pub fn centre(image: &Image) -> [f32; 4] {
    image.pixel(image.width / 2, image.height / 2).unwrap()
}

/// Asserts `a` and `b` to be within `relative` of `b`, and says where.
pub fn assert_close(what: &str, a: f64, b: f64, relative: f64) {
    let limit = relative * b.abs().max(1e-30);
    assert!(
        (a - b).abs() <= limit,
        "{what}: found {a:e}, expected {b:e} within {relative:e}"
    );
}
