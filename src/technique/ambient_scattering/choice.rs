//! What the scene as a whole decides: the radius where none is given, and the albedo of the tables.

use glam::DVec3;

use crate::scene::{Perturbation, Radius, Scene};
use crate::technique::seen::{classes, free_path};
use crate::technique::summed_area::summable_radius;

/// An automatic radius is at most this share of the cube root of the volume.
const LARGEST_SHARE: f64 = 1.0 / 16.0;

/// Most colours of an albedo volume that are looked at.
const MAX_COLORS: usize = 1 << 16;

/// Radius of the sphere about a sample, world units: where it is automatic, a mean free path in the medium, at
/// least a voxel, but never more than a sixteenth of the volume's size, and in very large grids at least what sums over
/// few enough cells can tell; where it is given, at most half the volume's.
#[must_use]
pub fn radius(scene: &Scene, wanted: Radius) -> f64 {
    let grid = &scene.volume.grid;
    wanted.given(grid).unwrap_or_else(|| {
        let size = grid.spacing() * grid.dims.as_dvec3();
        let largest = LARGEST_SHARE * size.element_product().cbrt();
        // A coarse grid does not make the medium coarse.
        let least = grid.spacing().min_element().min(largest);
        free_path(scene)
            .min(largest)
            .max(least)
            .max(summable_radius(grid))
    })
}

/// Mean albedo of the medium, RGB, weighted by extinction: what light meets on its way.
#[must_use]
pub fn albedo(scene: &Scene) -> DVec3 {
    let mean = match &scene.medium.albedo_volume {
        Some(colors) => {
            let count = colors.dims.as_u64vec3().element_product() as usize;
            let stride = count.div_ceil(MAX_COLORS).max(1);
            let grid = scene.volume.grid.dims;
            weighted((0..count).step_by(stride).map(|i| {
                let (x, y) = (grid.x as usize, grid.y as usize);
                let at = DVec3::new((i % x) as f64, (i / x % y) as f64, (i / x / y) as f64);
                let value = scene.volume.sample_index(at);
                let sigma_t = scene.medium.transfer_function.sigma_t(value);
                (sigma_t, colors.color(i))
            }))
        }
        None => {
            let perturbation = scene.medium.perturbation.as_ref();
            let varied = perturbation.map_or(DVec3::ONE, Perturbation::mean_color);
            varied
                * weighted(classes(scene).map(|(count, color, sigma_t)| (count * sigma_t, color)))
        }
    };
    (scene.medium.albedo * mean).clamp(DVec3::ZERO, DVec3::ONE)
}

/// White where nothing weighs.
fn weighted(list: impl Iterator<Item = (f64, DVec3)>) -> DVec3 {
    let (weight, sum) = list.fold((0.0, DVec3::ZERO), |(weight, sum), (w, color)| {
        (weight + w, sum + w * color)
    });
    if weight > 0.0 {
        sum / weight
    } else {
        DVec3::ONE
    }
}
