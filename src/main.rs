//! The `tyndall` command.

use std::process::ExitCode;

fn main() -> ExitCode {
    tyndall::cli::main()
}
