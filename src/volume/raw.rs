//! Headerless volumes.

use std::path::Path;

use glam::DVec3;

use super::payload::{Encoding, Payload, Start, first_bytes};
use super::source::{Source, check_dims, check_time};
use super::{Format, Grid, Header, Rescale, ScalarType, VolumeError};

/// Everything a headerless file does not say.
#[derive(Clone, Debug, PartialEq)]
pub struct RawLayout {
    /// Voxels along x (fastest), y, z.
    pub dims: [u32; 3],
    /// Stored type.
    pub scalar_type: ScalarType,
    /// World units between voxel centres; finite and positive.
    pub spacing: [f64; 3],
    /// Big-endian voxels.
    pub big_endian: bool,
    /// Bytes to skip before the first voxel; of the decoded data if the file is gzip.
    pub skip_bytes: u64,
}

/// Checks `layout`; `time` can only be 0. A file is gzip if it begins like one and is named `.gz`.
///
/// The first voxel's centre is at the world's origin.
pub(super) fn open(path: &Path, layout: &RawLayout, time: u32) -> Result<Source, VolumeError> {
    check_time(path, "raw layout", time, 1)?;
    let begins_as_gzip = first_bytes(path, 2)?.gzip;
    let named_gzip = path
        .extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("gz"));
    let dims = check_dims(
        path,
        "dims",
        layout.dims.map(i64::from),
        1,
        layout.scalar_type,
    )?;
    let spacing = DVec3::from_array(layout.spacing);
    if !layout.spacing.iter().all(|s| s.is_finite() && *s > 0.0) {
        let [x, y, z] = layout.spacing;
        let found = format!("{x} {y} {z}");
        let expected = "finite numbers above 0";
        return Err(VolumeError::field(path, "spacing", found, expected));
    }
    let encoding = match begins_as_gzip && named_gzip {
        true => Encoding::Gzip,
        false => Encoding::Raw,
    };
    Ok(Source {
        header: Header {
            grid: Grid::axis_aligned(dims, spacing, DVec3::ZERO),
            scalar_type: layout.scalar_type,
            rescale: Rescale::IDENTITY,
            format: Format::Raw,
            time_steps: 1,
            spatial_unit: None,
        },
        payload: Payload {
            path: path.to_owned(),
            encoding,
            start: Start::Offset(0),
            skip_bytes: layout.skip_bytes,
            skip_voxels: 0,
            dims,
            scalar_type: layout.scalar_type,
            big_endian: layout.big_endian,
        },
    })
}
