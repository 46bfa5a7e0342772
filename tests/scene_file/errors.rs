//! What is wrong is named with its place and the nearest valid name.

use std::path::Path;

use miette::Diagnostic;
use tyndall::scene::file::SceneFile;

use super::set;

fn fails(cases: &[(&str, &str)]) {
    for (text, expected) in cases {
        let message = set(text, &[]).expect_err(text).to_string();
        assert!(
            message.starts_with(&format!("s.toml:{expected}")),
            "{text}\n{message}\n{expected}"
        );
    }
}

#[test]
fn unknown_keys_name_their_place_and_the_nearest_key() {
    fails(&[
        (
            "[image]\nheight = 4\n  widht = 5",
            "3:3: image.widht: unknown key `widht`; did you mean `width`?",
        ),
        (
            "[tranfer_function]",
            "1:2: tranfer_function: unknown key `tranfer_function`; did you mean `transfer_function`?",
        ),
        (
            "[[lights]]\n[lights.directional]\ndirection = [0,0,1]\nirradience = 1",
            "4:1: lights.0.directional.irradience: unknown key `irradience`; did you mean `irradiance`?",
        ),
        (
            "camera = { fov_deg = 3 }",
            "1:12: camera.fov_deg: unknown key `fov_deg`; did you mean `vfov_deg`?",
        ),
        (
            "technique.ray_march.shading.shinines = 1",
            "1:29: technique.ray_march.shading.shinines: unknown key",
        ),
        (
            "# ü\n\"ü\" = 1",
            "2:1: ü: unknown key `ü`; expected one of camera",
        ),
    ]);
}

#[test]
fn wrong_types_name_what_was_found_and_expected() {
    fails(&[
        (
            "image.width = -3",
            "1:7: image.width: found integer `-3`, expected an integer",
        ),
        (
            "image.width = 'wide'",
            "1:7: image.width: found string \"wide\", expected an integer",
        ),
        (
            "image.width = 1.5",
            "1:7: image.width: found floating point `1.5`, expected an integer",
        ),
        (
            "image.width = 99999999999999999999",
            "1:15: found integer `99999999999999999999`",
        ),
        (
            "camera.vfov_deg = 'a'",
            "1:8: camera.vfov_deg: found string \"a\", expected a number",
        ),
        (
            "camera.eye = [0, 1]",
            "1:8: camera.eye: found an array of length 2, expected an array of length 3",
        ),
        (
            "camera.eye = [0, 'a', 1]",
            "1:18: camera.eye.1: found string \"a\", expected a number",
        ),
        (
            "technique.ray_march.shading = 1",
            "1:21: technique.ray_march.shading: found 1, expected true, false",
        ),
        (
            "image.exposure = 'automatic'",
            "1:7: image.exposure: found \"automatic\", expected `auto` or a number",
        ),
        (
            "image.tone_map = 'filmc'",
            "1:7: image.tone_map: found `filmc`, expected one of `clamp`, `reinhard`, `filmic`; did you mean `filmic`?",
        ),
        (
            "image = 3",
            "1:1: image: found integer `3`, expected a table",
        ),
        (
            "lights = 3",
            "1:1: lights: found integer `3`, expected an array",
        ),
        (
            "[volume]\nfile = 'a'\n[volume.raw]\ntype = 'u8'",
            "3:9: volume.raw: missing key `dims`",
        ),
        (
            "[[lights]]\nenvironment = {}",
            "2:1: lights.0.environment: found neither, expected one of radiance, file",
        ),
    ]);
    assert!(
        set(
            "image.exposure = 1\nmedium.albedo = 1\nimage.background = 1",
            &[]
        )
        .is_ok()
    );
}

#[test]
fn values_out_of_range_name_what_was_found_and_expected() {
    fails(&[
        (
            "[image]\nwidth = 0",
            "2:1: image.width: found 0, expected a number from 1 to 16384",
        ),
        (
            "[image]\nheight = 16385",
            "2:1: image.height: found 16385, expected",
        ),
        (
            "[medium]\nphase.g = 0.995",
            "2:7: medium.phase.g: found 0.995, expected a number from -0.99 to 0.99",
        ),
        (
            "medium.density_scale = nan",
            "1:8: medium.density_scale: found NaN, expected a finite number",
        ),
        (
            "camera.eye = [0, -inf, 1]",
            "1:8: camera.eye: found -inf, expected a finite number",
        ),
        (
            "[[lights]]\nenvironment = { radiance = 1, up = [0, 1, 0] }",
            "2:31: lights.0.environment.up: stands without `file`",
        ),
        (
            "[[lights]]\nenvironment = { radiance = 1, file = 'a.exr' }",
            "2:31: lights.0.environment.file: found beside `radiance`, expected only one of",
        ),
        (
            "[[lights]]\nenvironment = { file = 'a.exr', scale = -1 }",
            "2:33: lights.0.environment.scale: found -1",
        ),
        (
            "[medium.albedo_volume]\nfile = 'a'\nraw = { dims = [0, 1, 1], type = 'u8' }",
            "3:17: medium.albedo_volume.raw.dims.0: found 0",
        ),
        (
            "camera.zoom = 0",
            "1:8: camera.zoom: found 0, expected a finite number above 0",
        ),
        (
            "image.background = -1",
            "1:7: image.background: found -1, expected",
        ),
        (
            "transfer_function.opacity_unit_distance = 0",
            "1:19: transfer_function.opacity_unit_distance: found 0",
        ),
        (
            "[transfer_function]\npoints = [[1, 0, 0, 0, 0],\n [0, 0, 0, 0, 0]]",
            "3:3: transfer_function.points.1.0: found 0 after 1",
        ),
        (
            "[transfer_function]\npoints = [[1, 0, 0, 0, 1.5]]",
            "2:24: transfer_function.points.0.4: found 1.5",
        ),
        (
            "[transfer_function]\npoints = [[1, 0, -0.5, 0, 1]]",
            "2:18: transfer_function.points.0.2: found -0.5",
        ),
        (
            "[[lights]]\ndirectional = { direction = [0, 0, 0], irradiance = 1 }",
            "2:17: lights.0.directional.direction: found a vector of length 0",
        ),
        (
            "[clip.box]\nmin = [0, 0, 0]\nmax = [1, 0, 1]",
            "3:1: clip.box.max: found 0 on axis 1",
        ),
        (
            "[clip.plane]\npoint = [0, 0, 0]\nnormal = [0, 0, 0]",
            "3:1: clip.plane.normal: found a vector of length 0",
        ),
        (
            "[camera]\neye = [0, 0, 5]\ntarget = [0, 0, 0]\nup = [0, 0, 2]",
            "4:1: camera.up: found the viewing direction",
        ),
        (
            "[camera]\nelevation_deg = 90\nup = [0, 0, 1]",
            "3:1: camera.up: found the viewing direction",
        ),
        (
            "[camera]\neye = [1, 0, 5]\ntarget = [1, 0, 5]",
            "2:1: camera.eye: found the same point",
        ),
    ]);
}

#[test]
fn shapes_and_noise_name_what_was_found_and_expected() {
    let shape = |rest: &str| format!("[[transfer_function.primitives]]\nshape = {rest}");
    let octave = |rest: &str| format!("[medium.perturbation]\noctaves = [{rest}]");
    let cases = [
        (
            shape("'cone'\nvalue = [0, 1]\ncolor = [1, 1, 1]\nopacity = 1"),
            "2:1: transfer_function.primitives.0.shape: found `cone`, expected one of `box`",
        ),
        (
            shape("'box'\nvalue = [1, 1]\ncolor = [1, 1, 1]\nopacity = 1"),
            "3:1: transfer_function.primitives.0.value: found [1, 1], expected two numbers, the second above",
        ),
        (
            shape("'box'\nvalue = [0, inf]\ncolor = [1, 1, 1]\nopacity = 1"),
            "3:1: transfer_function.primitives.0.value: found inf, expected a finite number",
        ),
        (
            shape("'box'\nvalue = [-1e308, 1e308]\ncolor = [1, 1, 1]\nopacity = 1"),
            "3:1: transfer_function.primitives.0.value: found [",
        ),
        (
            shape("'box'\nvalue = [0, 1]\ngradient = [-1, 1]\ncolor = [1, 1, 1]\nopacity = 1"),
            "4:1: transfer_function.primitives.0.gradient: found -1, expected a finite number of at least 0",
        ),
        (
            shape("'gaussian'\nvalue = [0, 1]\ncolor = [1, 1, 1]\nopacity = 1"),
            "1:1: transfer_function.primitives.0.gradient: found none",
        ),
        (
            shape(
                "'triangle'\nvalue = [0, 1]\ngradient = [0, inf]\ncolor = [1, 1, 1]\nopacity = 1",
            ),
            "4:1: transfer_function.primitives.0.gradient: found inf, expected a finite number",
        ),
        (
            shape("'box'\nvalue = [0, nan]\ncolor = [1, 1, 1]\nopacity = 1"),
            "3:1: transfer_function.primitives.0.value: found NaN",
        ),
        (
            shape("'box'\nvalue = [0, 1]\ncolor = [1, -1, 1]\nopacity = 1"),
            "4:1: transfer_function.primitives.0.color: found -1",
        ),
        (
            shape("'box'\nvalue = [0, 1]\ncolor = [1, 1, 1]\nopacity = 2"),
            "5:1: transfer_function.primitives.0.opacity: found 2, expected a number from 0 to 1",
        ),
        (
            "[transfer_function]\nprimitives = []".to_owned(),
            "2:1: transfer_function.primitives: found 0 shapes, expected 1 to 256",
        ),
        (
            "[transfer_function]\nprimitives = []\npreset = 'ct_bone'".to_owned(),
            "2:1: transfer_function.primitives: found beside `preset`",
        ),
        (
            "[medium.perturbation]\noctaves = []".to_owned(),
            "2:1: medium.perturbation.octaves: found 0 octaves, expected 1 to 8",
        ),
        (
            "[medium.perturbation]\nseed = 1".to_owned(),
            "1:9: medium.perturbation: ",
        ),
        (
            octave("{ frequency = 0, displacement = 1 }"),
            "2:14: medium.perturbation.octaves.0.frequency: found 0, expected a finite number above 0",
        ),
        (
            octave("{ frequency = 1 }"),
            "2:12: medium.perturbation.octaves.0: found noise without effect",
        ),
        (
            octave("{ frequency = 1, displacement = inf }"),
            "2:29: medium.perturbation.octaves.0.displacement: found inf",
        ),
        (
            octave("{ frequency = 1, opacity = 0.7 }, { frequency = 2, opacity = 0.7 }"),
            "2:63: medium.perturbation.octaves.1.opacity: found 1.4 of all octaves together, expected at most 1",
        ),
        (
            octave("{ frequency = 1, color = [0, 1.5, 0] }"),
            "2:29: medium.perturbation.octaves.0.color: found 1.5",
        ),
        (
            octave("{ frequency = 1, opacity = 0.5, velocity = [0, nan, 0] }"),
            "2:44: medium.perturbation.octaves.0.velocity: found NaN",
        ),
    ];
    for (text, message) in &cases {
        fails(&[(text, message)]);
    }
    let many = octave(&["{ frequency = 1, displacement = 1 }"; 9].join(", "));
    fails(&[(&many, "2:1: medium.perturbation.octaves: found 9 octaves")]);
}

#[test]
fn values_of_half_angle_name_what_was_found_and_expected() {
    let key = "technique.half_angle";
    let cases = [
        (
            "slice_spacing = 0",
            "found 0, expected a number from 0.015625 to 64",
        ),
        (
            "light_buffer = 0",
            "found 0, expected a number from 1 to 8192",
        ),
        ("blur_samples = 5", "found 5, expected 4, 8 or 16"),
        (
            "blur_angle_deg = 180",
            "found 180, expected a number from 0 to 170",
        ),
        (
            "transport_color = [2, 0, 0]",
            "found 2, expected a number from 0 to 1",
        ),
        ("transport_color = []", "expected at least one"),
        (
            "transport_color = 'blue'",
            "expected `auto`, a colour [r, g, b]",
        ),
        (
            "transport_color = [[1, 0, 0, 0], [0, 0, 0, 0]]",
            "found 0 after 1, expected values in ascending order",
        ),
        (
            "phase_table = [[1, 1, 1]]",
            "found 1 rows, expected 2 to 1024",
        ),
        (
            "phase_table = [[1, 1, 0], [1, 1, 0]]",
            "found only 0 in column 2",
        ),
        ("phase_table = [[1, 1, -1], [1, 1, 1]]", "found -1"),
        (
            "surface_gradient = 0",
            "found 0, expected a finite number above 0",
        ),
    ];
    for (text, expected) in cases {
        let message = set(&format!("{key}.{text}"), &[])
            .expect_err(text)
            .to_string();
        let is_placed = message.starts_with("s.toml:1:");
        assert!(is_placed && message.contains(expected), "{text}\n{message}");
    }
}

#[test]
fn alternatives_exclude_each_other() {
    fails(&[
        (
            "[volume]\nfile = 'a'\nprocedural = {name = 'cloud'}",
            "3:1: volume.procedural: found beside `file`",
        ),
        (
            "[transfer_function]\npoints = []\npreset = 'ct_bone'",
            "2:1: transfer_function.points: found beside `preset`",
        ),
        (
            "[camera]\nzoom = 2\neye = [1, 2, 3]",
            "2:1: camera.zoom: found beside `eye`",
        ),
        (
            "[camera]\northographic_height = 2\nvfov_deg = 30",
            "2:1: camera.orthographic_height: found beside `vfov_deg`",
        ),
        (
            "[[lights]]",
            "1:1: lights.0: found no kind, expected one of directional",
        ),
        (
            "volume.time = 3",
            "1:8: volume.time: stands without `volume.file`",
        ),
    ]);
}

#[test]
fn syntax_errors_have_a_place() {
    fails(&[
        ("[image]\nwidth = \n", "2:9: "),
        ("a = 1\na = 2", "2:1: duplicate key"),
    ]);
}

#[test]
fn the_report_points_into_the_file() {
    let error = set("[image]\nwidht = 5\n", &[]).unwrap_err();
    assert!(error.source_code().is_some());
    let label = error.labels().unwrap().next().unwrap();
    assert_eq!((label.offset(), label.len()), (8, 5));
    let mut report = String::new();
    miette::GraphicalReportHandler::new_themed(miette::GraphicalTheme::unicode_nocolor())
        .render_report(&mut report, &error)
        .unwrap();
    assert!(
        report.contains("s.toml:2:1") && report.contains("widht = 5"),
        "{report}"
    );
}

#[test]
fn files_that_are_no_scenes_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, bytes: &[u8]| {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        path
    };
    let load = |path: &Path| SceneFile::load(path, &[]).unwrap_err().to_string();
    let message = load(&write("latin1.toml", b"# a\n# f\xfcr\n"));
    assert!(message.contains("not UTF-8 at 7"), "{message}");
    let message = load(&write("huge.toml", &vec![b' '; (16 << 20) + 1]));
    assert!(message.contains("more than 16 MiB"), "{message}");
    let message = load(&folder.path().join("absent.toml"));
    assert!(message.contains("absent.toml: cannot open"), "{message}");
    assert!(SceneFile::load(&write("empty.toml", b""), &[]).is_ok());
}
