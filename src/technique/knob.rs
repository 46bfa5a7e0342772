//! What a technique lets one trade speed for accuracy with.

use crate::scene::TechniqueParams;

/// A key of the scene file with the values that are worth trying, from coarse to fine.
///
/// A technique states its knobs in `knobs.rs` and adds them to the table beside its name; `tyndall
/// study` and `render --technique auto` then try them.
#[derive(Clone, Copy, Debug)]
pub struct Knob {
    /// A key of the technique's own table, or `image.samples_per_axis`.
    pub key: &'static str,
    /// Values as after `--set KEY=`, from coarse and fast to fine and slow.
    pub values: &'static [&'static str],
    /// Whether the knob changes anything, given the technique's other parameters.
    pub applies: fn(&TechniqueParams) -> bool,
}

/// A technique's knobs, as a study finds them.
#[derive(Clone, Copy, Debug)]
pub struct Knobs {
    /// The technique's name.
    pub technique: &'static str,
    /// What is tried.
    pub knobs: &'static [Knob],
    /// What its images lack beside those of `path_trace` at any setting, as half a sentence.
    pub lacks: Option<&'static str>,
}

impl Knob {
    /// The only key outside of a technique's table that a knob may turn.
    pub const SAMPLES_PER_AXIS: &'static str = "image.samples_per_axis";

    /// A knob that always applies.
    #[must_use]
    pub const fn new(key: &'static str, values: &'static [&'static str]) -> Self {
        Self {
            key,
            values,
            applies: always,
        }
    }
}

const fn always(_: &TechniqueParams) -> bool {
    true
}
