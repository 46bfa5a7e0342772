//! `tyndall table` as a user runs it, as far as it needs no device.
#![allow(clippy::unwrap_used, clippy::panic)]

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use tyndall::technique::ambient_scattering::table::{Axis, Grid, Table, format};
use tyndall::technique::phase_hg;

fn tyndall(folder: &Path, args: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_tyndall"));
    command.current_dir(folder).arg("table").args(args);
    command.output().unwrap()
}

fn done(folder: &Path, args: &[&str]) -> String {
    let output = tyndall(folder, args);
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{args:?}: {message}");
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn fails(folder: &Path, args: &[&str], words: &[&str]) {
    let output = tyndall(folder, args);
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(!output.status.success(), "{args:?}");
    for word in words {
        let found = message.contains(word) && !message.contains("panicked");
        assert!(found, "{args:?}: `{word}` is not in\n{message}");
    }
}

/// A table of a few entries in a folder; every angle darker than the one before.
fn small(folder: &Path) -> Table {
    let axis = |count, min, max| Axis { count, min, max };
    let grid = Grid {
        thetas: axis(5, 0.0, std::f64::consts::PI),
        sigmas: axis(3, 0.0, 20.0),
        gs: axis(3, -0.8, 0.8),
    };
    let value = |i: usize| {
        let [sigma_t, g] = grid.column(i / 5);
        (phase_hg(grid.thetas.node(i % 5).cos(), g) * (-0.1 * sigma_t).exp()) as f32
    };
    let table = Table {
        albedo: 0.85,
        samples: 7,
        grid,
        radiance: (0..grid.len()).map(value).collect(),
        standard_error: Vec::new(),
    };
    format::write(folder, &table).unwrap();
    table
}

#[test]
fn tables_are_read_written_and_plotted() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let table = small(&at("published"));
    done(
        folder.path(),
        &["--from", "published", "-o", "copy", "--plot", "plot.svg"],
    );
    let copy = format::read(&at("copy")).unwrap();
    assert_eq!(copy.radiance, table.radiance);
    assert_eq!((copy.albedo, copy.samples), (0.85, 7));
    let names = fs::read_dir(at("copy")).unwrap();
    let mut names: Vec<_> = names
        .map(|e| e.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    let expected = ["g-08", "g00", "g08"].map(|g| format!("AVSTable2D_a0.85_{g}.tab"));
    assert_eq!(names, expected);
    let svg = fs::read_to_string(at("plot.svg")).unwrap();
    assert!(svg.starts_with("<svg ") && svg.ends_with("</svg>\n"));
    assert!(svg.contains("Preintegration table, albedo 0.85"));
    for words in ["g = -0.8", "g = 0<", "g = 0.8", "radiance, 1/sr"] {
        assert!(svg.contains(words), "{words}");
    }
    assert_eq!(svg.matches("data:image/png;base64,iVBOR").count(), 3);
    // One slice stands for all g, so its panels are alike but for what is known in closed form.
    done(
        folder.path(),
        &[
            "--from",
            "copy/AVSTable2D_a0.85_g00.tab",
            "--plot",
            "one.svg",
        ],
    );
    assert!(fs::read_to_string(at("one.svg")).unwrap() != svg);
}

#[test]
fn the_shipped_table_is_plotted() {
    let folder = tempfile::tempdir().unwrap();
    done(folder.path(), &["--plot", "shipped.svg"]);
    let svg = fs::read_to_string(folder.path().join("shipped.svg")).unwrap();
    assert!(svg.contains("Preintegration table, albedo 0.9"));
}

#[test]
fn what_cannot_be_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |args: &[&str], words: &[&str]| fails(folder.path(), args, words);
    small(&folder.path().join("t"));
    refused(&[], &["nothing to do", "--plot"]);
    refused(&["--from", "none.tab", "--plot", "a.svg"], &["none.tab"]);
    fs::create_dir(folder.path().join("empty")).unwrap();
    let args = ["--from", "empty", "-o", "out"];
    refused(&args, &["empty", "AVSTable2D_"]);
    refused(
        &["--from", "t", "-o", "out", "--albedo", "0.5"],
        &["--albedo"],
    );
    refused(&["--from", "t", "--plot", "no/a.svg"], &["no/a.svg"]);
    refused(&["--albedo", "1.5", "-o", "out"], &["1.5", "0 to 1"]);
    assert!(!folder.path().join("out").exists());
}
