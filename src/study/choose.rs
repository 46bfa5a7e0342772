//! The setting that suits a limit, from measurements of a small image.

use serde::Serialize;

use super::{Configuration, Measured, Record};

/// What is asked of an image.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Goal {
    /// The fastest setting whose mean LDR-FLIP is at most this.
    MaxFlip(f64),
    /// The most accurate setting whose frame takes at most this many seconds.
    BudgetSeconds(f64),
}

/// A setting with what is expected of it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Candidate {
    /// Technique and settings.
    #[serde(flatten)]
    pub configuration: Configuration,
    /// Mean LDR-FLIP of the small image.
    pub flip: f64,
    /// Seconds of a frame at the full size, extrapolated.
    pub seconds: f64,
}

/// A setting that was rendered and missed the goal.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Missed {
    /// The setting as it was expected to be.
    #[serde(flatten)]
    pub candidate: Candidate,
    /// Mean LDR-FLIP as found.
    pub found_flip: f64,
    /// Seconds of a frame as found.
    pub found_seconds: f64,
}

/// The search for a setting that keeps the goal.
#[derive(Clone, Debug)]
pub struct Search {
    goal: Goal,
    left: Vec<Candidate>,
    /// What was tried in vain.
    pub missed: Vec<Missed>,
}

/// Seconds of a frame with `ratio` times the pixels: stages that do not depend on the image keep their
/// time, everything else grows with the pixels.
#[must_use]
pub fn extrapolate(measured: &Measured, ratio: f64) -> f64 {
    let stages = measured.stages.iter().filter(|s| !s.grows_with_image);
    let fixed: f64 = stages.map(|s| s.seconds).sum();
    let fixed = fixed.min(measured.seconds);
    fixed + (measured.seconds - fixed) * ratio
}

impl Search {
    /// Begins with all that was measured of images with a `ratio`-th of the pixels.
    #[must_use]
    pub fn new(goal: Goal, records: &[Record], ratio: f64) -> Self {
        let candidate = |r: &Record| {
            r.outcome.measured().map(|m| Candidate {
                configuration: r.configuration.clone(),
                flip: m.errors.flip,
                seconds: extrapolate(m, ratio),
            })
        };
        Self {
            goal,
            left: records.iter().filter_map(candidate).collect(),
            missed: Vec::new(),
        }
    }

    /// How many of the settings not yet tried should keep the goal.
    #[must_use]
    pub fn promising(&self) -> usize {
        self.left.iter().filter(|c| self.keeps(c)).count()
    }

    /// The setting to try next; `None` if none is left that should keep the goal.
    #[must_use]
    pub fn best(&self) -> Option<&Candidate> {
        let promising = self.left.iter().filter(|c| self.keeps(c));
        promising.min_by(|a, b| match self.goal {
            Goal::MaxFlip(_) => order((a.seconds, a.flip), (b.seconds, b.flip)),
            Goal::BudgetSeconds(_) => order((a.flip, a.seconds), (b.flip, b.seconds)),
        })
    }

    /// Strikes out the setting that was tried, and corrects the times expected of its technique.
    pub fn miss(&mut self, tried: &Configuration, found_seconds: f64, found_flip: f64) {
        let Some(at) = self.left.iter().position(|c| c.configuration == *tried) else {
            return;
        };
        let candidate = self.left.remove(at);
        let correction = found_seconds / candidate.seconds;
        if correction.is_finite() && correction > 0.0 {
            let same = |c: &&mut Candidate| c.configuration.technique == tried.technique;
            let same = self.left.iter_mut().filter(same);
            same.for_each(|c| c.seconds *= correction);
        }
        self.missed.push(Missed {
            candidate,
            found_flip,
            found_seconds,
        });
    }

    /// The setting that comes nearest to the goal, as found where it was tried, and what it reaches: FLIP or
    /// seconds.
    #[must_use]
    pub fn nearest(&self) -> Option<(&Configuration, f64)> {
        let value = |flip, seconds| match self.goal {
            Goal::MaxFlip(_) => flip,
            Goal::BudgetSeconds(_) => seconds,
        };
        let left = self.left.iter();
        let left = left.map(|c| (&c.configuration, value(c.flip, c.seconds)));
        let missed = self.missed.iter().map(|m| {
            let found = value(m.found_flip, m.found_seconds);
            (&m.candidate.configuration, found)
        });
        left.chain(missed).min_by(|a, b| a.1.total_cmp(&b.1))
    }

    fn keeps(&self, candidate: &Candidate) -> bool {
        self.goal.is_kept(candidate.flip, candidate.seconds)
    }
}

impl Goal {
    /// Whether an image with this mean LDR-FLIP that took these seconds is what was asked for.
    #[must_use]
    pub fn is_kept(self, flip: f64, seconds: f64) -> bool {
        match self {
            Self::MaxFlip(limit) => flip <= limit,
            Self::BudgetSeconds(limit) => seconds <= limit,
        }
    }
}

fn order(a: (f64, f64), b: (f64, f64)) -> std::cmp::Ordering {
    a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1))
}
