//! Ranges of the techniques' parameters.

use super::error::Problem;
use super::spec::SceneSpec;
use super::spec_technique::{RadiusSpec, ShadingSpec, TransportSpec};
use super::validate::{at_least, finite, positive, within};

/// The first parameter that is out of range.
pub(super) fn check(s: &SceneSpec) -> Result<(), Problem> {
    path_trace(s)?;
    single_scatter(s)?;
    ambient_occlusion(s)?;
    ambient_scattering(s)?;
    half_angle(s)?;
    ray_march(s)
}

fn path_trace(s: &SceneSpec) -> Result<(), Problem> {
    let p = &s.technique.path_trace;
    let samples = p.samples.map(f64::from);
    within("technique.path_trace.samples", samples, 1.0, 1_048_576.0)?;
    positive("technique.path_trace.seconds", p.seconds)?;
    positive("technique.path_trace.target_error", p.target_error)?;
    let max_scatter = p.max_scatter.map(f64::from);
    at_least("technique.path_trace.max_scatter", max_scatter, 1.0)
}

fn single_scatter(s: &SceneSpec) -> Result<(), Problem> {
    let p = &s.technique.single_scatter;
    let key = |name: &str| format!("technique.single_scatter.{name}");
    within(&key("step"), p.step, 1.0 / 64.0, 64.0)?;
    within(&key("shadow_step"), p.shadow_step, 1.0 / 64.0, 64.0)?;
    within(&key("early_termination"), p.early_termination, 1e-6, 1.0)
}

fn ambient_occlusion(s: &SceneSpec) -> Result<(), Problem> {
    let p = &s.technique.ambient_occlusion;
    let key = |name: &str| format!("technique.ambient_occlusion.{name}");
    within(&key("step"), p.step, 1.0 / 64.0, 64.0)?;
    radius(&key("radius"), p.radius)?;
    within(&key("early_termination"), p.early_termination, 1e-6, 1.0)
}

fn ambient_scattering(s: &SceneSpec) -> Result<(), Problem> {
    let p = &s.technique.ambient_scattering;
    let key = |name: &str| format!("technique.ambient_scattering.{name}");
    within(&key("step"), p.step, 1.0 / 64.0, 64.0)?;
    radius(&key("radius"), p.radius)?;
    radius(&key("occlusion_radius"), p.occlusion_radius)?;
    at_least(&key("specular"), p.specular.map(f64::from), 0.0)?;
    within(&key("shininess"), p.shininess.map(f64::from), 1.0, 1000.0)?;
    within(&key("early_termination"), p.early_termination, 1e-6, 1.0)
}

fn half_angle(s: &SceneSpec) -> Result<(), Problem> {
    let p = &s.technique.half_angle;
    let key = |name: &str| format!("technique.half_angle.{name}");
    within(&key("slice_spacing"), p.slice_spacing, 1.0 / 64.0, 64.0)?;
    let texels = p.light_buffer.map(f64::from);
    within(&key("light_buffer"), texels, 1.0, 8192.0)?;
    within(&key("blur_angle_deg"), p.blur_angle_deg, 0.0, 170.0)?;
    if let Some(n) = p.blur_samples.filter(|n| ![4, 8, 16].contains(n)) {
        let message = format!("found {n}, expected 4, 8 or 16");
        return Err(Problem::new(&key("blur_samples"), message));
    }
    transport_color(&key("transport_color"), p.transport_color.as_ref())?;
    phase_table(&key("phase_table"), p.phase_table.as_deref())?;
    positive(&key("surface_gradient"), p.surface_gradient)?;
    at_least(&key("specular"), p.specular.map(f64::from), 0.0)?;
    within(&key("shininess"), p.shininess.map(f64::from), 1.0, 1000.0)?;
    within(&key("early_termination"), p.early_termination, 1e-6, 1.0)
}

fn transport_color(key: &str, spec: Option<&TransportSpec>) -> Result<(), Problem> {
    match spec {
        None | Some(TransportSpec::Word(_)) => Ok(()),
        Some(TransportSpec::Color(color)) => {
            (0..3).try_for_each(|c| within(&format!("{key}.{c}"), Some(color[c]), 0.0, 1.0))
        }
        Some(TransportSpec::Points(rows)) => {
            if rows.is_empty() {
                return Err(Problem::new(key, "found no rows, expected at least one"));
            }
            let mut before = f64::NEG_INFINITY;
            for (i, row) in rows.iter().enumerate() {
                finite(&format!("{key}.{i}.0"), Some(row[0]))?;
                if row[0] < before {
                    let found = format!(
                        "found {} after {before}, expected values in ascending order",
                        row[0]
                    );
                    return Err(Problem::new(&format!("{key}.{i}.0"), found));
                }
                before = row[0];
                (1..4)
                    .try_for_each(|c| within(&format!("{key}.{i}.{c}"), Some(row[c]), 0.0, 1.0))?;
            }
            Ok(())
        }
    }
}

fn phase_table(key: &str, rows: Option<&[[f64; 3]]>) -> Result<(), Problem> {
    let Some(rows) = rows else { return Ok(()) };
    if !(2..=1024).contains(&rows.len()) {
        let message = format!("found {} rows, expected 2 to 1024", rows.len());
        return Err(Problem::new(key, message));
    }
    for (i, row) in rows.iter().enumerate() {
        (0..3).try_for_each(|c| at_least(&format!("{key}.{i}.{c}"), Some(row[c]), 0.0))?;
    }
    if let Some(c) = (0..3).find(|c| rows.iter().all(|row| row[*c] <= 0.0)) {
        let message = format!("found only 0 in column {c}, expected light in some direction");
        return Err(Problem::new(key, message));
    }
    Ok(())
}

/// A sixty-fourth of a voxel and more: below, a tube has more steps than a shader can take.
fn radius(key: &str, radius: Option<RadiusSpec>) -> Result<(), Problem> {
    match radius {
        Some(RadiusSpec::Voxels(voxels)) => within(key, Some(voxels), 1.0 / 64.0, 65536.0),
        Some(RadiusSpec::World(length)) => positive(&format!("{key}.world"), Some(length.world)),
        _ => Ok(()),
    }
}

fn ray_march(s: &SceneSpec) -> Result<(), Problem> {
    let r = &s.technique.ray_march;
    within("technique.ray_march.step", r.step, 1.0 / 64.0, 64.0)?;
    within(
        "technique.ray_march.early_termination",
        r.early_termination,
        1e-6,
        1.0,
    )?;
    if let Some(ShadingSpec::Factors(f)) = r.shading {
        let key = |name: &str| format!("technique.ray_march.shading.{name}");
        at_least(&key("ambient"), f.ambient.map(f64::from), 0.0)?;
        at_least(&key("diffuse"), f.diffuse.map(f64::from), 0.0)?;
        at_least(&key("specular"), f.specular.map(f64::from), 0.0)?;
        within(&key("shininess"), f.shininess.map(f64::from), 1.0, 1000.0)?;
        let merge = f.merge_opacity.map(f64::from);
        within(&key("merge_opacity"), merge, 0.0, 1.0)?;
    }
    Ok(())
}
