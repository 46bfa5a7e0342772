//! The files to compare, told apart by what is in them.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use crate::output::{Display, Image, OutputError, Variance, exr, png};

/// First bytes of the formats.
const EXR_MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];
const PNG_MAGIC: [u8; 4] = [0x89, b'P', b'N', b'G'];

/// A file to compare.
pub(super) enum Picture {
    /// An EXR.
    Radiance(Image, Option<Variance>),
    /// A PNG.
    Display(Display),
}

impl Picture {
    /// What it is, for messages.
    pub(super) const fn kind(&self) -> &'static str {
        match self {
            Self::Radiance(..) => "an EXR (radiance)",
            Self::Display(_) => "a PNG (display values)",
        }
    }
}

/// Reads an EXR or a PNG, whatever its name ends in.
pub(super) fn read(path: &Path) -> Result<Picture, OutputError> {
    match magic(path)? {
        EXR_MAGIC => Ok(Picture::Radiance(
            exr::read(path)?,
            exr::read_variance(path)?,
        )),
        PNG_MAGIC => Ok(Picture::Display(png::read(path)?)),
        other => Err(OutputError::Content {
            path: path.to_owned(),
            format: "an image",
            reason: format!("found the first bytes {other:02x?}, expected an EXR or a PNG"),
        }),
    }
}

/// The first four bytes; 0 where the file is shorter.
fn magic(path: &Path) -> Result<[u8; 4], OutputError> {
    let failed = |action| {
        move |source| OutputError::Io {
            path: path.to_owned(),
            action,
            source,
        }
    };
    let file = File::open(path).map_err(failed("open"))?;
    let mut bytes = Vec::new();
    file.take(4)
        .read_to_end(&mut bytes)
        .map_err(failed("read"))?;
    bytes.resize(4, 0);
    let mut magic = [0; 4];
    magic.copy_from_slice(&bytes);
    Ok(magic)
}
