//! Height fields in scene files: what may stand there, its ranges, and the volume it describes.

use std::sync::Arc;

use glam::DVec2;
use schemars::JsonSchema;
use serde::Deserialize;

use super::error::Problem;
use super::spec::SceneSpec;
use super::validate::{exclusive, finite, positive, within};
use super::{SceneError, SceneFile};
use crate::scene::{Projection, Scene};
use crate::volume::procedural::HeightFormula;
use crate::volume::{
    ColorVolume, HeightMap, Layer, ReadOptions, Sheet, Volume, read_picture_colors,
};

/// Columns along each edge of a map from a formula.
const RESOLUTION: u32 = 1024;

/// Share of a map's width that a height of 1 stands for, where it has no unit.
const HEIGHT: f64 = 0.2;

/// Shares of a map's longer side: how thick the medium is below its surface, and how far it takes to become full.
const THICKNESS: f64 = 1.0 / 64.0;
const RAMP: f64 = 1.0 / 256.0;

/// Most halvings of a map.
const MOST_LEVELS: u32 = 16;

/// A thin layer of the medium about a surface over x and y, from a map of heights: exactly one of `file` and
/// `procedural`. Data values are the heights, or `scalars`.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct HeightFieldSpec {
    /// Heights: a grey PNG picture of 8 or 16 bits (black is 0, white 1), a grey TIFF (both with their upper edge towards
    /// +y), or a volume file of one slice; relative to the scene file.
    pub file: Option<String>,
    /// Heights from a formula: `terrain` or `cumulus_field`.
    pub procedural: Option<HeightFormulaSpec>,
    /// World units along x and y. Default: what the file's spacing says; without one 2 along the longer side.
    pub size: Option<[f64; 2]>,
    /// World units that a height of 1 stands for. Default: 1 where the file states a spacing; elsewhere a fifth of the
    /// map's width, or less where heights exceed 1, so that the highest has that.
    pub height: Option<f64>,
    /// The medium's lower face, world units above the surface. Default: -1/64 of the map's longer side.
    pub bottom: Option<f64>,
    /// The medium's upper face, world units above the surface; above `bottom`. Default: 0.
    pub top: Option<f64>,
    /// World units from either face over which the medium becomes as dense as the transfer function makes it, above
    /// 0; over more than half the layer it never does. Default: 1/256 of the map's longer side, at most a quarter of the
    /// layer.
    pub ramp: Option<f64>,
    /// Colours that take the place of the transfer function's in the scattering albedo: a PNG picture as large as
    /// the map.
    pub colors: Option<MapFileSpec>,
    /// Data values in place of heights, as large as the map: read as `file` is.
    pub scalars: Option<MapFileSpec>,
    /// How often the map is halved before it is rendered. Default: as often as two columns are no wider than the pixel
    /// that sees them from nearest by. At most 16.
    #[schemars(range(max = 16))]
    pub level: Option<u32>,
}

/// A map from a formula.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HeightFormulaSpec {
    /// Which formula.
    pub name: HeightFormula,
    /// Columns along each edge, 2 to 8192. Default: 1024.
    #[schemars(range(min = 2, max = 8192))]
    pub resolution: Option<u32>,
}

/// A file that goes with a map of heights.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MapFileSpec {
    /// Path, relative to the scene file.
    pub file: String,
}

/// Ranges of what a scene says of its height field.
pub(super) fn check(s: &SceneSpec) -> Result<(), Problem> {
    let Some(h) = &s.volume.height_field else {
        return Ok(());
    };
    let key = |name: &str| format!("volume.height_field.{name}");
    let sources = [
        ("file", h.file.is_some()),
        ("procedural", h.procedural.is_some()),
    ];
    exclusive("volume.height_field", &sources)?;
    if h.file.is_none() && h.procedural.is_none() {
        let message = "found neither, expected one of file, procedural";
        return Err(Problem::new("volume.height_field", message));
    }
    let formula = h.procedural.as_ref();
    let resolution = formula.and_then(|p| p.resolution).map(f64::from);
    within(&key("procedural.resolution"), resolution, 2.0, 8192.0)?;
    for (i, x) in h.size.into_iter().flatten().enumerate() {
        positive(&key(&format!("size.{i}")), Some(x))?;
    }
    finite(&key("height"), h.height)?;
    finite(&key("bottom"), h.bottom)?;
    finite(&key("top"), h.top)?;
    positive(&key("ramp"), h.ramp)?;
    if h.height == Some(0.0) {
        return Err(Problem::new(
            &key("height"),
            "found 0, expected another number",
        ));
    }
    if let (Some(bottom), top) = (h.bottom, h.top.unwrap_or(0.0))
        && bottom >= top
    {
        let message = format!("found {bottom}, expected less than the {top} of `top`");
        return Err(Problem::new(&key("bottom"), message));
    }
    if h.colors.is_some() && s.medium.albedo_volume.is_some() {
        let message = "found beside `volume.height_field.colors`, expected only one of them";
        return Err(Problem::new("medium.albedo_volume", message));
    }
    within(
        &key("level"),
        h.level.map(f64::from),
        0.0,
        f64::from(MOST_LEVELS),
    )
}

impl SceneFile {
    /// The medium about the map that the scene names.
    pub(super) fn height_field(&self, h: &HeightFieldSpec) -> Result<Volume, SceneError> {
        let read = |file: &str| HeightMap::read(&self.folder.join(file), &ReadOptions::default());
        let map = match (&h.file, &h.procedural) {
            (Some(file), _) => read(file)?,
            (None, Some(p)) => p.name.map(p.resolution.unwrap_or(RESOLUTION)),
            (None, None) => HeightFormula::Terrain.map(RESOLUTION),
        };
        let scalars = h.scalars.as_ref().map(|s| read(&s.file)).transpose()?;
        let noise = self.perturbation(0);
        let margin = noise.map_or(0.0, |p| p.largest_displacement());
        map.volume(scalars, &sheet(h, &map, margin))
            .map_err(SceneError::plain)
    }

    /// The colours of the map, if it has some.
    pub(super) fn height_field_colors(
        &self,
        volume: &Volume,
    ) -> Result<Option<ColorVolume>, SceneError> {
        let field = self.spec.volume.height_field.as_ref();
        let Some(colors) = field.and_then(|h| h.colors.as_ref()) else {
            return Ok(None);
        };
        let path = self.folder.join(&colors.file);
        let dims = volume.stored_dims().truncate();
        Ok(Some(read_picture_colors(&path, dims)?))
    }

    /// Halves the map, if there is one, as often as the image allows.
    pub(super) fn coarsen(&self, scene: &mut Scene) {
        let Some(h) = &self.spec.volume.height_field else {
            return;
        };
        for _ in 0..h.level.unwrap_or_else(|| level(scene)) {
            let Some(coarse) = scene.volume.halved() else {
                return;
            };
            scene.volume = Arc::new(coarse);
            if let Some(colors) = &mut scene.medium.albedo_volume {
                *colors = Arc::new(colors.halved());
            }
        }
    }
}

/// Halvings that leave two columns no wider than a pixel: one a pixel would blur the picture.
fn level(scene: &Scene) -> u32 {
    let column = scene.volume.grid.spacing().truncate().max_element();
    let halvings = (0.5 * finest_pixel(scene) / column).log2().floor();
    halvings.clamp(0.0, f64::from(MOST_LEVELS)) as u32
}

/// World units along the edge of the pixel that sees the volume from nearest by; 0 from inside.
fn finest_pixel(scene: &Scene) -> f64 {
    let (camera, image) = (&scene.camera, &scene.image);
    let rows = f64::from(image.height) * f64::from(image.samples_per_axis);
    match camera.projection {
        Projection::Orthographic { height } => height / rows,
        Projection::Perspective { vfov_deg } => {
            let forward = camera.frame().forward;
            let depths = scene
                .volume
                .grid
                .corners()
                .map(|x| forward.dot(x - camera.eye));
            let nearest = depths.into_iter().fold(f64::INFINITY, f64::min).max(0.0);
            2.0 * nearest * (0.5 * vfov_deg).to_radians().tan() / rows
        }
    }
}

/// How the map becomes a medium, what the scene leaves open chosen; `margin` is how far noise may move it.
fn sheet(h: &HeightFieldSpec, map: &HeightMap, margin: f64) -> Sheet {
    let dims = map.dims.as_dvec2();
    let whole = map
        .spacing
        .map_or(2.0 * dims / dims.max_element(), |spacing| spacing * dims);
    let size = h.size.map_or(whole, DVec2::from);
    let longer = size.max_element();
    let height = h.height.unwrap_or_else(|| match map.spacing {
        Some(_) => 1.0,
        None => HEIGHT * size.x / map.largest().max(1.0),
    });
    let top = h.top.unwrap_or(0.0);
    let bottom = h.bottom.unwrap_or(top - THICKNESS * longer);
    Sheet {
        size,
        height,
        layer: Layer {
            bottom,
            top,
            ramp: h.ramp.unwrap_or((RAMP * longer).min(0.25 * (top - bottom))),
        },
        margin,
    }
}
