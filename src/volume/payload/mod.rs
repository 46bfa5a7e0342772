//! The voxels of a file: located, decoded and brought to native endianness.
//!
//! Bytes are decoded straight into the typed array, so that loading takes the decoded size and
//! little more. What a header claims is compared with the file's length before anything is
//! allocated; where compression hides the true size, the array grows with the data that arrives.

mod decode;
mod decoder;
mod text;
mod vtk;

use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::str::FromStr;

use bytemuck::Pod;
use glam::UVec3;

use decoder::Decoder;
use text::TextError;
pub(super) use vtk::{Vtk, VtkLayout};

use super::header_text::shown;
use super::read::Progress;
use super::source::open_regular;
use super::{ScalarType, VolumeError, Voxels};

const FIELD: &str = "voxel data";

/// How the voxels are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    /// Bytes as in memory.
    Raw,
    /// Numbers between white space.
    Text,
    /// Deflate in gzip members.
    Gzip,
    /// Deflate in one zlib stream.
    Zlib,
    /// Bzip2 streams.
    Bzip2,
    /// An array of a VTK XML file.
    Vtk(Vtk),
}

impl Encoding {
    fn name(self) -> &'static str {
        match self {
            Self::Raw => "raw",
            Self::Text => "text",
            Self::Gzip => "gzip",
            Self::Zlib => "zlib",
            Self::Bzip2 => "bzip2",
            Self::Vtk(vtk) => vtk.name(),
        }
    }
}

/// Where the encoded voxels begin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Start {
    /// Bytes from the start of the file.
    Offset(u64),
    /// Bytes before the end of the file.
    BeforeEnd(u64),
}

/// Where and how the wanted voxels are stored.
#[derive(Clone, Debug)]
pub(super) struct Payload {
    /// The file that holds them.
    pub path: PathBuf,
    /// How they are written.
    pub encoding: Encoding,
    /// Where the encoded data begins.
    pub start: Start,
    /// Bytes to pass over after `start`; of the decoded stream if it is compressed.
    pub skip_bytes: u64,
    /// Voxels (of earlier time steps) to pass over after that.
    pub skip_voxels: u64,
    /// Wanted voxels along x, y and z.
    pub dims: UVec3,
    /// Their type.
    pub scalar_type: ScalarType,
    /// Whether their bytes are in big-endian order.
    pub big_endian: bool,
}

/// The sizes of a payload, in bytes unless said otherwise.
#[derive(Clone, Copy)]
struct Size {
    /// Wanted voxels.
    voxels: usize,
    /// What the wanted voxels take when decoded.
    wanted: u64,
    /// What is passed over before them, when decoded.
    skip: u64,
}

impl Payload {
    /// Decodes the wanted voxels.
    pub(super) fn read(&self, progress: Progress<'_>) -> Result<Voxels, VolumeError> {
        Ok(match self.scalar_type {
            ScalarType::U8 => Voxels::U8(self.decode(progress)?),
            ScalarType::I8 => Voxels::I8(self.decode(progress)?),
            ScalarType::U16 => Voxels::U16(self.decode(progress)?),
            ScalarType::I16 => Voxels::I16(self.decode(progress)?),
            ScalarType::U32 => Voxels::U32(self.decode(progress)?),
            ScalarType::I32 => Voxels::I32(self.decode(progress)?),
            ScalarType::F32 => Voxels::F32(self.decode(progress)?),
            ScalarType::F64 => Voxels::F64(self.decode(progress)?),
        })
    }

    fn decode<T: Pod + FromStr>(&self, progress: Progress<'_>) -> Result<Vec<T>, VolumeError> {
        let size = self.size()?;
        let (mut file, len) = open_regular(&self.path)?;
        let start = self.check_length(size, len)?;
        file.seek(SeekFrom::Start(start))
            .map_err(|e| VolumeError::io(&self.path, "read", e))?;
        match self.encoding {
            Encoding::Raw => self.read_raw(file, size, progress),
            Encoding::Text => {
                file.seek_relative(i64::try_from(self.skip_bytes).unwrap_or(i64::MAX))
                    .map_err(|e| VolumeError::io(&self.path, "read", e))?;
                self.read_text(BufReader::new(file), size, progress)
            }
            Encoding::Vtk(vtk) => self.read_vtk(vtk, file, size, progress),
            Encoding::Gzip | Encoding::Zlib | Encoding::Bzip2 => {
                let reader = BufReader::with_capacity(1 << 18, file);
                let decoder = Decoder::new(self.encoding, reader);
                self.read_compressed(decoder, size, progress)
            }
        }
    }

    fn size(&self) -> Result<Size, VolumeError> {
        let bytes = self.scalar_type.bytes() as u64;
        let count = self.dims.to_array().map(u64::from);
        let size = count
            .into_iter()
            .try_fold(1u64, u64::checked_mul)
            .and_then(|voxels| {
                let wanted = voxels.checked_mul(bytes)?;
                let skip = self.skip_voxels.checked_mul(bytes)?;
                let skip = skip.checked_add(self.skip_bytes)?;
                skip.checked_add(wanted)?;
                Some(Size {
                    voxels: usize::try_from(voxels).ok()?,
                    wanted,
                    skip,
                })
            });
        size.ok_or_else(|| self.error("more than 2^64 bytes".into(), "sizes a machine can hold"))
    }

    /// Compares the header's claim with the file's length; gives where the encoded data begins.
    fn check_length(&self, size: Size, len: u64) -> Result<u64, VolumeError> {
        let start = match self.start {
            Start::Offset(at) => at,
            Start::BeforeEnd(bytes) => len.checked_sub(bytes).ok_or_else(|| {
                let found = format!("a file of {len} bytes");
                self.error(found, &format!("at least {bytes} bytes"))
            })?,
        };
        let there = len.saturating_sub(start);
        let needed = size.skip + size.wanted;
        let (ok, found) = match self.encoding {
            Encoding::Raw => (
                there >= needed,
                format!("{there} bytes after offset {start} (truncated file?)"),
            ),
            Encoding::Vtk(vtk) => vtk.check_length(there, size.voxels as u64, needed),
            // A number and the space after it take 2 bytes at least.
            Encoding::Text => {
                let numbers = there.saturating_sub(self.skip_bytes).div_ceil(2);
                let claimed = self.skip_voxels.saturating_add(size.voxels as u64);
                (
                    numbers >= claimed,
                    format!("{there} bytes of text, which hold at most {numbers} numbers"),
                )
            }
            Encoding::Gzip | Encoding::Zlib | Encoding::Bzip2 => {
                let most = decoder::decoded_limit(self.encoding, there);
                let name = self.encoding.name();
                (
                    most >= needed,
                    format!(
                        "{there} bytes of {name} data, which decode to at most {most} bytes \
                         (truncated file?)"
                    ),
                )
            }
        };
        if ok && there > 0 {
            return Ok(start);
        }
        Err(self.error(found, &self.claim(size)))
    }

    fn stream_error(&self, error: io::Error, size: Size, done: u64) -> VolumeError {
        let Some(what) = damage(&error) else {
            return VolumeError::io(&self.path, "read", error);
        };
        let name = self.encoding.name();
        let found = format!("{what} {name} data after {done} decoded bytes");
        self.error(found, &self.claim(size))
    }

    fn text_error(&self, error: TextError, size: Size, index: usize) -> VolumeError {
        match error {
            TextError::End => {
                let found = format!("text that ends after {index} numbers (truncated file?)");
                self.error(found, &self.claim(size))
            }
            TextError::NotANumber(word) => {
                let found = format!("{} as value {index}", shown(&word));
                self.error(found, &format!("a number of type {}", self.scalar_type))
            }
            TextError::Io(e) => VolumeError::io(&self.path, "read", e),
        }
    }

    /// What the header promises.
    fn claim(&self, size: Size) -> String {
        let [x, y, z] = self.dims.to_array();
        let mut text = format!(
            "{} bytes for {x} × {y} × {z} voxels of {}",
            size.wanted, self.scalar_type
        );
        if size.skip > 0 {
            text += &format!(", after {} bytes to skip", size.skip);
        }
        text
    }

    fn error(&self, found: String, expected: &str) -> VolumeError {
        VolumeError::field(&self.path, FIELD, found, expected)
    }
}

/// What is wrong with a compressed stream, or nothing if the operating system is to blame.
fn damage(error: &io::Error) -> Option<&'static str> {
    match error.kind() {
        io::ErrorKind::UnexpectedEof => Some("truncated"),
        io::ErrorKind::InvalidInput | io::ErrorKind::InvalidData => Some("corrupt"),
        _ => None,
    }
}

/// The beginning of a file.
pub(super) struct Beginning {
    /// Its first bytes, decoded if it is gzip.
    pub bytes: Vec<u8>,
    /// Whether it is gzip.
    pub gzip: bool,
    /// What is wrong with the gzip stream, if that cut `bytes` short.
    pub damage: Option<&'static str>,
}

/// Reads the first `n` bytes of a file, fewer if it is shorter or damaged.
pub(super) fn first_bytes(path: &Path, n: u64) -> Result<Beginning, VolumeError> {
    let (mut file, _) = open_regular(path)?;
    let mut start = Beginning {
        bytes: Vec::new(),
        gzip: false,
        damage: None,
    };
    let io = |e| VolumeError::io(path, "read", e);
    let mut plain = file.by_ref().take(n);
    plain.read_to_end(&mut start.bytes).map_err(io)?;
    start.gzip = start.bytes.starts_with(&[0x1f, 0x8b]);
    if start.gzip {
        start.bytes.clear();
        file.seek(SeekFrom::Start(0)).map_err(io)?;
        let decoder = Decoder::new(Encoding::Gzip, BufReader::new(file));
        if let Err(e) = decoder.take(n).read_to_end(&mut start.bytes) {
            start.damage = damage(&e);
            if start.damage.is_none() {
                return Err(io(e));
            }
        }
    }
    Ok(start)
}
