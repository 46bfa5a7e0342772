//! Progress bars on a terminal, silence elsewhere.

use std::io::IsTerminal;

use indicatif::{ProgressBar, ProgressStyle};

/// One bar that is reused for each phase of the work.
pub(super) struct Progress {
    bar: Option<ProgressBar>,
    phase: String,
}

impl Progress {
    /// A bar on standard error if that is a terminal and the user did not ask for quiet.
    pub(super) fn new(quiet: bool) -> Self {
        let bar = (!quiet && std::io::stderr().is_terminal()).then(|| {
            let bar = ProgressBar::new(0);
            let style = ProgressStyle::with_template("{msg:>10} [{bar:40}] {percent:>3}% {eta}");
            if let Ok(style) = style {
                bar.set_style(style.progress_chars("=> "));
            }
            bar
        });
        Self {
            bar,
            phase: String::new(),
        }
    }

    /// Shows that `done` of `total` of a phase is done.
    pub(super) fn update(&mut self, phase: &str, done: u64, total: u64) {
        let Some(bar) = &self.bar else { return };
        if self.phase != phase {
            self.phase = phase.to_owned();
            bar.reset();
            bar.set_message(self.phase.clone());
        }
        bar.set_length(total);
        bar.set_position(done);
    }

    /// Removes the bar.
    pub(super) fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}
