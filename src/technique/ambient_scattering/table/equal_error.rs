//! How much sooner the shared estimator reaches an error than the plain one: variance times time of both,
//! on the same device, in one run.

use serde::Serialize;

use super::TableError;
use super::grid::Axis;
use super::layout::{ANGLES, Job};
use super::optics::{colliding, unscattered};
use super::record::{Estimator, Preintegrator};
use super::sums::{DARK, quantile};
use crate::gpu::Device;

/// Extinctions and anisotropies that are tried.
const SIGMAS: [f64; 5] = [0.5, 2.0, 5.0, 10.0, 20.0];
const GS: [f64; 5] = [-0.8, -0.4, 0.0, 0.4, 0.8];
/// Batches of each, by both.
const BATCHES: u32 = 64;

/// Variance times time of both estimators over the entries of a column brighter than [`DARK`].
#[derive(Clone, Debug, Serialize)]
pub struct EqualError {
    /// Extinction times radius.
    pub sigma_t: f64,
    /// Mean cosine of the phase function.
    pub g: f64,
    /// Which angles, degrees.
    pub angles: [f64; 2],
    /// Entries; those that the plain estimator has not seen well enough to tell its error are left out.
    pub entries: usize,
    /// Entries that were left out.
    pub unseen: usize,
    /// Device seconds to a standard error of 1 %, median over the entries: shared and plain.
    pub seconds: [f64; 2],
    /// Median of the entries' ratios: how many times as long the plain one takes.
    pub ratio: f64,
}

/// Runs both estimators at one albedo; `progress(done, total)` counts columns.
///
/// # Errors
/// The driver's.
pub fn measure(
    device: &Device,
    albedo: f64,
    progress: &mut dyn FnMut(u64, u64),
) -> Result<Vec<EqualError>, TableError> {
    let stages = [Estimator::Shared, Estimator::Plain]
        .map(|estimator| Preintegrator::new(device, estimator, &[albedo], 1));
    let [shared, plain] = stages;
    let stages = [shared?, plain?];
    // The first dispatch compiles the shader.
    for stage in &stages {
        moments(stage, [1.0, 0.0], albedo, 1)?;
    }
    let mut found = Vec::new();
    let columns = GS.iter().flat_map(|g| SIGMAS.map(|s| [s, *g]));
    let total = (GS.len() * SIGMAS.len()) as u64;
    for (done, column) in (1..).zip(columns) {
        let shared = moments(&stages[0], column, albedo, BATCHES)?;
        let plain = moments(&stages[1], column, albedo, BATCHES)?;
        let regions = [[0.0, 45.0], [45.0, 135.0], [135.0, 180.1]];
        found.extend(
            regions
                .iter()
                .filter_map(|r| region(column, albedo, *r, &shared, &plain)),
        );
        progress(done, total);
    }
    Ok(found)
}

/// Means and variances of the mean of each angle, and device seconds.
struct Moments {
    entries: Vec<[f64; 2]>,
    seconds: f64,
}

const fn angles() -> Axis {
    Axis {
        count: ANGLES,
        min: 0.0,
        max: std::f64::consts::PI,
    }
}

fn moments(
    stage: &Preintegrator,
    column: [f64; 2],
    albedo: f64,
    batches: u32,
) -> Result<Moments, TableError> {
    let job = |batch| Job::new(column, albedo, [0.0, angles().step()], [7, batch]);
    let jobs: Vec<_> = (0..batches).map(job).collect();
    let mut sums = vec![[0.0; 2]; ANGLES];
    let seconds = stage.run(&jobs, |_, means| {
        for (sum, mean) in sums.iter_mut().zip(means) {
            let mean = f64::from(*mean);
            *sum = [sum[0] + mean, sum[1] + mean * mean];
        }
    })?;
    let count = f64::from(batches);
    let entry = |[sum, squares]: [f64; 2]| {
        let mean = sum / count;
        let variance = (squares / count - mean * mean).max(0.0) / (count - 1.0).max(1.0);
        [mean, variance]
    };
    Ok(Moments {
        entries: sums.into_iter().map(entry).collect(),
        seconds,
    })
}

fn region(
    [sigma_t, g]: [f64; 2],
    albedo: f64,
    angles_within: [f64; 2],
    shared: &Moments,
    plain: &Moments,
) -> Option<EqualError> {
    let scale = albedo * colliding(sigma_t);
    let (mut times, mut ratios, mut unseen) = ([Vec::new(), Vec::new()], Vec::new(), 0);
    for (theta, (a, b)) in angles()
        .nodes()
        .zip(shared.entries.iter().zip(&plain.entries))
    {
        let radiance = unscattered(theta, sigma_t, g) + scale * a[0];
        let degrees = theta.to_degrees();
        if radiance < DARK || degrees < angles_within[0] || degrees >= angles_within[1] {
            continue;
        }
        // Variance of batches that mostly bring nothing says nothing.
        if b[0] < 0.5 * radiance || b[1].sqrt() > 0.5 * radiance {
            unseen += 1;
            continue;
        }
        let needed = |variance: f64, seconds: f64| variance / (0.01 * radiance).powi(2) * seconds;
        let both = [
            needed(scale * scale * a[1], shared.seconds),
            needed(b[1], plain.seconds),
        ];
        times
            .iter_mut()
            .zip(both)
            .for_each(|(list, time)| list.push(time));
        ratios.push(both[1] / both[0].max(1e-30));
    }
    for list in times.iter_mut().chain([&mut ratios]) {
        list.sort_by(f64::total_cmp);
    }
    Some(EqualError {
        sigma_t,
        g,
        angles: angles_within,
        entries: ratios.len() + unseen,
        unseen,
        seconds: [quantile(&times[0], 0.5)?, quantile(&times[1], 0.5)?],
        ratio: quantile(&ratios, 0.5)?,
    })
}
