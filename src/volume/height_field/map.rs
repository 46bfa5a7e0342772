//! From maps to a volume.

use std::path::Path;

use glam::{DAffine3, DMat3, DVec2, DVec3, UVec2, UVec3};

use super::HeightField;
use crate::volume::read::{ReadOptions, read};
use crate::volume::{Grid, Rescale, Space, Volume, VolumeError, Voxels, geo_tiff, picture};

/// Most layers of a grid: a field that is high and fine gets flat voxels.
const MOST_LAYERS: f64 = 4096.0;

/// Values over a plane.
#[derive(Clone, Debug)]
pub struct HeightMap {
    /// The file's or formula's name.
    pub name: String,
    /// Columns along x and y.
    pub dims: UVec2,
    /// Stored values, x fastest, the row of lowest y first.
    pub voxels: Voxels,
    /// Stored value to value.
    pub rescale: Rescale,
    /// World units between columns, where a file states them.
    pub spacing: Option<DVec2>,
    /// The world unit's name, if known.
    pub spatial_unit: Option<String>,
}

/// How a map becomes a medium; world units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sheet {
    /// Extent along x and y, > 0.
    pub size: DVec2,
    /// Height that a value of 1 stands for; not 0.
    pub height: f64,
    /// The medium about the surface.
    pub layer: Layer,
}

/// Where the medium is about a surface; world units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layer {
    /// Its lower face, from the surface.
    pub bottom: f64,
    /// Its upper face, from the surface; above `bottom`.
    pub top: f64,
    /// Distance from either face over which it rises to its full extinction, > 0.
    pub ramp: f64,
}

/// Whether single precision holds it.
fn is_height(world: f64) -> bool {
    world.abs() < f64::from(f32::MAX)
}

impl HeightMap {
    /// Reads a grey PNG picture, whose values are 0 (black) to 1, a grey TIFF, both with their upper edge towards largest
    /// y, or a volume file of one slice.
    ///
    /// # Errors
    /// Names the file, the field, what was found and what was expected.
    pub fn read(path: &Path, options: &ReadOptions) -> Result<Self, VolumeError> {
        if picture::is_png(path)? {
            return picture::read_grey(path);
        }
        if geo_tiff::is_tiff(path)? {
            return geo_tiff::read_map(path);
        }
        let volume = read(path, options, &mut |_, _| {})?;
        let (d, spacing) = (volume.grid.dims, volume.grid.spacing());
        if d.z != 1 {
            let found = format!("{} x {} x {} voxels", d.x, d.y, d.z);
            let expected = "one slice, which is a map of heights";
            return Err(VolumeError::field(path, "dimensions", found, expected));
        }
        Ok(Self {
            name: volume.name,
            dims: d.truncate(),
            voxels: volume.voxels,
            rescale: volume.rescale,
            spacing: Some(spacing.truncate()),
            spatial_unit: volume.spatial_unit,
        })
    }

    fn value(&self, index: usize) -> f64 {
        self.rescale.apply(self.voxels.get(index))
    }

    /// The medium about the map's surface: centred on the world's z axis, heights above z = 0. Its data values are the
    /// `scalars`', or the heights' own.
    ///
    /// # Errors
    /// A height is not finite or too large, or the scalars are of another size.
    pub fn volume(&self, scalars: Option<Self>, sheet: &Sheet) -> Result<Volume, String> {
        let count = self.dims.x as usize * self.dims.y as usize;
        let world: Vec<f64> = (0..count).map(|i| sheet.height * self.value(i)).collect();
        if let Some(i) = world.iter().position(|h| !is_height(*h)) {
            let (x, y) = (i % self.dims.x as usize, i / self.dims.x as usize);
            return Err(format!(
                "{}: found a height of {} at column {x}, {y}, expected finite heights: fill the holes of the map",
                self.name, world[i]
            ));
        }
        let scalars = match scalars {
            Some(map) if map.dims != self.dims => {
                return Err(format!(
                    "{}: found {} x {} values, expected the {} x {} of the heights in `{}`",
                    map.name, map.dims.x, map.dims.y, self.dims.x, self.dims.y, self.name
                ));
            }
            Some(map) => map,
            None => self.clone(),
        };
        let (grid, field) = self.layered(&world, sheet);
        Ok(Volume {
            name: self.name.clone(),
            grid,
            voxels: scalars.voxels,
            rescale: scalars.rescale,
            spatial_unit: self.spatial_unit.clone(),
            height_field: Some(field),
        })
    }

    /// The grid about the medium, and its heights there.
    fn layered(&self, world: &[f64], sheet: &Sheet) -> (Grid, HeightField) {
        let Layer { bottom, top, ramp } = sheet.layer;
        let extremes = (f64::INFINITY, f64::NEG_INFINITY);
        let (low, high) = (world.iter()).fold(extremes, |(a, b), h| (a.min(*h), b.max(*h)));
        let (low, high) = (low + bottom, high + top);
        let pitch = sheet.size / self.dims.as_dvec2();
        // A layer is no thicker than a ramp, so that steps of a voxel see it.
        let thickness = pitch.min_element().min(ramp);
        let thickness = thickness.max((high - low) / MOST_LAYERS);
        let layers = ((high - low) / thickness).ceil().max(1.0);
        let scale = DVec3::new(pitch.x, pitch.y, thickness);
        let first = DVec3::new(
            0.5 * (pitch.x - sheet.size.x),
            0.5 * (pitch.y - sheet.size.y),
            low + 0.5 * thickness,
        );
        let grid = Grid {
            dims: UVec3::new(self.dims.x, self.dims.y, layers as u32),
            world_from_index: DAffine3::from_mat3_translation(DMat3::from_diagonal(scale), first),
            space: Space::Unspecified,
        };
        let in_layers = |h: &f64| ((h - low) / thickness - 0.5) as f32;
        let field = HeightField {
            heights: world.iter().map(in_layers).collect(),
            bottom: bottom / thickness,
            top: top / thickness,
            ramp: ramp / thickness,
        };
        (grid, field)
    }
}
