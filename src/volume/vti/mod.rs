//! VTK's XML image data, `.vti`.
//!
//! Read: one piece that is the whole extent; the active scalars, or else the first array of one
//! component, of the points, or of the cells where the points have none; written as text, in base64
//! or as appended bytes, plain or in zlib blocks, in either byte order. Points are voxel centres, as
//! cells' centres are where cells hold the data. The axes are kept as they are. The format is described at
//! <https://docs.vtk.org/en/latest/design_documents/VTKFileFormats.html>.

mod arrays;
mod image;
mod markup;

use std::path::Path;

use super::header_text::shown;
use super::payload::{Encoding, Payload, Start, Vtk, VtkLayout};
use super::source::{Source, check_dims, check_time};
use super::{Format, Header, Rescale, VolumeError};
use arrays::{Array, Written};
use markup::Markup;

/// Whether these first bytes of a file begin a VTK XML file.
pub(super) fn is_header(bytes: &[u8]) -> bool {
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let text = text.trim_ascii_start();
    text.starts_with(b"<VTKFile")
        || (text.starts_with(b"<?xml") && text.windows(8).any(|w| w == b"<VTKFile"))
}

/// An element of the header, with what errors need.
#[derive(Clone, Copy)]
struct Element<'a> {
    path: &'a Path,
    node: roxmltree::Node<'a, 'a>,
}

impl<'a> Element<'a> {
    fn name(&self) -> &'a str {
        self.node.tag_name().name()
    }

    fn children(self, name: &'static str) -> impl Iterator<Item = Self> {
        let here = self.node.children().filter(move |n| n.has_tag_name(name));
        here.map(move |node| Self { node, ..self })
    }

    /// An error that blames an attribute and quotes its value.
    fn error(&self, attribute: &str, expected: impl Into<String>) -> VolumeError {
        let found = self.node.attribute(attribute);
        let found = found.map_or_else(|| "no such attribute".to_owned(), shown);
        let field = format!("{} {attribute}", self.name());
        VolumeError::field(self.path, field, found, expected)
    }

    /// The value of an attribute as exactly `N` numbers, if it is there.
    fn numbers<T: std::str::FromStr, const N: usize>(
        &self,
        attribute: &str,
        expected: &str,
    ) -> Result<Option<[T; N]>, VolumeError> {
        let Some(text) = self.node.attribute(attribute) else {
            return Ok(None);
        };
        let parsed: Result<Vec<T>, _> = text.split_whitespace().map(str::parse).collect();
        let array = parsed.ok().and_then(|v| <[T; N]>::try_from(v).ok());
        array
            .map(Some)
            .ok_or_else(|| self.error(attribute, expected))
    }
}

/// What the file's first element says of all its arrays.
struct File {
    big_endian: bool,
    wide: bool,
    zlib: bool,
}

/// Reads and checks the header of `path`; `time` can only be 0.
pub(super) fn open(path: &Path, time: u32) -> Result<Source, VolumeError> {
    let markup = Markup::read(path)?;
    let document = markup.parse(path)?;
    let root = Element {
        path,
        node: document.root_element(),
    };
    check_time(path, "ImageData", time, 1)?;
    let file = file(&root)?;
    let image = image::find(&root)?;
    let array = arrays::choose(&image.piece, &markup)?;
    let scalar_type = array.scalar_type;
    let sizes = image.sizes(array.place);
    let dims = check_dims(path, "WholeExtent", sizes, 1, scalar_type)?;
    let encoding = Encoding::Vtk(layout(&array, &file));
    Ok(Source {
        payload: Payload {
            path: path.to_owned(),
            encoding,
            start: Start::Offset(array.start),
            skip_bytes: 0,
            skip_voxels: 0,
            dims,
            scalar_type,
            big_endian: file.big_endian,
        },
        header: Header {
            grid: image.grid(array.place, dims)?,
            scalar_type,
            rescale: Rescale::IDENTITY,
            format: Format::Vti,
            time_steps: 1,
            spatial_unit: None,
        },
    })
}

fn layout(array: &Array, file: &File) -> Vtk {
    let bytes = |base64| VtkLayout::Bytes {
        base64,
        zlib: file.zlib,
        wide: file.wide,
        big_endian: file.big_endian,
    };
    Vtk {
        layout: match array.written {
            Written::Text => VtkLayout::Text,
            Written::Base64 => bytes(true),
            Written::Raw => bytes(false),
        },
        bytes: array.bytes,
    }
}

fn file(root: &Element<'_>) -> Result<File, VolumeError> {
    if root.name() != "VTKFile" {
        let found = shown(root.name());
        return Err(VolumeError::field(
            root.path,
            "first element",
            found,
            "VTKFile",
        ));
    }
    if root.node.attribute("type") != Some("ImageData") {
        return Err(root.error("type", "ImageData"));
    }
    Ok(File {
        big_endian: match root.node.attribute("byte_order") {
            None | Some("LittleEndian") => false,
            Some("BigEndian") => true,
            _ => return Err(root.error("byte_order", "LittleEndian or BigEndian")),
        },
        wide: match root.node.attribute("header_type") {
            None | Some("UInt32") => false,
            Some("UInt64") => true,
            _ => return Err(root.error("header_type", "UInt32 or UInt64")),
        },
        zlib: match root.node.attribute("compressor") {
            None | Some("") => false,
            Some("vtkZLibDataCompressor") => true,
            _ => return Err(root.error("compressor", "vtkZLibDataCompressor or none")),
        },
    })
}
