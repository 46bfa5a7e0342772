//! Which array of the file is the volume, and where it stands.

use super::Element;
use super::markup::Markup;
use crate::volume::{ScalarType, VolumeError};

/// What the values belong to.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Place {
    Points,
    Cells,
}

/// How an array is written.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Written {
    Text,
    Base64,
    Raw,
}

/// The array that is the volume.
pub(super) struct Array {
    pub(super) place: Place,
    pub(super) scalar_type: ScalarType,
    pub(super) written: Written,
    /// Where in the file its data begins, and how many bytes of the file it can take at most.
    pub(super) start: u64,
    pub(super) bytes: u64,
}

/// Takes the active scalars, or else the first array of one component, of the points, then of the cells.
pub(super) fn choose(piece: &Element<'_>, markup: &Markup) -> Result<Array, VolumeError> {
    let mut seen = Vec::new();
    for (name, place) in [("PointData", Place::Points), ("CellData", Place::Cells)] {
        for data in piece.children(name) {
            let scalars = data.node.attribute("Scalars");
            let one: Vec<_> = data.children("DataArray").filter(is_scalar).collect();
            let active =
                |a: &&Element<'_>| scalars.is_some() && a.node.attribute("Name") == scalars;
            if let Some(array) = one.iter().find(active).or(one.first()) {
                return locate(array, place, markup);
            }
            seen.extend(data.children("DataArray").map(|a| {
                let attribute = |key| a.node.attribute(key).unwrap_or("?");
                let components = attribute("NumberOfComponents");
                format!("{} of {components} components", attribute("Name"))
            }));
        }
    }
    let found = match seen.is_empty() {
        true => "no array".to_owned(),
        false => seen.join(", ").chars().take(200).collect(),
    };
    let expected = "an array of one component of the points or cells";
    Err(VolumeError::field(piece.path, "DataArray", found, expected))
}

fn is_scalar(array: &Element<'_>) -> bool {
    let components = array.node.attribute("NumberOfComponents");
    components.is_none_or(|n| matches!(n.trim(), "1" | ""))
}

fn locate(array: &Element<'_>, place: Place, markup: &Markup) -> Result<Array, VolumeError> {
    let inline = || {
        let (start, end) = markup.inline(array.node).unwrap_or_default();
        (start, end - start)
    };
    let (written, (start, bytes)) = match array.node.attribute("format") {
        Some("ascii") => (Written::Text, inline()),
        Some("binary") => (Written::Base64, inline()),
        Some("appended") => appended(array, markup)?,
        _ => return Err(array.error("format", "ascii, binary or appended")),
    };
    Ok(Array {
        place,
        scalar_type: scalar_type(array)?,
        written,
        start,
        bytes,
    })
}

fn appended(array: &Element<'_>, markup: &Markup) -> Result<(Written, (u64, u64)), VolumeError> {
    let root = Element {
        node: array.node.document().root_element(),
        ..*array
    };
    let (Some(data), Some(first)) = (root.children("AppendedData").next(), markup.appended) else {
        let expected = "one after the ImageData, which an array refers to";
        let found = "no such element";
        return Err(VolumeError::field(
            array.path,
            "AppendedData",
            found,
            expected,
        ));
    };
    let written = match data.node.attribute("encoding") {
        Some("raw") => Written::Raw,
        // What VTK takes it for when nothing is said.
        None | Some("base64") => Written::Base64,
        _ => return Err(data.error("encoding", "raw or base64")),
    };
    let expected = format!("a whole number of bytes inside the file of {}", markup.len);
    let offset = array.node.attribute("offset");
    let start = offset
        .and_then(|o| o.trim().parse::<u64>().ok())
        .and_then(|o| first.checked_add(o))
        .filter(|start| *start < markup.len)
        .ok_or_else(|| array.error("offset", expected))?;
    Ok((written, (start, markup.len - start)))
}

fn scalar_type(array: &Element<'_>) -> Result<ScalarType, VolumeError> {
    Ok(match array.node.attribute("type") {
        Some("UInt8") => ScalarType::U8,
        Some("Int8") => ScalarType::I8,
        Some("UInt16") => ScalarType::U16,
        Some("Int16") => ScalarType::I16,
        Some("UInt32") => ScalarType::U32,
        Some("Int32") => ScalarType::I32,
        Some("Float32") => ScalarType::F32,
        Some("Float64") => ScalarType::F64,
        _ => {
            let expected = "UInt8, Int8, UInt16, Int16, UInt32, Int32, Float32 or Float64";
            return Err(array.error("type", expected));
        }
    })
}
