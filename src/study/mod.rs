//! Speed against accuracy: every technique over its own knobs, beside a converged reference.
//!
//! | step | file |
//! |---|---|
//! | what is tried: a scene and each technique's settings | `subject` |
//! | what results are filed under: hashes of all that decides them | `key` |
//! | the reference, rendered once and kept on disk | `reference` |
//! | one setting, timed and compared | `measure` |
//! | one line a finished setting, so that a study can go on | `journal` |
//! | all settings of a scene | `run` |
//! | which settings no other beats | `front` |
//! | the setting that suits a limit, from measurements of a small image | `choose` |
//! | CSV, JSON and a page | `report` |

mod choose;
mod error;
mod front;
mod journal;
mod key;
mod measure;
mod reference;
mod report;
mod run;
mod shrink;
mod subject;

pub use choose::{Candidate, Goal, Missed, Search, extrapolate};
pub use error::StudyError;
pub use front::front;
pub use journal::Journal;
pub use measure::{Errors, Measured, Outcome, Record, Stage, compare};
pub use reference::{About, Cache, Reference, ReferenceGoal};
pub use report::{Report, SceneReport, escape, plot, to_csv, to_html, write};
pub use run::{Pictures, Settings, run_scene};
pub use shrink::{fitting, shrink};
pub use subject::{Configuration, Setting, Subject, Variant, expand};
