//! Small volume files written by hand, for the tests of the readers.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    dead_code,
    unreachable_pub,
    reason = "each test binary uses a part of it"
)]

use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use tempfile::TempDir;
use tyndall::volume::{ReadOptions, ScalarType, read};

/// How a payload is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    Raw,
    Text,
    Gzip,
    Zlib,
    Bzip2,
}

/// `value as type`, in the given byte order.
pub fn scalar_bytes(value: f64, scalar_type: ScalarType, big: bool) -> Vec<u8> {
    macro_rules! bytes {
        ($t:ty) => {{
            let v = value as $t;
            if big {
                v.to_be_bytes().to_vec()
            } else {
                v.to_le_bytes().to_vec()
            }
        }};
    }
    match scalar_type {
        ScalarType::U8 => bytes!(u8),
        ScalarType::I8 => bytes!(i8),
        ScalarType::U16 => bytes!(u16),
        ScalarType::I16 => bytes!(i16),
        ScalarType::U32 => bytes!(u32),
        ScalarType::I32 => bytes!(i32),
        ScalarType::F32 => bytes!(f32),
        ScalarType::F64 => bytes!(f64),
    }
}

/// `n` values that the type holds exactly, its extremes first.
pub fn values(scalar_type: ScalarType, n: usize) -> Vec<f64> {
    let (lo, hi) = match scalar_type {
        ScalarType::U8 => (0.0, 255.0),
        ScalarType::I8 => (-128.0, 127.0),
        ScalarType::U16 => (0.0, 65535.0),
        ScalarType::I16 => (-32768.0, 32767.0),
        ScalarType::U32 => (0.0, f64::from(u32::MAX)),
        ScalarType::I32 => (f64::from(i32::MIN), f64::from(i32::MAX)),
        ScalarType::F32 => (f64::from(f32::MIN), f64::from(f32::MAX)),
        ScalarType::F64 => (f64::MIN, f64::MAX),
    };
    let mut out = vec![lo, hi];
    out.extend((2..n).map(|i| ((i * 37) % 121) as f64));
    out.truncate(n);
    out
}

/// The payload of `values`.
pub fn payload(values: &[f64], t: ScalarType, big: bool, encoding: Encoding) -> Vec<u8> {
    if encoding == Encoding::Text {
        let words: Vec<String> = values.iter().map(|v| format!("{v}")).collect();
        return words.join("\n ").into_bytes();
    }
    let raw: Vec<u8> = values
        .iter()
        .flat_map(|v| scalar_bytes(*v, t, big))
        .collect();
    compress(&raw, encoding)
}

/// `raw` compressed.
pub fn compress(raw: &[u8], encoding: Encoding) -> Vec<u8> {
    match encoding {
        Encoding::Raw | Encoding::Text => raw.to_vec(),
        Encoding::Gzip => {
            let mut e = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
            e.write_all(raw).unwrap();
            e.finish().unwrap()
        }
        Encoding::Zlib => {
            let mut e = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
            e.write_all(raw).unwrap();
            e.finish().unwrap()
        }
        Encoding::Bzip2 => {
            let mut e = bzip2::write::BzEncoder::new(Vec::new(), bzip2::Compression::fast());
            e.write_all(raw).unwrap();
            e.finish().unwrap()
        }
    }
}

/// Writes a file into `folder`.
pub fn write(folder: &Path, name: &str, parts: &[&[u8]]) -> PathBuf {
    let path = folder.join(name);
    std::fs::write(&path, parts.concat()).unwrap();
    path
}

/// A NIfTI-1 header under construction.
pub struct Nifti {
    pub bytes: Vec<u8>,
    pub big: bool,
}

impl Nifti {
    /// A valid single-file header: no sform, no qform, unit spacing.
    pub fn new(dims: &[i16], scalar_type: ScalarType, big: bool) -> Self {
        let mut h = Self {
            bytes: vec![0; 352],
            big,
        };
        let datatype = match scalar_type {
            ScalarType::U8 => 2,
            ScalarType::I16 => 4,
            ScalarType::I32 => 8,
            ScalarType::F32 => 16,
            ScalarType::F64 => 64,
            ScalarType::I8 => 256,
            ScalarType::U16 => 512,
            ScalarType::U32 => 768,
        };
        h.i32(0, 348);
        h.i16(40, dims.len() as i16);
        for axis in 0..7 {
            h.i16(42 + 2 * axis, dims.get(axis).copied().unwrap_or(1));
        }
        h.i16(70, datatype);
        h.i16(72, scalar_type.bytes() as i16 * 8);
        h.floats(76, &[1.0; 8]);
        h.floats(108, &[352.0, 1.0, 0.0]);
        h.bytes[344..348].copy_from_slice(b"n+1\0");
        h
    }

    pub fn i16(&mut self, at: usize, v: i16) {
        let b = if self.big {
            v.to_be_bytes()
        } else {
            v.to_le_bytes()
        };
        self.bytes[at..at + 2].copy_from_slice(&b);
    }

    pub fn i32(&mut self, at: usize, v: i32) {
        let b = if self.big {
            v.to_be_bytes()
        } else {
            v.to_le_bytes()
        };
        self.bytes[at..at + 4].copy_from_slice(&b);
    }

    pub fn floats(&mut self, at: usize, values: &[f32]) {
        for (i, v) in values.iter().enumerate() {
            let b = if self.big {
                v.to_be_bytes()
            } else {
                v.to_le_bytes()
            };
            self.bytes[at + 4 * i..at + 4 * i + 4].copy_from_slice(&b);
        }
    }
}

/// The NRRD name of a type.
pub fn nrrd_type(t: ScalarType) -> &'static str {
    match t {
        ScalarType::U8 => "unsigned char",
        ScalarType::I8 => "int8",
        ScalarType::U16 => "ushort",
        ScalarType::I16 => "short",
        ScalarType::U32 => "uint32_t",
        ScalarType::I32 => "int",
        ScalarType::F32 => "float",
        ScalarType::F64 => "double",
    }
}

/// The MetaImage name of a type.
pub fn meta_type(t: ScalarType) -> &'static str {
    match t {
        ScalarType::U8 => "MET_UCHAR",
        ScalarType::I8 => "MET_CHAR",
        ScalarType::U16 => "MET_USHORT",
        ScalarType::I16 => "MET_SHORT",
        ScalarType::U32 => "MET_UINT",
        ScalarType::I32 => "MET_INT",
        ScalarType::F32 => "MET_FLOAT",
        ScalarType::F64 => "MET_DOUBLE",
    }
}

/// Generous: hostile files take milliseconds.
pub const WATCHDOG: Duration = Duration::from_secs(10);

/// The message of the error that reading `path` must give, soon.
pub fn error_with(path: &Path, options: &ReadOptions) -> String {
    let start = Instant::now();
    let result = read(path, options, &mut |_, _| {});
    assert!(start.elapsed() < WATCHDOG, "took {:?}", start.elapsed());
    let message = result.err().unwrap_or_else(|| panic!("{path:?} was read"));
    message.to_string()
}

/// Reads `parts` as a file `name`, expects an error that names the file and has all `words`.
#[track_caller]
pub fn refused(name: &str, parts: &[&[u8]], words: &[&str]) {
    let dir = TempDir::new().unwrap();
    let path = write(dir.path(), name, parts);
    let message = error_with(&path, &ReadOptions::default());
    assert!(message.contains(name), "names no file: {message}");
    for word in words {
        assert!(message.contains(word), "no {word:?} in: {message}");
    }
}

/// An attached NRRD header.
pub fn nrrd(fields: &str) -> String {
    format!("NRRD0004\n{fields}\n\n")
}

/// A MetaImage header of 3 × 4 × 5 voxels of i16, with `fields` added.
pub fn good_meta(fields: &str, data: &str) -> String {
    format!(
        "ObjectType = Image\nNDims = 3\nBinaryDataByteOrderMSB = False\n{fields}\n\
         TransformMatrix = 1 0 0 0 1 0 0 0 1\nOffset = 1 2 3\nAnatomicalOrientation = RAI\n\
         ElementSpacing = 1 1 2.5\nDimSize = 3 4 5\nElementType = MET_SHORT\n\
         ElementDataFile = {data}\n"
    )
}

/// How a VTK image file is written.
#[derive(Clone, Copy, Debug)]
pub struct Vti {
    pub scalar_type: ScalarType,
    /// `ascii`, `binary`, `raw` or `base64` (the last two appended).
    pub format: &'static str,
    /// Bytes of a zlib block.
    pub zlib: Option<usize>,
    pub wide: bool,
    pub big: bool,
}

impl Vti {
    pub fn new(scalar_type: ScalarType, format: &'static str) -> Self {
        Self {
            scalar_type,
            format,
            zlib: None,
            wide: false,
            big: false,
        }
    }

    pub fn type_name(self) -> &'static str {
        match self.scalar_type {
            ScalarType::U8 => "UInt8",
            ScalarType::I8 => "Int8",
            ScalarType::U16 => "UInt16",
            ScalarType::I16 => "Int16",
            ScalarType::U32 => "UInt32",
            ScalarType::I32 => "Int32",
            ScalarType::F32 => "Float32",
            ScalarType::F64 => "Float64",
        }
    }

    /// Words of a header.
    pub fn words(self, words: &[u64]) -> Vec<u8> {
        let bytes = |w: &u64| {
            let mut b = match self.wide {
                true => w.to_le_bytes().to_vec(),
                false => u32::try_from(*w).unwrap().to_le_bytes().to_vec(),
            };
            if self.big {
                b.reverse();
            }
            b
        };
        words.iter().flat_map(bytes).collect()
    }

    /// Header and data of an array.
    pub fn data(self, values: &[f64]) -> Vec<u8> {
        if self.format == "ascii" {
            return payload(values, self.scalar_type, false, Encoding::Text);
        }
        let raw = payload(values, self.scalar_type, self.big, Encoding::Raw);
        let (header, data) = match self.zlib {
            None => (self.words(&[raw.len() as u64]), raw),
            Some(size) => {
                let blocks: Vec<_> = raw
                    .chunks(size)
                    .map(|b| compress(b, Encoding::Zlib))
                    .collect();
                let last = raw.len() % size;
                let mut words = vec![blocks.len() as u64, size as u64, last as u64];
                words.extend(blocks.iter().map(|b| b.len() as u64));
                (self.words(&words), blocks.concat())
            }
        };
        let encode = |b: &[u8]| base64::Engine::encode(&base64::prelude::BASE64_STANDARD, b);
        match (self.format, self.zlib) {
            ("raw", _) => [header, data].concat(),
            // VTK encodes the header of blocks apart from them.
            (_, Some(_)) => (encode(&header) + &encode(&data)).into_bytes(),
            _ => encode(&[header, data].concat()).into_bytes(),
        }
    }

    /// A whole file around the data of one array of the points.
    pub fn file(self, extent: &str, data: &[u8]) -> Vec<u8> {
        self.file_with(extent, "Spacing=\"1 1 1\"", "PointData", data)
    }

    /// The same with other attributes of the image, and points or cells.
    pub fn file_with(self, extent: &str, image: &str, place: &str, data: &[u8]) -> Vec<u8> {
        let (name, order) = (self.type_name(), if self.big { "Big" } else { "Little" });
        let zlib = self
            .zlib
            .map_or("", |_| " compressor=\"vtkZLibDataCompressor\"");
        let word = if self.wide { 64 } else { 32 };
        let appended = ["raw", "base64"].contains(&self.format);
        let mut text = format!(
            "<?xml version=\"1.0\"?>\n<!-- a > b \"quoted -->\n<VTKFile type=\"ImageData\" version=\"1.0\" \
             byte_order=\"{order}Endian\" header_type=\"UInt{word}\"{zlib}>\n\
             <ImageData WholeExtent=\"{extent}\" {image}>\n<Piece Extent=\"{extent}\">\n\
             <{place} Scalars=\"a\">\n<DataArray type=\"{name}\" Name=\"a\" "
        );
        text += &match appended {
            true => "format=\"appended\" offset=\"0\"/>".to_owned(),
            false => format!("format=\"{}\">\n", self.format),
        };
        let after = format!("</{place}>\n</Piece>\n</ImageData>\n");
        if appended {
            text += &format!("\n{after}<AppendedData encoding=\"{}\">\n _", self.format);
            let end = "\n</AppendedData>\n</VTKFile>\n";
            return [text.as_bytes(), data, end.as_bytes()].concat();
        }
        let end = format!("</DataArray>\n{after}</VTKFile>");
        [text.as_bytes(), data, end.as_bytes()].concat()
    }
}
