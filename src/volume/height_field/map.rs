//! From maps to a volume.

use std::path::Path;

use glam::{DAffine3, DMat3, DVec2, DVec3, UVec2, UVec3};

use super::HeightField;
use crate::volume::payload::first_bytes;
use crate::volume::read::{ReadOptions, read};
use crate::volume::{Grid, Rescale, Space, Volume, VolumeError, Voxels, geo_tiff, picture};

/// Most layers of a grid, as many as rays can take steps through: a field that is high and fine gets taller voxels.
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
    /// How far noise may move it up and down, >= 0.
    pub margin: f64,
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
fn is_length(world: f64) -> bool {
    world.abs() < 1e38
}

impl HeightMap {
    /// Reads a grey PNG picture, whose values are 0 (black) to 1, a grey TIFF, both with their upper edge towards largest
    /// y, or a volume file of one slice.
    ///
    /// # Errors
    /// Names the file, the field, what was found and what was expected.
    pub fn read(path: &Path, options: &ReadOptions) -> Result<Self, VolumeError> {
        let first = first_bytes(path, 8)?.bytes;
        if picture::is_png(&first) {
            return picture::read_grey(path);
        }
        if geo_tiff::is_tiff(&first) {
            return geo_tiff::read_map(path);
        }
        let volume = read(path, options, &mut |_, _| {})?;
        Self::slice(path, volume)
    }

    /// The one slice of a volume, brought to rise along the world's x and y.
    fn slice(path: &Path, volume: Volume) -> Result<Self, VolumeError> {
        let (d, m) = (volume.grid.dims, volume.grid.world_from_index.matrix3);
        if d.z != 1 {
            let found = format!("{} x {} x {} voxels", d.x, d.y, d.z);
            let expected = "one slice, which is a map of heights";
            return Err(VolumeError::field(path, "dimensions", found, expected));
        }
        let aslant =
            |along: f64, aside: [f64; 2]| aside.iter().any(|a| a.abs() > 1e-6 * along.abs());
        if aslant(m.x_axis.x, [m.x_axis.y, m.x_axis.z])
            || aslant(m.y_axis.y, [m.y_axis.x, m.y_axis.z])
        {
            let found = format!("columns along {} and {}", m.x_axis, m.y_axis);
            let expected = "a slice that lies along the world's x and y";
            return Err(VolumeError::field(path, "directions", found, expected));
        }
        let mirrored = [m.x_axis.x < 0.0, m.y_axis.y < 0.0];
        let at = |i: usize, n: u32, mirrored: bool| if mirrored { n as usize - 1 - i } else { i };
        let (nx, count) = (d.x as usize, d.x as usize * d.y as usize);
        let from = |i: usize| at(i % nx, d.x, mirrored[0]) + nx * at(i / nx, d.y, mirrored[1]);
        let voxels = if mirrored == [false, false] {
            volume.voxels
        } else {
            volume.voxels.gathered((0..count).map(from))
        };
        Ok(Self {
            name: volume.name,
            dims: d.truncate(),
            voxels,
            rescale: volume.rescale,
            spacing: Some(volume.grid.spacing().truncate()),
            spatial_unit: volume.spatial_unit,
        })
    }

    /// Largest magnitude of a finite value.
    #[must_use]
    pub fn largest(&self) -> f64 {
        let values = (0..self.voxels.len()).map(|i| self.value(i).abs());
        values.filter(|v| v.is_finite()).fold(0.0, f64::max)
    }

    fn value(&self, index: usize) -> f64 {
        self.rescale.apply(self.voxels.get(index))
    }

    /// The medium about the map's surface: centred on the world's z axis, heights above z = 0. Its data values are the
    /// `scalars`', or the heights' own.
    ///
    /// # Errors
    /// A height is not finite or too large, the layer cannot be resolved, or the scalars are of another size.
    ///
    /// # Panics
    /// There are not as many values as columns.
    pub fn volume(&self, scalars: Option<Self>, sheet: &Sheet) -> Result<Volume, String> {
        let world = self.heights(sheet)?;
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
        let (grid, field) = self.layered(&world, sheet)?;
        Ok(Volume {
            name: self.name.clone(),
            grid,
            voxels: scalars.voxels,
            rescale: scalars.rescale,
            spatial_unit: self.spatial_unit.clone(),
            height_field: Some(field),
        })
    }

    /// World heights of all columns.
    fn heights(&self, sheet: &Sheet) -> Result<Vec<f64>, String> {
        let count = self.dims.x as usize * self.dims.y as usize;
        let world: Vec<f64> = (0..count).map(|i| sheet.height * self.value(i)).collect();
        let Some(i) = world.iter().position(|h| !is_length(*h)) else {
            return Ok(world);
        };
        let (x, y) = (i % self.dims.x as usize, i / self.dims.x as usize);
        let fix = if self.value(i).is_finite() {
            "lower `volume.height_field.height`"
        } else {
            "fill the holes of the map"
        };
        Err(format!(
            "{}: found a height of {} at column {x}, {y}, expected finite heights: {fix}",
            self.name, world[i]
        ))
    }

    /// The grid about the medium, and its heights there.
    fn layered(&self, world: &[f64], sheet: &Sheet) -> Result<(Grid, HeightField), String> {
        let (Layer { bottom, top, ramp }, margin) = (sheet.layer, sheet.margin);
        let extremes = (f64::INFINITY, f64::NEG_INFINITY);
        let (low, high) = (world.iter()).fold(extremes, |(a, b), h| (a.min(*h), b.max(*h)));
        let (low, high) = (low + bottom - margin, high + top + margin);
        let lengths = [low, high, bottom, top, ramp, sheet.size.x, sheet.size.y];
        if !lengths.into_iter().all(is_length) {
            return Err(format!(
                "{}: found a map of {} x {} from {low} to {high} high, expected lengths below 1e38",
                self.name, sheet.size.x, sheet.size.y
            ));
        }
        let pitch = sheet.size / self.dims.as_dvec2();
        // No thicker than a ramp and half the medium, so that steps of a voxel see both.
        let finest = ramp.min(0.5 * (top - bottom));
        let thickness = pitch
            .min_element()
            .max((high - low) / MOST_LAYERS)
            .min(finest);
        let layers = ((high - low) / thickness).ceil().max(1.0);
        if layers > MOST_LAYERS + 1.0 {
            return Err(format!(
                "{}: found a layer {} thick with a ramp of {ramp} in a field {} high, expected both above {}: raise \
                 `volume.height_field.ramp` or `top` - `bottom`, or lower `height`",
                self.name,
                top - bottom,
                high - low,
                2.0 * (high - low) / MOST_LAYERS
            ));
        }
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
            margin: margin / thickness,
            level: 0,
        };
        Ok((grid, field))
    }
}
