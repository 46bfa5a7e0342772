//! Ranges of values, checked before anything is read or chosen.

use super::Rgb;
use super::check_medium::{perturbation, primitives};
use super::check_technique;
use super::error::Problem;
use super::height_field;
use super::spec::{EnvironmentSpec, ExposureSpec, LightSpec, RawSpec, SceneSpec};

/// The first value that is out of range.
pub(super) fn check(s: &SceneSpec) -> Result<(), Problem> {
    volume(s)?;
    height_field::check(s)?;
    transfer_function(s)?;
    let m = &s.medium;
    at_least("medium.density_scale", m.density_scale, 0.0)?;
    within("medium.albedo", m.albedo, 0.0, 1.0)?;
    let colors = m.albedo_volume.as_ref();
    raw(
        "medium.albedo_volume.raw",
        colors.and_then(|c| c.raw.as_ref()),
    )?;
    at_least("medium.emission", m.emission, 0.0)?;
    within("medium.phase.g", m.phase.g, -0.99, 0.99)?;
    m.perturbation.as_ref().map_or(Ok(()), perturbation)?;
    for (i, light) in s.lights.iter().flatten().enumerate() {
        check_light(i, light)?;
    }
    camera(s)?;
    clip(s)?;
    image(s)?;
    check_technique::check(s)
}

fn volume(s: &SceneSpec) -> Result<(), Problem> {
    let v = &s.volume;
    exclusive(
        "volume",
        &[
            ("file", v.file.is_some()),
            ("procedural", v.procedural.is_some()),
            ("height_field", v.height_field.is_some()),
        ],
    )?;
    if let Some(p) = &v.procedural {
        within(
            "volume.procedural.resolution",
            p.resolution.map(f64::from),
            1.0,
            1024.0,
        )?;
    }
    if v.file.is_none() && (v.raw.is_some() || v.time.is_some()) {
        let key = if v.raw.is_some() {
            "volume.raw"
        } else {
            "volume.time"
        };
        return Err(Problem::new(
            key,
            "stands without `volume.file`, which it describes",
        ));
    }
    raw("volume.raw", v.raw.as_ref())
}

fn raw(key: &str, raw: Option<&RawSpec>) -> Result<(), Problem> {
    let Some(raw) = raw else { return Ok(()) };
    for (i, n) in raw.dims.into_iter().enumerate() {
        let key = format!("{key}.dims.{i}");
        within(&key, Some(f64::from(n)), 1.0, f64::from(u32::MAX))?;
    }
    for (i, x) in raw.spacing.into_iter().flatten().enumerate() {
        positive(&format!("{key}.spacing.{i}"), Some(x))?;
    }
    Ok(())
}

fn transfer_function(s: &SceneSpec) -> Result<(), Problem> {
    let t = &s.transfer_function;
    let given = [
        ("preset", t.preset.is_some()),
        ("file", t.file.is_some()),
        ("points", t.points.is_some()),
        ("extinction", t.extinction.is_some()),
        ("primitives", t.primitives.is_some()),
    ];
    exclusive("transfer_function", &given)?;
    let per_distance = t.opacity_unit_distance.is_some();
    let units = [
        ("extinction", t.extinction.is_some()),
        ("opacity_unit_distance", per_distance),
    ];
    exclusive("transfer_function", &units)?;
    positive(
        "transfer_function.opacity_unit_distance",
        t.opacity_unit_distance,
    )?;
    let inline = t.points.is_some() || t.extinction.is_some() || t.primitives.is_some();
    if t.color_space.is_some() && !inline {
        return Err(Problem::new(
            "transfer_function.color_space",
            "stands without `points`, `extinction` or `primitives`, whose colours it describes",
        ));
    }
    t.primitives.as_deref().map_or(Ok(()), primitives)?;
    rows("points", t.points.as_deref().unwrap_or_default())?;
    let extinction = t.extinction.as_deref().unwrap_or_default();
    rows("extinction", extinction)
}

/// Rows of value, colour and opacity or extinction.
fn rows(name: &str, rows: &[[f64; 5]]) -> Result<(), Problem> {
    let mut before = f64::NEG_INFINITY;
    for (i, row) in rows.iter().enumerate() {
        let key = |column: usize| format!("transfer_function.{name}.{i}.{column}");
        finite(&key(0), Some(row[0]))?;
        if row[0] < before {
            return Err(Problem::new(
                &key(0),
                format!(
                    "found {} after {before}, expected values in ascending order",
                    row[0]
                ),
            ));
        }
        before = row[0];
        (1..4).try_for_each(|column| at_least(&key(column), Some(row[column]), 0.0))?;
        if name == "points" {
            within(&key(4), Some(row[4]), 0.0, 1.0)?;
        } else {
            at_least(&key(4), Some(row[4]), 0.0)?;
        }
    }
    Ok(())
}

fn check_light(i: usize, light: &LightSpec) -> Result<(), Problem> {
    let key = format!("lights.{i}");
    let given = [
        ("directional", light.directional.is_some()),
        ("point", light.point.is_some()),
        ("environment", light.environment.is_some()),
    ];
    exclusive(&key, &given)?;
    if let Some(d) = &light.directional {
        vector(
            &format!("{key}.directional.direction"),
            Some(d.direction),
            true,
        )?;
        color(&format!("{key}.directional.irradiance"), Some(d.irradiance))
    } else if let Some(p) = &light.point {
        vector(&format!("{key}.point.position"), Some(p.position), false)?;
        color(&format!("{key}.point.intensity"), Some(p.intensity))
    } else if let Some(e) = &light.environment {
        check_environment(&format!("{key}.environment"), e)
    } else {
        Err(Problem::new(
            &key,
            "found no kind, expected one of directional, point, environment",
        ))
    }
}

fn check_environment(key: &str, e: &EnvironmentSpec) -> Result<(), Problem> {
    let given = [
        ("radiance", e.radiance.is_some()),
        ("file", e.file.is_some()),
    ];
    exclusive(key, &given)?;
    if e.radiance.is_none() && e.file.is_none() {
        return Err(Problem::new(
            key,
            "found neither, expected one of radiance, file",
        ));
    }
    let of_file = [
        ("scale", e.scale.is_some()),
        ("rotation_deg", e.rotation_deg.is_some()),
        ("up", e.up.is_some()),
    ];
    if let Some((name, _)) = of_file.iter().find(|(_, given)| *given && e.file.is_none()) {
        return Err(Problem::new(
            &format!("{key}.{name}"),
            "stands without `file`, which it describes",
        ));
    }
    color(&format!("{key}.radiance"), e.radiance)?;
    color(&format!("{key}.scale"), e.scale)?;
    finite(&format!("{key}.rotation_deg"), e.rotation_deg)?;
    vector(&format!("{key}.up"), e.up, true)
}

fn camera(s: &SceneSpec) -> Result<(), Problem> {
    let c = &s.camera;
    for (key, given) in [
        ("azimuth_deg", c.azimuth_deg.is_some()),
        ("elevation_deg", c.elevation_deg.is_some()),
        ("zoom", c.zoom.is_some()),
    ] {
        exclusive("camera", &[("eye", c.eye.is_some()), (key, given)])?;
    }
    let lens = [
        ("vfov_deg", c.vfov_deg.is_some()),
        ("orthographic_height", c.orthographic_height.is_some()),
    ];
    exclusive("camera", &lens)?;
    vector("camera.eye", c.eye, false)?;
    vector("camera.target", c.target, false)?;
    vector("camera.up", c.up, true)?;
    within("camera.vfov_deg", c.vfov_deg, 1e-3, 179.0)?;
    positive("camera.orthographic_height", c.orthographic_height)?;
    finite("camera.azimuth_deg", c.azimuth_deg)?;
    within("camera.elevation_deg", c.elevation_deg, -90.0, 90.0)?;
    positive("camera.zoom", c.zoom)?;
    let vertical = c.elevation_deg.is_some_and(|e| e.abs() == 90.0);
    if vertical && c.up.is_some_and(|u| u[0] == 0.0 && u[1] == 0.0) {
        return Err(Problem::new(
            "camera.up",
            "found the viewing direction, expected a direction at an angle to it",
        ));
    }
    if let (Some(eye), Some(target)) = (c.eye, c.target) {
        let view = glam::DVec3::from(target) - glam::DVec3::from(eye);
        if view.length() == 0.0 {
            return Err(Problem::new(
                "camera.eye",
                "found the same point as `camera.target`, expected another",
            ));
        }
        let up = c.up.map_or(glam::DVec3::Z, glam::DVec3::from).normalize();
        if c.up.is_some() && view.normalize().cross(up).length() < 1e-6 {
            return Err(Problem::new(
                "camera.up",
                "found the viewing direction, expected a direction at an angle to it",
            ));
        }
    }
    Ok(())
}

fn clip(s: &SceneSpec) -> Result<(), Problem> {
    if let Some(b) = &s.clip.bounds {
        vector("clip.box.min", Some(b.min), false)?;
        vector("clip.box.max", Some(b.max), false)?;
        if let Some(i) = (0..3).find(|i| b.min[*i] >= b.max[*i]) {
            return Err(Problem::new(
                "clip.box.max",
                format!(
                    "found {} on axis {i}, expected more than the {} of `clip.box.min`",
                    b.max[i], b.min[i]
                ),
            ));
        }
    }
    if let Some(p) = &s.clip.plane {
        vector("clip.plane.point", Some(p.point), false)?;
        vector("clip.plane.normal", Some(p.normal), true)?;
    }
    Ok(())
}

fn image(s: &SceneSpec) -> Result<(), Problem> {
    let i = &s.image;
    within("image.width", i.width.map(f64::from), 1.0, 16384.0)?;
    within("image.height", i.height.map(f64::from), 1.0, 16384.0)?;
    within(
        "image.samples_per_axis",
        i.samples_per_axis.map(f64::from),
        1.0,
        16.0,
    )?;
    color("image.background", i.background)?;
    match i.exposure {
        Some(ExposureSpec::Stops(stops)) => {
            within("image.exposure", Some(f64::from(stops)), -100.0, 100.0)
        }
        _ => Ok(()),
    }
}

/// At most one of the alternatives may be given.
pub(super) fn exclusive(table: &str, given: &[(&str, bool)]) -> Result<(), Problem> {
    let found: Vec<_> = given.iter().filter(|g| g.1).map(|g| g.0).collect();
    match found[..] {
        [first, second, ..] => {
            let all: Vec<_> = given.iter().map(|g| g.0).collect();
            Err(Problem::new(
                &format!("{table}.{second}"),
                format!(
                    "found beside `{first}`, expected only one of {}",
                    all.join(" / ")
                ),
            ))
        }
        _ => Ok(()),
    }
}

pub(super) fn within(key: &str, value: Option<f64>, min: f64, max: f64) -> Result<(), Problem> {
    match value {
        Some(v) if !(min..=max).contains(&v) => Err(Problem::new(
            key,
            format!("found {v}, expected a number from {min} to {max}"),
        )),
        _ => Ok(()),
    }
}

pub(super) fn at_least(key: &str, value: Option<f64>, min: f64) -> Result<(), Problem> {
    match value {
        Some(v) if !(v >= min && v.is_finite()) => Err(Problem::new(
            key,
            format!("found {v}, expected a finite number of at least {min}"),
        )),
        _ => Ok(()),
    }
}

pub(super) fn positive(key: &str, value: Option<f64>) -> Result<(), Problem> {
    match value {
        Some(v) if !(v > 0.0 && v.is_finite()) => Err(Problem::new(
            key,
            format!("found {v}, expected a finite number above 0"),
        )),
        _ => Ok(()),
    }
}

pub(super) fn finite(key: &str, value: Option<f64>) -> Result<(), Problem> {
    match value {
        Some(v) if !v.is_finite() => Err(Problem::new(
            key,
            format!("found {v}, expected a finite number"),
        )),
        _ => Ok(()),
    }
}

pub(super) fn vector(key: &str, value: Option<[f64; 3]>, not_zero: bool) -> Result<(), Problem> {
    let Some(v) = value else { return Ok(()) };
    v.into_iter().try_for_each(|x| finite(key, Some(x)))?;
    if not_zero && v == [0.0; 3] {
        return Err(Problem::new(
            key,
            "found a vector of length 0, expected a direction",
        ));
    }
    Ok(())
}

fn color(key: &str, value: Option<Rgb>) -> Result<(), Problem> {
    let Some(Rgb(c)) = value else { return Ok(()) };
    c.to_array()
        .into_iter()
        .try_for_each(|x| at_least(key, Some(f64::from(x)), 0.0))
}
