//! Times of several frames in a few numbers.

use serde::Serialize;

use super::FrameReport;

/// Smallest, middle and largest of a series, in seconds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Spread {
    /// The smallest.
    pub min: f64,
    /// The middle, of an even number the mean of both in the middle.
    pub median: f64,
    /// The largest.
    pub max: f64,
}

/// How long a stage took in several frames.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StageSpread {
    /// `technique.stage`.
    pub name: String,
    /// Device seconds.
    pub seconds: Spread,
}

impl Spread {
    /// Of any number of times; of none, all are 0.
    #[must_use]
    pub fn of(mut times: Vec<f64>) -> Self {
        // The sum over no stages is -0.
        times.iter_mut().for_each(|t| *t += 0.0);
        times.sort_by(f64::total_cmp);
        let at = |i: usize| times.get(i).copied().unwrap_or(0.0);
        let n = times.len();
        let median = if n % 2 == 1 {
            at(n / 2)
        } else {
            0.5 * (at((n / 2).saturating_sub(1)) + at(n / 2))
        };
        Self {
            min: at(0),
            median,
            max: at(n.saturating_sub(1)),
        }
    }
}

/// The times of each stage that the first frame ran, in its order.
#[must_use]
pub fn stage_spreads(frames: &[FrameReport]) -> Vec<StageSpread> {
    let Some(first) = frames.first() else {
        return Vec::new();
    };
    let times = |name: &str| {
        let of = |frame: &FrameReport| {
            let stages = frame.stages.iter().filter(|s| s.name == name);
            stages.map(|s| s.seconds).sum()
        };
        frames.iter().map(of).collect()
    };
    let stages = first.stages.iter().map(|stage| StageSpread {
        name: stage.name.clone(),
        seconds: Spread::of(times(&stage.name)),
    });
    stages.collect()
}
