//! `tyndall schema`.

use super::{CliError, print_json};

pub(super) fn run() -> Result<(), CliError> {
    print_json(&crate::scene::file::schema())
}
