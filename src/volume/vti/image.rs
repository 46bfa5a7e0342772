//! The image: its extent and its place in the world.

use glam::{DVec3, UVec3};

use super::Element;
use super::arrays::Place;
use crate::volume::source::{affine_grid, check_spacing};
use crate::volume::{Grid, Space, VolumeError};

/// The `ImageData` element, checked, and its only piece.
pub(super) struct Image<'a> {
    element: Element<'a>,
    pub(super) piece: Element<'a>,
    // First and last point along x, y, z; the last is not before the first.
    extent: [(i64, i64); 3],
    origin: DVec3,
    // World steps from point to point.
    columns: [DVec3; 3],
}

/// Finds and checks the image and its piece.
pub(super) fn find<'a>(root: &Element<'a>) -> Result<Image<'a>, VolumeError> {
    let element = root.children("ImageData").next();
    let element = element.ok_or_else(|| {
        VolumeError::field(root.path, "ImageData", "no such element", "one element")
    })?;
    let extent = extent(&element, "WholeExtent")?;
    let mut pieces = element.children("Piece");
    let (Some(piece), None) = (pieces.next(), pieces.next()) else {
        let found = format!("{} pieces", element.children("Piece").count());
        let expected = "one piece that is the whole extent";
        return Err(VolumeError::field(root.path, "Piece", found, expected));
    };
    let part = match piece.node.has_attribute("Extent") {
        true => self::extent(&piece, "Extent")?,
        false => extent,
    };
    if part != extent {
        let whole = element.node.attribute("WholeExtent").unwrap_or_default();
        return Err(piece.error("Extent", format!("the whole extent, \"{whole}\"")));
    }
    let (origin, columns) = placement(&element)?;
    Ok(Image {
        element,
        piece,
        extent,
        origin,
        columns,
    })
}

fn extent(element: &Element<'_>, attribute: &str) -> Result<[(i64, i64); 3], VolumeError> {
    let expected = "6 whole numbers, x0 x1 y0 y1 z0 z1, each last one at least the first";
    let numbers: Option<[i32; 6]> = element.numbers(attribute, expected)?;
    let numbers = numbers.ok_or_else(|| element.error(attribute, expected))?;
    let [x0, x1, y0, y1, z0, z1] = numbers.map(i64::from);
    let extent = [(x0, x1), (y0, y1), (z0, z1)];
    match extent.iter().all(|(first, last)| first <= last) {
        true => Ok(extent),
        false => Err(element.error(attribute, expected)),
    }
}

/// World position of the point with the indices 0, and the steps from point to point.
fn placement(element: &Element<'_>) -> Result<(DVec3, [DVec3; 3]), VolumeError> {
    let path = element.path;
    let three = "3 numbers";
    let spacing = element.numbers("Spacing", three)?.unwrap_or([1.0; 3]);
    let spacing = check_spacing(path, "ImageData Spacing", spacing)?;
    let origin = element.numbers("Origin", three)?.unwrap_or([0.0; 3]);
    // Row by row; the columns are the directions of the axes.
    let identity = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
    let m: [f64; 9] = element
        .numbers("Direction", "9 numbers, row by row")?
        .unwrap_or(identity);
    let column = |i: usize| DVec3::new(m[i], m[i + 3], m[i + 6]) * spacing[i];
    Ok((DVec3::from_array(origin), [column(0), column(1), column(2)]))
}

impl Image<'_> {
    /// Values along x, y, z, before any check.
    pub(super) fn sizes(&self, place: Place) -> [i64; 3] {
        self.extent
            .map(|e| e.1 - e.0 + i64::from(!between(place, e)))
    }

    /// The grid of the values, of which there are `dims`.
    pub(super) fn grid(&self, place: Place, dims: UVec3) -> Result<Grid, VolumeError> {
        let [x, y, z] = self.columns;
        let first = self
            .extent
            .map(|e| e.0 as f64 + if between(place, e) { 0.5 } else { 0.0 });
        let centre = self.origin + x * first[0] + y * first[1] + z * first[2];
        let field = match self.element.node.has_attribute("Direction") {
            true => "ImageData Direction",
            false => "ImageData Origin",
        };
        let path = self.element.path;
        affine_grid(path, field, dims, self.columns, centre, Space::Unspecified)
    }
}

/// Whether values stand between the points. A flat axis of cells has one cell, on its points.
fn between(place: Place, (first, last): (i64, i64)) -> bool {
    place == Place::Cells && last > first
}
