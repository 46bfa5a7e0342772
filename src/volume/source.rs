//! What every reader hands back, and the checks that are the same for all formats.

use std::fs::File;
use std::path::Path;

use glam::{DAffine3, DMat3, DVec3, UVec3};

use super::payload::Payload;
use super::{Grid, Header, ScalarType, Space, VolumeError};

/// A file whose header has been read and checked: what it says and where its voxels are.
#[derive(Debug)]
pub(super) struct Source {
    /// What the header says.
    pub header: Header,
    /// Where and how the wanted voxels are stored.
    pub payload: Payload,
}

/// Opens a regular file; gives it with its length in bytes.
///
/// Folders and named pipes are refused before opening: a pipe would block for ever.
pub(super) fn open_regular(path: &Path) -> Result<(File, u64), VolumeError> {
    let meta = std::fs::metadata(path).map_err(|e| VolumeError::io(path, "open", e))?;
    if !meta.is_file() {
        let found = if meta.is_dir() {
            "a folder"
        } else {
            "a device or pipe"
        };
        return Err(VolumeError::field(path, "file", found, "a regular file"));
    }
    let file = File::open(path).map_err(|e| VolumeError::io(path, "open", e))?;
    Ok((file, meta.len()))
}

/// Checks sizes along x, y and z: each 1 to 2³²−1, all `steps` steps together below 2⁶³ bytes.
pub(super) fn check_dims(
    path: &Path,
    field: &str,
    dims: [i64; 3],
    steps: u32,
    scalar_type: ScalarType,
) -> Result<UVec3, VolumeError> {
    let found = || format!("{} × {} × {}", dims[0], dims[1], dims[2]);
    let mut checked = [0u32; 3];
    for (to, from) in checked.iter_mut().zip(dims) {
        *to = u32::try_from(from).ok().filter(|n| *n > 0).ok_or_else(|| {
            VolumeError::field(path, field, found(), "sizes from 1 to 4294967295")
        })?;
    }
    let bytes = checked
        .iter()
        .map(|n| u64::from(*n))
        .chain([u64::from(steps), scalar_type.bytes() as u64])
        .try_fold(1u64, u64::checked_mul)
        .filter(|b| i64::try_from(*b).is_ok());
    if bytes.is_none() {
        let what = format!("{} voxels of {scalar_type}, {steps} step(s)", found());
        return Err(VolumeError::field(
            path,
            field,
            what,
            "fewer than 2^63 bytes in all",
        ));
    }
    Ok(UVec3::from_array(checked))
}

/// Builds the grid whose index axes step by `columns` in the world.
///
/// `field` names the header field that a degenerate or non-finite map is blamed on.
pub(super) fn affine_grid(
    path: &Path,
    field: &str,
    dims: UVec3,
    columns: [DVec3; 3],
    origin: DVec3,
    space: Space,
) -> Result<Grid, VolumeError> {
    let [x, y, z] = columns;
    let fail = |expected: &str| {
        let found = format!("directions {x} {y} {z} and origin {origin}");
        VolumeError::field(path, field, found, expected)
    };
    if !columns.iter().all(|c| c.is_finite()) || !origin.is_finite() {
        return Err(fail("finite numbers"));
    }
    let unit = columns.map(|c| c.try_normalize());
    let [Some(ux), Some(uy), Some(uz)] = unit else {
        return Err(fail("a spacing that is not 0 along every axis"));
    };
    // Below 1e-6 the three axes span no volume that single precision could still tell from a plane.
    if DMat3::from_cols(ux, uy, uz).determinant().abs() < 1e-6 {
        return Err(fail("three independent directions"));
    }
    let map = DAffine3::from_mat3_translation(DMat3::from_cols(x, y, z), origin);
    if !map.inverse().is_finite() {
        return Err(fail("spacings neither vanishing nor overflowing"));
    }
    Ok(Grid {
        dims,
        world_from_index: map,
        space,
    })
}

/// Checks the spacing that `field` gives: finite, not 0.
pub(super) fn check_spacing(
    path: &Path,
    field: &str,
    spacing: [f64; 3],
) -> Result<DVec3, VolumeError> {
    if spacing.iter().all(|s| s.is_finite() && *s != 0.0) {
        return Ok(DVec3::from_array(spacing));
    }
    let [x, y, z] = spacing;
    let found = format!("{x} {y} {z}");
    Err(VolumeError::field(
        path,
        field,
        found,
        "finite numbers other than 0",
    ))
}

/// Checks that time step `time` exists; `field` says where the file states its steps.
pub(super) fn check_time(
    path: &Path,
    field: &str,
    time: u32,
    steps: u32,
) -> Result<(), VolumeError> {
    if time < steps {
        return Ok(());
    }
    let expected = match steps {
        1 => "time step 0 (the file has no other)".to_owned(),
        n => format!("a time step from 0 to {}", n.saturating_sub(1)),
    };
    Err(VolumeError::field(
        path,
        field,
        format!("a request for time step {time}"),
        expected,
    ))
}
