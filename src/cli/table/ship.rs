//! `tyndall table --ship`: builds what `assets/tables/` holds.

use std::io::Write;
use std::path::Path;

use super::super::{CliError, Global, print, print_json};
use super::{build_shown, figures};
use crate::output::atomic;
use crate::technique::ambient_scattering::table::pack::pack;
use crate::technique::ambient_scattering::table::shipped::{packed, requests};

pub(super) fn run(global: &Global, path: &Path, json: bool) -> Result<(), CliError> {
    atomic::check(path)?;
    let [a, b, c, d] = requests();
    let build = |i: usize, request| {
        let state = path.with_extension(format!("{i}.sums"));
        build_shown(global, &request, &state, &format!("table {i} of 4"))
    };
    let built = [build(1, a)?, build(2, b)?, build(3, c)?, build(4, d)?];
    let times = built.each_ref().map(|b| b.1);
    let sums = built.map(|b| b.0);
    let bytes = pack(&packed(&sums)).map_err(CliError::Stdout)?;
    atomic::write(path, |file| file.write_all(&bytes))?;
    let report = figures::Report::new(sums.iter().zip(times));
    figures::write(&path.with_extension("json"), &report)?;
    if json {
        return print_json(&report);
    }
    print(&figures::text(&report))
}
