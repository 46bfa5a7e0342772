//! From the axes of an NRRD to the world.

use glam::DVec3;

use super::axes::{Axes, quoted, vectors};
use crate::volume::header_text::Fields;
use crate::volume::source::{affine_grid, check_spacing};
use crate::volume::{Grid, Space, VolumeError};

/// The grid of a header.
///
/// Without `space directions` the axes are aligned and `spacings` (or `axis mins` and `axis maxs`)
/// scale them; without any of these a voxel measures 1. Without `space origin`, `axis mins` places
/// the first voxel: its centre, or its lower border where the axis' centering is `cell`.
/// The centering changes nothing else: a spacing is the distance between voxel centres either way,
/// and the volume's box always reaches half a voxel beyond the outer ones.
pub(super) fn grid(fields: &Fields, axes: &Axes) -> Result<Grid, VolumeError> {
    let (flip, space) = space(fields)?;
    let cell = cell_centred(fields, axes)?;
    let mins = per_axis(fields, axes, "axis mins")?;
    let (field, columns) = match axes.directions {
        Some(columns) => ("space directions", columns),
        None => {
            let (field, spacing) = spacing(fields, axes, mins, cell)?;
            let columns = [
                DVec3::X * spacing.x,
                DVec3::Y * spacing.y,
                DVec3::Z * spacing.z,
            ];
            (field, columns)
        }
    };
    let origin = match fields.text("space origin") {
        Some(text) => match vectors(text).as_deref() {
            Some([Some(origin)]) => *origin,
            _ => return Err(fields.error("space origin", "one vector (x,y,z)")),
        },
        None if axes.directions.is_none() => {
            let spacing = DVec3::new(columns[0].x, columns[1].y, columns[2].z);
            let half = spacing * cell.unwrap_or(DVec3::ZERO) * 0.5;
            mins.map_or(DVec3::ZERO, |mins| mins + half)
        }
        None => DVec3::ZERO,
    };
    affine_grid(
        fields.path(),
        if origin.is_finite() {
            field
        } else {
            "space origin"
        },
        axes.dims,
        columns.map(|c| c * flip),
        origin * flip,
        space,
    )
}

/// The signs that bring the file's space to the world, and what the world's axes mean.
fn space(fields: &Fields) -> Result<(DVec3, Space), VolumeError> {
    let expected = "left-posterior-superior, right-anterior-superior, left-anterior-superior \
                    (LPS, RAS, LAS), scanner-xyz or 3D-right-handed";
    if let Some(n) = fields.parse::<u32>("space dimension", "3")?
        && n != 3
    {
        return Err(fields.error("space dimension", "3"));
    }
    let Some(name) = fields.text("space") else {
        return Ok((DVec3::ONE, Space::Unspecified));
    };
    let name = name.to_lowercase();
    if matches!(
        name.as_str(),
        "scanner-xyz" | "3d-right-handed" | "3d-left-handed"
    ) {
        return Ok((DVec3::ONE, Space::Unspecified));
    }
    // `left-posterior-superior` or, with the initials alone, `LPS`.
    let words: Vec<&str> = match name.contains('-') {
        true => name.split('-').collect(),
        false => name.split_inclusive(|_: char| true).collect(),
    };
    let ends = [
        ["right", "left"],
        ["anterior", "posterior"],
        ["superior", "inferior"],
    ];
    let signs: Vec<f64> = words
        .iter()
        .zip(ends)
        .filter_map(|(word, ends)| {
            let is = |end: &str| *word == end || (word.len() == 1 && end.starts_with(*word));
            let at = ends.iter().position(|end| is(end))?;
            Some(if at == 0 { 1.0 } else { -1.0 })
        })
        .collect();
    match signs[..] {
        [x, y, z] if words.len() == 3 => Ok((DVec3::new(x, y, z), Space::PatientRas)),
        _ => Err(fields.error("space", expected)),
    }
}

/// The spacing of a file without directions, with the field it comes from.
fn spacing(
    fields: &Fields,
    axes: &Axes,
    mins: Option<DVec3>,
    cell: Option<DVec3>,
) -> Result<(&'static str, DVec3), VolumeError> {
    let path = fields.path();
    if let Some(spacing) = per_axis(fields, axes, "spacings")? {
        let spacing = check_spacing(path, "spacings", spacing.to_array())?;
        return Ok(("spacings", spacing));
    }
    let maxs = per_axis(fields, axes, "axis maxs")?;
    let (Some(mins), Some(maxs)) = (mins, maxs) else {
        return Ok(("spacings", DVec3::ONE));
    };
    // n cells span n spacings, n nodes span n - 1.
    let intervals = axes.dims.as_dvec3() - 1.0 + cell.unwrap_or(DVec3::ZERO);
    let spacing = (maxs - mins) / intervals.max(DVec3::ONE);
    let spacing = check_spacing(path, "axis maxs", spacing.to_array())?;
    Ok(("axis maxs", spacing))
}

/// 1 for every spatial axis whose samples are cells, 0 for nodes or unknown.
fn cell_centred(fields: &Fields, axes: &Axes) -> Result<Option<DVec3>, VolumeError> {
    let Some(text) = fields.text("centerings") else {
        return Ok(None);
    };
    let words: Vec<&str> = text.split_whitespace().collect();
    let known = |w: &&str| matches!(*w, "cell" | "node" | "none" | "???");
    if words.len() != axes.count || !words.iter().all(known) {
        let expected = format!("{} of cell, node, ??? or none", axes.count);
        return Err(fields.error("centerings", expected));
    }
    let cell = axes
        .spatial
        .map(|axis| f64::from(u8::from(words[axis] == "cell")));
    Ok(Some(DVec3::from_array(cell)))
}

/// A field with one number for every axis, for the spatial ones.
fn per_axis(fields: &Fields, axes: &Axes, key: &str) -> Result<Option<DVec3>, VolumeError> {
    let expected = format!("{} numbers", axes.count);
    let Some(all) = fields.list::<f64>(key, &expected)? else {
        return Ok(None);
    };
    if all.len() != axes.count {
        return Err(fields.error(key, expected));
    }
    let values = DVec3::from_array(axes.spatial.map(|axis| all[axis]));
    if key != "spacings" && !values.is_finite() {
        return Err(fields.error(key, "finite numbers"));
    }
    Ok(Some(values))
}

/// The one unit of the world's axes: `space units`, or the spatial axes' `units`.
pub(super) fn unit(fields: &Fields, axes: &Axes) -> Result<Option<String>, VolumeError> {
    for (key, count) in [("space units", 3), ("units", axes.count)] {
        let all = quoted(fields, key)?;
        if all.is_empty() {
            continue;
        }
        if all.len() != count {
            return Err(fields.error(key, format!("{count} words in double quotes")));
        }
        let spatial = match count {
            4 => axes.spatial.map(|axis| all[axis]).to_vec(),
            _ => all,
        };
        let mut known = spatial.iter().filter(|u| !matches!(**u, "" | "???"));
        let Some(first) = known.next() else {
            continue;
        };
        if known.any(|u| u != first) {
            return Err(fields.error(key, "one unit for all spatial axes"));
        }
        return Ok(Some((*first).to_owned()));
    }
    Ok(None)
}
