//! Builds tables: batches of paths, more where the error is large, until all columns are good enough.

use std::ops::ControlFlow;
use std::path::Path;
use std::time::{Duration, Instant};

use super::TableError;
use super::layout::{ANGLES, Job};
use super::record::{Estimator, JOBS, Preintegrator};
use super::state;
use super::sums::{Request, Sums};
use crate::gpu::Device;

/// Seconds between saved states.
const SAVE_EVERY: Duration = Duration::from_secs(20);

/// Builds until the requested errors are kept, or `progress(done, total)`, in batches, breaks. The total
/// is an estimate that grows better.
///
/// With a `state` file it goes on from what an interrupted build of the same request left there, and
/// removes the file when it is through. The same request gives the same bits, interrupted or not.
///
/// # Errors
/// The driver, or a state file that cannot be written or is of another request.
pub fn build(
    device: &Device,
    request: &Request,
    state: Option<&Path>,
    progress: &mut dyn FnMut(u64, u64) -> ControlFlow<()>,
) -> Result<Option<Sums>, TableError> {
    let kept = state.filter(|path| path.exists());
    let mut sums = match kept {
        Some(path) => state::load(path, request)?,
        None => Sums::new(request.clone()),
    };
    let stage = Preintegrator::new(device, Estimator::Shared, &request.albedos, request.seed)?;
    let mut saved = Instant::now();
    loop {
        let jobs = outstanding(&sums);
        let done = sums.batches.iter().map(|b| u64::from(*b)).sum::<u64>();
        let total = done + jobs.len() as u64;
        for (n, chunk) in jobs.chunks(JOBS).enumerate() {
            run(&stage, &mut sums, chunk)?;
            let done = done + (n * JOBS + chunk.len()) as u64;
            let broken = progress(done, total).is_break();
            if let Some(path) = state
                && (broken || saved.elapsed() > SAVE_EVERY)
            {
                state::save(path, &sums)?;
                saved = Instant::now();
            }
            if broken {
                return Ok(None);
            }
        }
        if !sums.plan() {
            break;
        }
    }
    if let Some(path) = state.filter(|path| path.exists()) {
        std::fs::remove_file(path).map_err(|source| TableError::io(path, "remove", source))?;
    }
    Ok(Some(sums))
}

/// Columns with the batches they lack, in order.
fn outstanding(sums: &Sums) -> Vec<(usize, u32)> {
    let columns = sums.batches.iter().zip(&sums.goals).enumerate();
    columns
        .flat_map(|(column, (done, goal))| (*done..*goal).map(move |batch| (column, batch)))
        .collect()
}

fn run(stage: &Preintegrator, sums: &mut Sums, batches: &[(usize, u32)]) -> Result<(), TableError> {
    let request = &sums.request;
    let angles = [request.grid.thetas.min, request.grid.thetas.step()];
    let job = |&(column, batch): &(usize, u32)| {
        let column_at = request.grid.column(column);
        Job::new(
            column_at,
            request.albedos[0],
            angles,
            [column as u32, batch],
        )
    };
    let jobs: Vec<_> = batches.iter().map(job).collect();
    stage.run(&jobs, |i, means| sums.add(batches[i].0, means, ANGLES))?;
    Ok(())
}
