//! Choosing the reader of a file.

use std::path::Path;

use serde::Serialize;

use super::{Header, RawLayout, Volume, VolumeError};

/// The file formats read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Format {
    /// Nearly raw raster data, `.nrrd` or `.nhdr`.
    Nrrd,
    /// MetaImage, `.mha` or `.mhd`.
    MetaImage,
    /// NIfTI-1, `.nii` or `.nii.gz`.
    Nifti,
    /// Headerless, described by a [`RawLayout`].
    Raw,
}

/// What the user says about a file beyond its name.
#[derive(Clone, Debug, Default)]
pub struct ReadOptions {
    /// Layout of a headerless file; required for it, an error for formats with a header.
    pub raw: Option<RawLayout>,
    /// Time step of a 4D file, from 0.
    pub time: u32,
}

/// Called with (decoded bytes so far, decoded bytes in all) while voxels are read.
pub type Progress<'a> = &'a mut dyn FnMut(u64, u64);

/// Reads only the header.
///
/// # Errors
/// As [`read`].
pub fn read_header(path: &Path, options: &ReadOptions) -> Result<Header, VolumeError> {
    let _ = options;
    Err(VolumeError::UnknownFormat {
        path: path.to_owned(),
        expected: "",
    })
}

/// Reads a volume file.
///
/// # Errors
/// Names the file, the field, what was found and what was expected.
pub fn read(
    path: &Path,
    options: &ReadOptions,
    progress: Progress<'_>,
) -> Result<Volume, VolumeError> {
    let _ = (options, progress);
    Err(VolumeError::UnknownFormat {
        path: path.to_owned(),
        expected: "",
    })
}
