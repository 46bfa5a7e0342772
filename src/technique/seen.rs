//! What is seen of a medium as a whole, by the volume's histogram.

use glam::DVec3;

use crate::scene::Scene;

/// Mean free path in what is seen, world units; without bound where nothing is.
pub(super) fn free_path(scene: &Scene) -> f64 {
    1.0 / typical_extinction(scene).max(f64::MIN_POSITIVE)
}

/// Extinction of what is seen, per world unit: the mean over voxels, each weighted by its opacity.
fn typical_extinction(scene: &Scene) -> f64 {
    let voxel = scene.volume.grid.spacing().min_element();
    let (mut sum, mut weights) = (0.0, 0.0);
    for (count, _, sigma_t) in classes(scene) {
        let weight = count * -(-sigma_t * voxel).exp_m1();
        sum += weight * sigma_t;
        weights += weight;
    }
    if weights > 0.0 { sum / weights } else { 0.0 }
}

/// Voxels, colour and extinction of every bin of the histogram; where gradients decide too, the most that they make
/// of its value.
pub(super) fn classes(scene: &Scene) -> impl Iterator<Item = (f64, DVec3, f64)> {
    let (s, m) = (&scene.statistics, &scene.medium);
    let width = (s.max - s.min) / s.histogram.len().max(1) as f64;
    let bins = s.histogram.iter().enumerate().filter(|(_, n)| **n > 0);
    bins.map(move |(i, count)| {
        let value = s.min + (i as f64 + 0.5) * width;
        let color = m.transfer_function.evaluate(value).0.as_dvec3();
        let sigma_t = m.transfer_function.sigma_t(value) * m.density_scale;
        (*count as f64, color, sigma_t)
    })
}
