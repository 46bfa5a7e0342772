//! `tyndall table --ship`: builds what `assets/tables/` holds.

use std::io::Write;
use std::path::Path;

use super::super::{CliError, Global, print, print_json};
use super::{build_shown, figures};
use crate::output::atomic;
use crate::technique::ambient_scattering::table::pack::{MAIN_ALBEDO, pack};
use crate::technique::ambient_scattering::table::shipped::{other_albedos, packed};
use crate::technique::ambient_scattering::table::{Grid, Request};

pub(super) fn run(global: &Global, path: &Path, json: bool) -> Result<(), CliError> {
    atomic::check(path)?;
    let state = |name| path.with_extension(name);
    let request = Request::new(vec![MAIN_ALBEDO], Grid::PAPER);
    let (main, seconds) = build_shown(global, &request, &state("main.sums"), "table")?;
    let others = build_shown(global, &other_albedos(), &state("others.sums"), "albedos")?;
    let bytes = pack(&packed(&main, &others.0)).map_err(CliError::Stdout)?;
    atomic::write(path, |file| file.write_all(&bytes))?;
    let parts = vec![
        ("albedo 0.9", &main, seconds),
        ("albedo 1, beside others", &others.0, others.1),
    ];
    let report = figures::Report::new(parts);
    figures::write(&path.with_extension("json"), &report)?;
    if json {
        return print_json(&report);
    }
    print(&figures::text(&report))
}
