//! `tyndall compile-shaders`.

use std::path::PathBuf;

use clap::Args;

use super::{CliError, print};
use crate::shaders::{compile_all, recompiled_differs};

/// Compile glsl/ into spirv/.
#[derive(Args)]
pub(super) struct CompileShadersArgs {
    /// Folder that holds glsl/ and spirv/.
    #[arg(long, default_value = ".")]
    root: PathBuf,
    /// Only compare: recompile in memory and fail if a committed module differs.
    #[arg(long)]
    check: bool,
}

pub(super) fn run(args: &CompileShadersArgs) -> Result<(), CliError> {
    if args.check {
        let differing = recompiled_differs(&args.root)?;
        if differing.is_empty() {
            return print("every module is what its source compiles to");
        }
        let list = differing.join(", ");
        return Err(CliError::Usage(format!(
            "stale modules: {list}; run `compile-shaders`"
        )));
    }
    let changed = compile_all(&args.root)?;
    print(&format!(
        "{} module(s) changed {}",
        changed.len(),
        changed.join(" ")
    ))
}
