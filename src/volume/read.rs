//! Choosing the reader of a file.

use std::path::{Path, PathBuf};

use serde::Serialize;

use super::payload::{Beginning, first_bytes};
use super::source::Source;
use super::{Header, RawLayout, Series, Volume, VolumeError, meta_image, nifti, nrrd, raw, vti};

/// The file formats read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Format {
    /// Nearly raw raster data, `.nrrd` or `.nhdr`.
    Nrrd,
    /// MetaImage, `.mha` or `.mhd`.
    MetaImage,
    /// NIfTI-1, `.nii`, `.nii.gz`, or a pair of `.hdr` and `.img`.
    Nifti,
    /// VTK's XML image data, `.vti`.
    Vti,
    /// Headerless, described by a [`RawLayout`].
    Raw,
}

/// What the user says about a file beyond its name.
#[derive(Clone, Debug, Default)]
pub struct ReadOptions {
    /// Layout of a headerless file, which needs one. Given for any other file it wins: the file is
    /// taken as headerless, and `skip_bytes` can pass over a header that no reader knows.
    pub raw: Option<RawLayout>,
    /// Time step of a 4D file or a series, from 0.
    pub time: u32,
}

/// Called with (decoded bytes so far, decoded bytes in all) while voxels are read.
///
/// Counts what has to be decoded, earlier time steps of a compressed file included. The last call
/// has both numbers equal.
pub type Progress<'a> = &'a mut dyn FnMut(u64, u64);

const FORMATS: &str = "NRRD (.nrrd, .nhdr), MetaImage (.mha, .mhd), NIfTI-1 (.nii, .nii.gz, .hdr), \
                       VTK image data (.vti), or headerless voxels with their layout (--dims X,Y,Z --type u8|... \
                       --spacing X,Y,Z --endian little|big); pictures (.png, .tif) are maps of heights, \
                       volume.height_field.file";

/// Reads only the header (of a [`Series`], that of the step [`ReadOptions::time`]): checks everything it says but the length of the voxel data.
///
/// The format is chosen by the file's first bytes (decoded, if it is gzip), else by its name's
/// ending; a [`ReadOptions::raw`] layout comes before both.
///
/// # Errors
/// Names the file, the field, what was found and what was expected.
pub fn read_header(path: &Path, options: &ReadOptions) -> Result<Header, VolumeError> {
    Ok(open(path, options)?.0.header)
}

/// Reads a volume file (of a 4D one or a [`Series`], the step [`ReadOptions::time`]), choosing the
/// format as [`read_header`] does.
///
/// Takes the decoded size in memory and a few MiB more. Bytes after the voxels are ignored; NaN and
/// infinite voxels are kept.
///
/// # Errors
/// As [`read_header`]; also if the voxel data is shorter than the header claims, or damaged, or
/// does not fit in memory. A claim that the file's length contradicts fails before anything is
/// allocated for it.
pub fn read(
    path: &Path,
    options: &ReadOptions,
    progress: Progress<'_>,
) -> Result<Volume, VolumeError> {
    let (Source { header, payload }, file) = open(path, options)?;
    Ok(Volume {
        name: file
            .file_name()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned(),
        grid: header.grid,
        voxels: payload.read(progress)?,
        rescale: header.rescale,
        spatial_unit: header.spatial_unit,
        height_field: None,
    })
}

/// The source of the wanted step, and the file it is in.
fn open(path: &Path, options: &ReadOptions) -> Result<(Source, PathBuf), VolumeError> {
    let Some(series) = Series::find(path)? else {
        return Ok((open_file(path, options)?, path.to_owned()));
    };
    let step = options.time;
    let alone = ReadOptions {
        time: 0,
        ..options.clone()
    };
    let file = series.file(step)?;
    let mut source = open_file(file, &alone)?;
    let first = match step {
        0 => source.header.clone(),
        _ => open_file(series.file(0)?, &alone)?.header,
    };
    series.check(step, &source.header, &first)?;
    source.header.time_steps = series.steps();
    Ok((source, file.to_owned()))
}

fn open_file(path: &Path, options: &ReadOptions) -> Result<Source, VolumeError> {
    if let Some(layout) = &options.raw {
        return raw::open(path, layout, options.time);
    }
    match detect(path)? {
        Format::Nrrd => nrrd::open(path, options.time),
        Format::MetaImage => meta_image::open(path, options.time),
        Format::Nifti => nifti::open(path, options.time),
        Format::Vti => vti::open(path, options.time),
        Format::Raw => Err(VolumeError::field(
            path,
            "layout of the headerless file",
            "none given",
            "--dims X,Y,Z --type u8|i8|u16|i16|u32|i32|f32|f64 --spacing X,Y,Z \
             --endian little|big, and --skip BYTES if something precedes the voxels",
        )),
    }
}

/// The format by the file's first bytes, else by the ending of its name.
fn detect(path: &Path) -> Result<Format, VolumeError> {
    let Beginning { bytes, gzip, .. } = first_bytes(path, 512)?;
    if nifti::is_header(&bytes) {
        return Ok(Format::Nifti);
    }
    if !gzip && bytes.starts_with(b"NRRD") {
        return Ok(Format::Nrrd);
    }
    if !gzip && bytes.trim_ascii_start().starts_with(b"ObjectType") {
        return Ok(Format::MetaImage);
    }
    if !gzip && vti::is_header(&bytes) {
        return Ok(Format::Vti);
    }
    let name = path.to_string_lossy().to_lowercase();
    let ends = |endings: &[&str]| endings.iter().any(|end| name.ends_with(end));
    if ends(&[".nrrd", ".nhdr"]) {
        Ok(Format::Nrrd)
    } else if ends(&[".mha", ".mhd"]) {
        Ok(Format::MetaImage)
    } else if ends(&[".nii", ".nii.gz", ".hdr", ".hdr.gz"]) {
        Ok(Format::Nifti)
    } else if ends(&[".vti"]) {
        Ok(Format::Vti)
    } else if ends(&[".raw", ".bin", ".raw.gz", ".bin.gz"]) {
        Ok(Format::Raw)
    } else {
        Err(VolumeError::UnknownFormat {
            path: path.to_owned(),
            expected: FORMATS,
        })
    }
}
