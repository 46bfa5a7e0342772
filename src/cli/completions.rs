//! `tyndall completions`.

use clap::Args;
use clap_complete::Shell;

use super::{CliError, command, print};

/// Print a shell's completion script.
#[derive(Args)]
pub(super) struct CompletionsArgs {
    /// The shell.
    shell: Shell,
}

pub(super) fn run(args: &CompletionsArgs) -> Result<(), CliError> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut command(), "tyndall", &mut script);
    print(String::from_utf8_lossy(&script).trim_end())
}
