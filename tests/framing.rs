//! The automatic camera and lights.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use std::sync::Arc;

use glam::{DAffine3, DMat3, DQuat, DVec2, DVec3, UVec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use tyndall::scene::file::SceneFile;
use tyndall::scene::framing::{Direction, Wish, centre, frame, lights};
use tyndall::scene::{Camera, Light, Projection};
use tyndall::volume::{Grid, Rescale, Space, Statistics, Volume, Voxels};

const PERSPECTIVE: Projection = Projection::Perspective { vfov_deg: 30.0 };

/// Largest image coordinate of all points: 1 at the image's border.
fn reach(camera: &Camera, aspect: f64, points: &[DVec3]) -> f64 {
    let f = camera.frame();
    let project = |p: &DVec3| {
        let v = *p - camera.eye;
        let depth = v.dot(f.forward);
        assert!(depth > 0.0, "{p} is behind the eye of {camera:?}");
        let half = match camera.projection {
            Projection::Perspective { vfov_deg } => depth * (0.5 * vfov_deg).to_radians().tan(),
            Projection::Orthographic { height } => 0.5 * height,
        };
        (DVec2::new(v.dot(f.right) / aspect, v.dot(f.up)) / half)
            .abs()
            .max_element()
    };
    points.iter().map(project).fold(0.0, f64::max)
}

fn framed(grid: &Grid, projection: Projection, aspect: f64, direction: Direction) -> Camera {
    let wish = Wish {
        target: None,
        up: direction.up,
        projection,
        direction,
        aspect,
        zoom: 1.0,
    };
    frame(&grid.corners(), &wish)
}

fn assert_framed(grid: &Grid, projection: Projection, aspect: f64, direction: Direction) {
    let camera = framed(grid, projection, aspect, direction);
    let reach = reach(&camera, aspect, &grid.corners());
    let fills = matches!(projection, Projection::Orthographic { .. }) || reach > 0.8;
    assert!(reach < 0.95 && fills, "{reach} of {grid:?} in {camera:?}");
}

fn random_grid(rng: &mut Pcg64Mcg) -> Grid {
    let mut power = |lo: f64, hi: f64| 10f64.powf(rng.random_range(lo..hi));
    let scale = power(-6.0, 6.0);
    let spacing = scale * DVec3::new(1.0, power(-1.5, 1.5), power(-1.5, 1.5));
    let origin = DVec3::new(power(-3.0, 4.0), -power(-3.0, 4.0), power(-3.0, 4.0)) * scale;
    let axis = DVec3::new(power(-1.0, 1.0), -1.0, power(-1.0, 1.0)).normalize();
    let turn = DQuat::from_axis_angle(axis, rng.random_range(-3.0..3.0));
    let mirror = DVec3::new([1.0, -1.0][rng.random_range(0..2)], 1.0, 1.0);
    let matrix = DMat3::from_quat(turn) * DMat3::from_diagonal(spacing * mirror);
    Grid {
        dims: UVec3::from_array(std::array::from_fn(|_| rng.random_range(1..300))),
        world_from_index: DAffine3::from_mat3_translation(matrix, origin),
        space: [Space::PatientRas, Space::Unspecified][rng.random_range(0..2)],
    }
}

#[test]
fn every_corner_of_random_grids_is_inside_the_image() {
    let mut rng = Pcg64Mcg::seed_from_u64(1);
    for _ in 0..300 {
        let grid = random_grid(&mut rng);
        let aspect = [0.3, 1.0, 16.0 / 9.0][rng.random_range(0..3)];
        let azimuth = rng.random_range(-360.0..360.0);
        let elevation = rng.random_range(-90.0..90.0);
        let direction = Direction::new(grid.space, Some(azimuth), Some(elevation));
        let vfov_deg = rng.random_range(1.0..120.0);
        let camera = framed(
            &grid,
            Projection::Perspective { vfov_deg },
            aspect,
            direction,
        );
        assert!(reach(&camera, aspect, &grid.corners()) < 0.95);
        let height = grid.diagonal() * 1.2 / aspect.min(1.0);
        assert_framed(
            &grid,
            Projection::Orthographic { height },
            aspect,
            direction,
        );
    }
}

#[test]
fn extreme_grids_are_framed() {
    let dims = UVec3::new(512, 512, 40);
    for (dims, spacing, origin) in [
        (dims, DVec3::new(1.0, 1.0, 30.0), DVec3::ZERO),
        (dims, DVec3::ONE, DVec3::splat(1e6)),
        (UVec3::splat(64), DVec3::splat(1e-6), DVec3::splat(1e6)),
        (UVec3::ONE, DVec3::ONE, DVec3::ZERO),
        (UVec3::ONE, DVec3::splat(1e-6), DVec3::ZERO),
        (dims, DVec3::splat(1e6), DVec3::splat(-1e9)),
    ] {
        let grid = Grid::axis_aligned(dims, spacing, origin);
        let direction = Direction::new(grid.space, None, None);
        assert_framed(&grid, PERSPECTIVE, 1.0, direction);
        let height = 1.3 * grid.diagonal();
        assert_framed(&grid, Projection::Orthographic { height }, 1.0, direction);
    }
}

#[test]
fn the_patients_left_is_on_the_images_right() {
    let grid = Grid::centred(UVec3::splat(8), DVec3::ONE);
    let view = |space| framed(&grid, PERSPECTIVE, 1.0, Direction::new(space, None, None));
    let patient = view(Space::PatientRas);
    let f = patient.frame();
    assert!(
        f.right.x < -0.8 && f.forward.y < -0.8 && f.up.z > 0.9,
        "{f:?}"
    );
    assert!(patient.eye.z > 0.0);
    let other = view(Space::Unspecified);
    assert!(other.eye.y < 0.0 && other.eye.x > 0.0 && other.eye.z > 0.0);
}

#[test]
fn looking_straight_down_keeps_the_front_at_the_bottom() {
    for elevation in [90.0, -90.0] {
        let direction = Direction::new(Space::Unspecified, Some(0.0), Some(elevation));
        let grid = Grid::centred(UVec3::splat(8), DVec3::ONE);
        let f = framed(&grid, PERSPECTIVE, 1.0, direction).frame();
        let sign = elevation.signum();
        assert!(f.forward.abs_diff_eq(-DVec3::Z * sign, 1e-9));
        assert!(f.up.abs_diff_eq(DVec3::Y * sign, 1e-9), "{f:?}");
    }
}

#[test]
fn the_key_light_comes_from_the_cameras_upper_left_and_front() {
    let mut rng = Pcg64Mcg::seed_from_u64(2);
    for _ in 0..50 {
        let grid = random_grid(&mut rng);
        let direction = Direction::new(grid.space, None, None);
        let camera = framed(&grid, PERSPECTIVE, 1.0, direction);
        let (f, lights) = (camera.frame(), lights(&camera));
        let Light::Directional { direction, .. } = lights[0] else {
            panic!("no key light");
        };
        assert!(direction.dot(f.right) > 0.4, "left");
        assert!(direction.dot(f.up) < -0.5, "up");
        assert!(direction.dot(f.forward) > 0.4, "in front of the volume");
        assert!(matches!(lights[1], Light::Environment { .. }));
    }
}

/// A filled cube of 32 voxels.
fn camera(text: &str) -> Camera {
    let volume = Volume {
        name: "cube".to_owned(),
        grid: Grid::centred(UVec3::splat(32), DVec3::ONE),
        voxels: Voxels::U8(vec![1; 32 * 32 * 32]),
        rescale: Rescale::IDENTITY,
        spatial_unit: None,
        height_field: None,
    };
    let statistics = Statistics::of(&volume);
    let text = format!("transfer_function.points = [[1, 1, 1, 1, 0.5]]\n{text}");
    let file = SceneFile::parse(&text, "s.toml", "".into(), &[]).unwrap();
    let scene = file.resolve_with(Arc::new(volume), Arc::new(statistics));
    scene.unwrap().camera
}

#[test]
fn what_is_clipped_away_is_not_framed() {
    let whole = camera("");
    let clipped = camera("clip.box = { min = [8, 8, 8], max = [16, 16, 16] }");
    let distance = |c: &Camera| c.eye.distance(c.target);
    assert!(distance(&clipped) < 0.5 * distance(&whole));
    assert!(clipped.target.distance(DVec3::splat(12.0)) < 2.0);
    let half = camera("clip.plane = { point = [0, 0, 0], normal = [0, 0, 5] }");
    assert!(half.target.z > 4.0, "{half:?}");
    assert!(centre(&[DVec3::ZERO, DVec3::ONE]).abs_diff_eq(DVec3::splat(0.5), 1e-12));
}

#[test]
fn an_eye_above_the_volume_has_an_up() {
    for eye in ["eye = [0, 0, 90]", "eye = [0, 0, -90]\ntarget = [0, 0, 0]"] {
        let c = camera(&format!("[camera]\n{eye}"));
        assert!((c.target - c.eye).cross(c.up).length() > 1.0, "{c:?}");
    }
}

#[test]
fn zoom_brings_the_eye_closer() {
    let distance = |text: &str| {
        let c = camera(text);
        c.eye.distance(c.target)
    };
    assert!(distance("camera.zoom = 2") < 0.8 * distance(""));
}
