//! Extremes of the medium and of the data.

use glam::{DVec3, UVec3};

use super::Extreme;
use super::scenes::{changed, cube, filled, table, volume};
use crate::volume::{Grid, Voxels};

pub(super) fn extremes() -> Vec<Extreme> {
    let mut list = vec![changed("no extinction", 0.0, |_| {})];
    for tau in [1e-6, 1e-4, 1e-2, 1.0, 1e2, 1e5] {
        list.push(cube(&format!("optical depth {tau:e} a voxel"), tau));
    }
    list.push(changed("albedo 0", 0.5, |e| e.scene.medium.albedo = 0.0));
    list.push(changed("albedo 1", 0.5, |e| {
        e.scene.medium.albedo = 1.0;
        for p in &mut e.scene.medium.transfer_function.points {
            p.color = glam::Vec3::ONE;
        }
    }));
    for g in [-0.99, 0.99] {
        for tau in [1e-4, 0.5] {
            let name = format!("g {g}, optical depth {tau:e} a voxel");
            list.push(changed(&name, tau, |e| e.scene.medium.phase_g = g));
        }
    }
    for step in [1.0 / 16.0, 16.0] {
        let name = format!("step of {step} voxels");
        list.push(changed(&name, 0.5, |e| e.step = Some(step)));
    }
    list.extend(data());
    list
}

/// Odd data, of which no optical depth is known in closed form.
fn data() -> Vec<Extreme> {
    let grid = Grid::centred(UVec3::splat(8), DVec3::ONE);
    let voxels = 512;
    let extreme = |name: &str, values: Voxels, rows: &[(f64, f64)]| {
        let mut e = cube(name, 1.0);
        e.scene = filled(volume(grid, values), table(rows));
        e.tau = None;
        e.front_lit = false;
        e
    };
    let spike = |i: usize| if i == 219 { 1e30 } else { 0.0 };
    let halves = |i: usize| match i % 4 {
        0 => 65504.0,
        1 => 5.960_464_5e-8,
        2 => -65504.0,
        _ => 0.0,
    };
    let ramp = |i: usize| (i % 256) as u8;
    let holes = |i: usize| match i % 5 {
        0 => f32::NAN,
        1 => f32::INFINITY,
        2 => f32::NEG_INFINITY,
        _ => 1.0,
    };
    let floats = |f: &dyn Fn(usize) -> f32| Voxels::F32((0..voxels).map(f).collect());
    vec![
        extreme(
            "one voxel of 1e30",
            floats(&spike),
            &[(0.0, 0.0), (1e30, 2.0)],
        ),
        extreme(
            "the range of half floats",
            floats(&halves),
            &[(-65504.0, 0.0), (65504.0, 3.0)],
        ),
        extreme(
            "a transfer function with a spike of one value",
            Voxels::U8((0..voxels).map(ramp).collect()),
            &[(99.0, 0.0), (100.0, 1e4), (101.0, 0.0)],
        ),
        extreme(
            "constant data at a jump of the transfer function",
            Voxels::U16(vec![7; voxels]),
            &[(7.0, 0.0), (7.0, 5.0)],
        ),
        extreme(
            "data that are not finite",
            floats(&holes),
            &[(0.0, 1.0), (1.0, 1.0)],
        ),
        extreme(
            "an empty transfer function",
            Voxels::U8(vec![1; voxels]),
            &[],
        ),
    ]
}
