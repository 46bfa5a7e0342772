//! Closed forms: what a homogeneous slab transmits and emits, in every format and orientation, and
//! that neither step, resolution nor unit changes it.
#![allow(clippy::unwrap_used)]

mod common;

use common::{assert_close, centre, constant, cube, device, points, render, scene, volume, with};
use glam::{DAffine3, DMat3, DQuat, DVec3, UVec3, Vec3};
use tyndall::scene::{Camera, Projection, Scene};
use tyndall::volume::{Grid, Rescale, ScalarType, Space};

const COLOR: Vec3 = Vec3::new(0.9, 0.5, 0.2);

/// A slab of 8 voxels of thickness 1 whose opacity is 0.1 a unit.
fn slab(scalar_type: ScalarType) -> Scene {
    scene(volume(cube(8), scalar_type, |_| 3.0), constant(COLOR, 0.1))
}

fn expect_slab(what: &str, pixel: [f32; 4], tau: f64, relative: f64) {
    let alpha = -(-tau).exp_m1();
    assert_close(
        &format!("{what}: alpha"),
        f64::from(pixel[3]),
        alpha,
        relative,
    );
    for (channel, color) in COLOR.to_array().into_iter().enumerate() {
        let expected = f64::from(color) * alpha;
        assert_close(
            &format!("{what}: radiance"),
            f64::from(pixel[channel]),
            expected,
            relative,
        );
    }
}

/// Optical depth of the slab: 8 units of opacity 0.1.
fn slab_tau() -> f64 {
    -8.0 * 0.9_f64.ln()
}

#[test]
fn slab_transmits_exp_minus_tau_in_every_format() {
    let device = device();
    for scalar_type in ScalarType::ALL {
        let pixel = centre(&render(&device, &slab(scalar_type)));
        // Eight steps of f32 arithmetic and the driver's exp (1e-6).
        expect_slab(scalar_type.name(), pixel, slab_tau(), 5e-6);
    }
}

#[test]
fn slab_is_the_same_along_every_axis_and_its_opposite() {
    let device = device();
    for (axis, up) in [
        (DVec3::X, DVec3::Y),
        (-DVec3::X, DVec3::Z),
        (DVec3::Y, DVec3::Z),
        (-DVec3::Y, DVec3::X),
        (DVec3::Z, DVec3::X),
        (-DVec3::Z, DVec3::Y),
    ] {
        let mut s = slab(ScalarType::U8);
        s.camera = Camera {
            eye: 20.0 * axis,
            up,
            ..s.camera
        };
        expect_slab(
            &format!("from {axis}"),
            centre(&render(&device, &s)),
            slab_tau(),
            5e-6,
        );
    }
}

#[test]
fn slab_is_the_same_on_an_oblique_mirrored_anisotropic_grid() {
    let device = device();
    let turn = DMat3::from_quat(DQuat::from_euler(glam::EulerRot::XYZ, 0.3, -0.8, 1.1));
    let spacing = DVec3::new(1.0, 0.25, 3.0);
    let dims = UVec3::new(8, 32, 5);
    let matrix = turn * DMat3::from_diagonal(DVec3::new(spacing.x, -spacing.y, spacing.z));
    let grid = Grid {
        dims,
        world_from_index: DAffine3::from_mat3_translation(matrix, DVec3::new(1e3, -2e3, 5e2)),
        space: Space::Unspecified,
    };
    let mut s = scene(
        volume(grid, ScalarType::I16, |_| -7.0),
        constant(COLOR, 0.1),
    );
    // Along the grid's second axis: 32 voxels of 0.25 are 8 units again.
    s.camera = Camera {
        eye: grid.centre() + 50.0 * turn.y_axis,
        target: grid.centre(),
        up: turn.z_axis,
        ..s.camera
    };
    expect_slab("oblique", centre(&render(&device, &s)), slab_tau(), 1e-5);
}

#[test]
fn step_does_not_change_a_homogeneous_slab() {
    let device = device();
    for step in [1.0 / 16.0, 0.1, 0.5, 1.0, 3.7, 16.0] {
        let s = with(slab(ScalarType::U16), |p| p.step = step);
        // 128 steps accumulate more rounding than 8.
        expect_slab(
            &format!("step {step}"),
            centre(&render(&device, &s)),
            slab_tau(),
            3e-5,
        );
    }
}

#[test]
fn resolution_does_not_change_a_homogeneous_slab() {
    let device = device();
    for n in [1, 2, 3, 16, 40] {
        let grid = Grid::centred(UVec3::splat(n), DVec3::splat(8.0 / f64::from(n)));
        let s = scene(volume(grid, ScalarType::F32, |_| 1.0), constant(COLOR, 0.1));
        expect_slab(
            &format!("{n} voxels"),
            centre(&render(&device, &s)),
            slab_tau(),
            1e-5,
        );
    }
}

#[test]
fn units_do_not_change_the_image_when_opacity_follows() {
    let device = device();
    // From nanometres in metres to light years: 1e-6 and 1e6 of the usual size.
    for unit in [1e-6, 1e-3, 1.0, 1e3, 1e6] {
        let grid = Grid::centred(UVec3::splat(8), DVec3::splat(unit));
        let mut tf = constant(COLOR, 0.1);
        tf.opacity_unit_distance = unit;
        let s = scene(volume(grid, ScalarType::U8, |_| 3.0), tf);
        expect_slab(
            &format!("unit {unit}"),
            centre(&render(&device, &s)),
            slab_tau(),
            5e-6,
        );
    }
}

#[test]
fn origin_of_a_million_costs_no_precision() {
    let device = device();
    let origin = DVec3::new(1e6, -1e6, 1e6);
    let grid = Grid::axis_aligned(UVec3::splat(8), DVec3::ONE, origin);
    let s = scene(volume(grid, ScalarType::U8, |_| 3.0), constant(COLOR, 0.1));
    expect_slab("origin 1e6", centre(&render(&device, &s)), slab_tau(), 1e-5);
}

#[test]
fn thin_and_thick_media_keep_their_digits() {
    let device = device();
    for opacity in [1e-9, 1e-7, 1e-5, 1e-3, 0.5, 0.999] {
        let s = scene(
            volume(cube(8), ScalarType::U8, |_| 1.0),
            constant(COLOR, opacity),
        );
        let tau = -8.0 * (-opacity).ln_1p();
        // A step of 1e-9 must not vanish in 1 - (1 - x).
        expect_slab(
            &format!("opacity {opacity}"),
            centre(&render(&device, &s)),
            tau,
            1e-5,
        );
    }
}

#[test]
fn opacity_one_is_a_finite_documented_maximum() {
    let device = device();
    let s = scene(
        volume(cube(1), ScalarType::U8, |_| 1.0),
        constant(COLOR, 1.0),
    );
    let pixel = centre(&render(&device, &s));
    expect_slab(
        "opacity 1",
        pixel,
        -(1.0 - tyndall::scene::transfer_function::OPACITY_MAX).ln(),
        1e-5,
    );
}

#[test]
fn background_shows_through_by_transmittance() {
    let device = device();
    let mut s = slab(ScalarType::U8);
    s.image.background = Vec3::new(0.25, 2.0, 0.0);
    let image = render(&device, &s);
    let t = (-slab_tau()).exp();
    for (channel, background) in [0.25, 2.0, 0.0].into_iter().enumerate() {
        let expected = f64::from(COLOR[channel]) * (1.0 - t) + t * background;
        assert_close(
            "over background",
            f64::from(centre(&image)[channel]),
            expected,
            1e-5,
        );
    }
    assert_eq!(
        image.pixel(0, 0).unwrap(),
        [0.25, 2.0, 0.0, 0.0],
        "beside the volume"
    );
}

#[test]
fn rescaled_data_values_meet_the_transfer_function() {
    let device = device();
    let tf = points(&[
        (-1000.0, COLOR, 0.0),
        (-1000.0 + 0.5, COLOR, 0.1),
        (0.0, COLOR, 0.1),
    ]);
    for (slope, intercept, stored) in [
        (1.0, -1024.0, 24.0 + 512.0),
        (-2.0, 0.0, 256.0),
        (0.5, -612.0, 200.0),
    ] {
        for scalar_type in [
            ScalarType::U16,
            ScalarType::I16,
            ScalarType::F32,
            ScalarType::F64,
            ScalarType::I32,
        ] {
            // One voxel of air in a far corner gives the table a range.
            let air = (-1000.0 - intercept) / slope;
            let mut v = volume(cube(8), scalar_type, |i| {
                if i == UVec3::ZERO { air } else { stored }
            });
            v.rescale = Rescale { slope, intercept };
            let s = scene(v, tf.clone());
            let what = format!("slope {slope}, {scalar_type}");
            expect_slab(&what, centre(&render(&device, &s)), slab_tau(), 1e-5);
        }
    }
}

#[test]
fn camera_inside_the_volume_sees_only_what_lies_ahead() {
    let device = device();
    let mut s = slab(ScalarType::U8);
    s.camera = Camera {
        eye: DVec3::new(0.0, 1.0, 0.0),
        target: DVec3::new(0.0, 2.0, 0.0),
        up: DVec3::Z,
        projection: Projection::Perspective { vfov_deg: 1.0 },
    };
    // 3 of the 8 units lie beyond y = 1.
    expect_slab(
        "inside",
        centre(&render(&device, &s)),
        slab_tau() * 3.0 / 8.0,
        1e-4,
    );
}

#[test]
fn perspective_path_length_grows_towards_the_edge() {
    let device = device();
    let mut s = slab(ScalarType::U8);
    s.camera.projection = Projection::Perspective { vfov_deg: 20.0 };
    let image = render(&device, &s);
    let eye = 8.0 * 3f64.sqrt();
    for (x, y) in [(16, 16), (20, 16), (12, 22)] {
        let tan = 10f64.to_radians().tan();
        let (u, v) = (
            (f64::from(x) + 0.5) / 16.0 - 1.0,
            1.0 - (f64::from(y) + 0.5) / 16.0,
        );
        let slope = (tan * tan * (u * u + v * v) + 1.0).sqrt();
        // The ray enters and leaves through the faces y = -4 and y = 4 of the box.
        assert!((eye + 4.0) * tan * u.abs().max(v.abs()) < 4.0);
        expect_slab(
            "perspective",
            image.pixel(x, y).unwrap(),
            slab_tau() * slope,
            1e-5,
        );
    }
}
