//! The environment map on the device, and the table from which its bright places are drawn.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::{DMat3, UVec2, Vec3};
use rayon::prelude::*;

use super::stage;
use crate::gpu::{
    Access, Device, Format, GpuError, Image, ImageDesc, ImageType, ImageUsageFlags, StageTime,
    upload_image,
};
use crate::scene::{LatLongMap, Light, Scene, world_from_map};

/// Most cells along a side of the table: cell numbers stay exact in a float.
const MAX_CELLS: u32 = 2048;

/// A scene's environment map and how it is turned.
pub(super) struct Environment<'a> {
    pub(super) map: &'a Arc<LatLongMap>,
    pub(super) scale: Vec3,
    pub(super) map_from_world: DMat3,
}

impl<'a> Environment<'a> {
    /// The first map among the scene's lights.
    pub(super) fn of(scene: &'a Scene) -> Option<Self> {
        scene.lights.iter().find_map(|l| match l {
            Light::EnvironmentMap {
                map,
                scale,
                up,
                rotation_deg,
            } => Some(Self {
                map,
                scale: *scale,
                map_from_world: world_from_map(*up, *rotation_deg).transpose(),
            }),
            _ => None,
        })
    }
}

/// Texels of the map and cells of its table; one each without a map.
pub(super) fn extents(map: Option<&LatLongMap>) -> (UVec2, UVec2) {
    let size = map.map_or(UVec2::ONE, |m| UVec2::new(m.width, m.height));
    (size, size.min(UVec2::splat(MAX_CELLS)))
}

/// Images of the map and of the table.
pub(super) struct Maps {
    pub(super) map: Arc<Image>,
    pub(super) alias: Arc<Image>,
    // The map that they hold.
    held: Option<Arc<LatLongMap>>,
    filled: bool,
}

impl Maps {
    pub(super) fn new(
        device: &Device,
        size: (UVec2, UVec2),
        old: Option<Self>,
    ) -> Result<Self, GpuError> {
        let fits = |m: &Self| extent(&m.map) == size.0 && extent(&m.alias) == size.1;
        if let Some(old) = old.filter(fits) {
            return Ok(old);
        }
        let image = |name, size: UVec2| {
            let desc = ImageDesc {
                image_type: ImageType::TYPE_2D,
                extent: size.extend(1),
                format: Format::R32G32B32A32_SFLOAT,
                usage: ImageUsageFlags::SAMPLED | ImageUsageFlags::TRANSFER_DST,
            };
            Image::new(device, name, desc).map(Arc::new)
        };
        Ok(Self {
            map: image("environment_map", size.0)?,
            alias: image("environment_alias", size.1)?,
            held: None,
            filled: false,
        })
    }

    /// Fills the images with the scene's map, unless they hold it already.
    pub(super) fn upload(
        &mut self,
        device: &Device,
        map: Option<&Arc<LatLongMap>>,
    ) -> Result<Vec<StageTime>, GpuError> {
        if self.filled && self.held.as_ref() == map {
            return Ok(Vec::new());
        }
        let texels = map.map_or_else(
            || vec![[0.0; 4]],
            |m| m.texels.iter().map(|[r, g, b]| [*r, *g, *b, 0.0]).collect(),
        );
        let table = map.map_or_else(|| vec![[0.0; 4]], |m| alias_table(m));
        let mut times = fill(device, &self.map, &texels)?;
        times.extend(fill(device, &self.alias, &table)?);
        (self.held, self.filled) = (map.cloned(), true);
        let seconds = times.iter().map(|t| t.seconds).sum();
        let name = stage::UPLOAD_ENVIRONMENT.to_owned();
        Ok(match map {
            Some(_) => vec![StageTime { name, seconds }],
            None => Vec::new(),
        })
    }
}

fn extent(image: &Image) -> UVec2 {
    image.desc().extent.truncate()
}

fn fill(device: &Device, image: &Image, texels: &[[f32; 4]]) -> Result<Vec<StageTime>, GpuError> {
    let bytes: &[u8] = bytemuck::cast_slice(texels);
    let name = stage::UPLOAD_ENVIRONMENT;
    let copy = |_, _, to: &mut [u8]| to.copy_from_slice(bytes);
    let after = Access::ComputeSampled;
    upload_image(device, image, name, 16, after, copy, &mut |_, _| {})
}

/// For every cell: its chance to be kept when drawn, the cell taken instead, the density of directions
/// times the sine of their angle from the pole; the alias method `[Vose1991]`.
fn alias_table(map: &LatLongMap) -> Vec<[f32; 4]> {
    let (_, cells) = extents(Some(map));
    let weights = weights(map, cells);
    let total: f64 = weights.iter().sum();
    let mean = total / weights.len() as f64;
    let mut share: Vec<f64> = weights.iter().map(|w| w / mean).collect();
    let mut table: Vec<[f32; 4]> = share
        .iter()
        .enumerate()
        .map(|(i, s)| [1.0, i as f32, (s / (2.0 * PI * PI)) as f32, 0.0])
        .collect();
    let (mut below, mut above): (Vec<_>, Vec<_>) = (0..share.len()).partition(|i| share[*i] < 1.0);
    while let (Some(low), Some(high)) = (below.pop(), above.pop()) {
        table[low][0] = share[low] as f32;
        table[low][1] = high as f32;
        share[high] -= 1.0 - share[low];
        if share[high] < 1.0 {
            below.push(high);
        } else {
            above.push(high);
        }
    }
    table
}

/// How bright every cell can be anywhere, times its solid angle. A black map is even.
fn weights(map: &LatLongMap, cells: UVec2) -> Vec<f64> {
    let brightness = |[r, g, b]: [f32; 3]| f64::from(r) + f64::from(g) + f64::from(b);
    let row = |y: u32| {
        let [top, bottom] = [y, y + 1].map(|y| PI * f64::from(y) / f64::from(cells.y));
        let rows = touched(y, cells.y, map.height);
        (0..cells.x).map(move |x| {
            let columns = touched(x, cells.x, map.width);
            let texels = rows.clone().flat_map(|y| {
                let y = y.clamp(0, i64::from(map.height) - 1);
                let column = |x: i64| x.rem_euclid(map.width.into());
                let at = move |x| y * i64::from(map.width) + column(x);
                columns.clone().map(at)
            });
            let brightest = texels.map(|at| brightness(map.texels[at as usize]));
            brightest.fold(0.0, f64::max) * (top.cos() - bottom.cos())
        })
    };
    let weights: Vec<f64> = (0..cells.y).into_par_iter().flat_map_iter(row).collect();
    if weights.iter().any(|w| *w > 0.0) {
        return weights;
    }
    vec![1.0; weights.len()]
}

/// Texels along an axis that radiance in a cell is interpolated from; beyond the ends too.
fn touched(cell: u32, cells: u32, texels: u32) -> std::ops::RangeInclusive<i64> {
    let scale = f64::from(texels) / f64::from(cells);
    let [low, high] = [cell, cell + 1].map(|c| f64::from(c) * scale - 0.5);
    low.floor() as i64..=high.floor() as i64 + 1
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map(width: u32, height: u32, radiance: impl Fn(u32, u32) -> f32) -> LatLongMap {
        let texel = |i: u32| [radiance(i % width, i / width), 0.0, 0.5];
        LatLongMap {
            name: "test".to_owned(),
            width,
            height,
            texels: (0..width * height).map(texel).collect(),
        }
    }

    #[test]
    fn the_alias_table_draws_cells_by_their_weight() {
        let map = map(16, 8, |x, y| {
            if (x, y) == (3, 4) {
                1e4
            } else {
                (x * y) as f32
            }
        });
        let table = alias_table(&map);
        let weights = weights(&map, UVec2::new(16, 8));
        let total: f64 = weights.iter().sum();
        let mut chance = vec![0.0; table.len()];
        for (i, [keep, other, ..]) in table.iter().enumerate() {
            chance[i] += f64::from(*keep) / table.len() as f64;
            chance[*other as usize] += f64::from(1.0 - keep) / table.len() as f64;
        }
        for (i, w) in weights.iter().enumerate() {
            assert!((chance[i] - w / total).abs() < 1e-7, "cell {i}");
            let density = f64::from(table[i][2]) * 2.0 * PI * PI;
            assert!(
                (density - w / total * 128.0).abs() < 1e-5 * density,
                "cell {i}"
            );
        }
    }

    #[test]
    fn densities_integrate_to_one_over_the_sphere() {
        let map = map(12, 6, |x, y| (x + 10 * y) as f32);
        let table = alias_table(&map);
        // Density times sine is constant in a cell, and a cell is 2 pi^2 / 72 of angle by angle.
        let sum: f64 = table.iter().map(|t| f64::from(t[2])).sum();
        assert!((sum * 2.0 * PI * PI / 72.0 - 1.0).abs() < 1e-6);
    }

    #[test]
    fn maps_without_light_are_drawn_evenly() {
        let map = LatLongMap {
            texels: vec![[0.0; 3]; 8],
            ..map(4, 2, |_, _| 0.0)
        };
        assert!(alias_table(&map).iter().all(|t| t[0] == 1.0 && t[2] > 0.0));
    }

    #[test]
    fn large_maps_have_coarser_tables() {
        let map = map(4096, 4, |x, _| x as f32);
        assert_eq!(extents(Some(&map)).1, UVec2::new(2048, 4));
        // What a cell holds is no brighter than it was taken for.
        assert_eq!(touched(1, 2048, 4096), 1..=4);
    }
}
