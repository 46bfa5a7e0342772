//! From NIfTI's three ways of placing voxels to the world.

use glam::{DMat3, DVec3, UVec3};

use super::Fields;
use crate::volume::source::affine_grid;
use crate::volume::{Grid, Space, VolumeError};

const PIXDIM: usize = 76;
const QUATERN_B: usize = 256;
const QOFFSET: usize = 268;
const SROW: usize = 280;

/// The grid: by `srow_*` if `sform_code` is positive, else by the quaternion if `qform_code` is,
/// else by `pixdim` alone, with the first voxel's centre at the origin.
pub(super) fn grid(fields: &Fields<'_>, dims: UVec3) -> Result<Grid, VolumeError> {
    if fields.i16(254) > 0 {
        return sform(fields, dims);
    }
    let spacing = spacing(fields)?;
    if fields.i16(252) > 0 {
        return qform(fields, dims, spacing);
    }
    affine_grid(
        fields.path,
        "pixdim",
        dims,
        [
            DVec3::X * spacing.x,
            DVec3::Y * spacing.y,
            DVec3::Z * spacing.z,
        ],
        DVec3::ZERO,
        Space::Unspecified,
    )
}

/// The world's unit by the low bits of `xyzt_units`.
pub(super) fn unit(fields: &Fields<'_>) -> Option<String> {
    let name = match fields.bytes[123] & 7 {
        1 => "m",
        2 => "mm",
        3 => "um",
        _ => return None,
    };
    Some(name.to_owned())
}

fn vector(fields: &Fields<'_>, at: usize) -> DVec3 {
    DVec3::from_array([0, 4, 8].map(|o| f64::from(fields.f32(at + o))))
}

/// `pixdim[1..3]`. Like other readers, takes 0 (unset) as 1 and the size of a negative one.
fn spacing(fields: &Fields<'_>) -> Result<DVec3, VolumeError> {
    let mut spacing = vector(fields, PIXDIM + 4).to_array();
    for (i, s) in spacing.iter_mut().enumerate() {
        if !s.is_finite() {
            let field = format!("pixdim[{}]", i + 1);
            return Err(fields.error(field, s.to_string(), "a finite number"));
        }
        *s = if *s == 0.0 { 1.0 } else { s.abs() };
    }
    Ok(DVec3::from_array(spacing))
}

fn sform(fields: &Fields<'_>, dims: UVec3) -> Result<Grid, VolumeError> {
    let rows = [0, 16, 32].map(|row| vector(fields, SROW + row));
    let offset = [12, 28, 44].map(|at| f64::from(fields.f32(SROW + at)));
    let columns = DMat3::from_cols(rows[0], rows[1], rows[2]).transpose();
    affine_grid(
        fields.path,
        "srow_x, srow_y, srow_z",
        dims,
        [columns.x_axis, columns.y_axis, columns.z_axis],
        DVec3::from_array(offset),
        Space::PatientRas,
    )
}

fn qform(fields: &Fields<'_>, dims: UVec3, spacing: DVec3) -> Result<Grid, VolumeError> {
    let q = vector(fields, QUATERN_B);
    let field = "quatern_b, quatern_c, quatern_d";
    if !q.is_finite() {
        return Err(fields.error(field, q.to_string(), "finite numbers"));
    }
    // The scalar part makes the quaternion's length 1; half a turn may exceed it by rounding.
    let rest = 1.0 - q.length_squared();
    if rest < -1e-3 {
        let expected = "parts of a unit quaternion";
        return Err(fields.error(field, q.to_string(), expected));
    }
    let [b, c, d, a] = glam::DVec4::from((q, rest.max(0.0).sqrt()))
        .normalize()
        .to_array();
    let rotation = DMat3::from_quat(glam::DQuat::from_xyzw(b, c, d, a));
    // pixdim[0] mirrors the third axis if it is negative; 0 counts as 1.
    let qfac = if fields.f32(PIXDIM) < 0.0 { -1.0 } else { 1.0 };
    affine_grid(
        fields.path,
        "qoffset_x, qoffset_y, qoffset_z",
        dims,
        [
            rotation.x_axis * spacing.x,
            rotation.y_axis * spacing.y,
            rotation.z_axis * spacing.z * qfac,
        ],
        vector(fields, QOFFSET),
        Space::PatientRas,
    )
}
