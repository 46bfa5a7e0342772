//! Volumes of colours.

use std::path::Path;

use glam::{DVec3, UVec3};
use rayon::prelude::*;

use super::source::Source;
use super::{RawLayout, ScalarType, VolumeError, Voxels, nrrd, raw};

/// Linear RGB in [0, 1] for every voxel.
#[derive(Clone, Debug, PartialEq)]
pub struct ColorVolume {
    /// The file's name.
    pub name: String,
    /// Voxels along x, y, z.
    pub dims: UVec3,
    /// Red, green and blue of every voxel, x fastest; 8 and 16 bits count from 0 to 1 in full.
    values: Voxels,
}

/// Reads an NRRD file whose first axis holds three colours, or, with a layout, headerless voxels of three
/// values each.
///
/// # Errors
/// Names the file, the field, what was found and what was expected; values outside [0, 1] are refused.
pub fn read_color(path: &Path, raw: Option<RawLayout>) -> Result<ColorVolume, VolumeError> {
    let Source {
        header,
        mut payload,
    } = match raw {
        Some(layout) => raw::open(path, &layout, 0)?,
        None => nrrd::open_color(path)?,
    };
    if !matches!(
        header.scalar_type,
        ScalarType::U8 | ScalarType::U16 | ScalarType::F32 | ScalarType::F64
    ) {
        let found = header.scalar_type.to_string();
        let expected = "colours as u8 or u16 (the whole range), f32 or f64 (0 to 1)";
        return Err(VolumeError::field(path, "type", found, expected));
    }
    let dims = header.grid.dims;
    payload.dims.x = dims.x.checked_mul(3).ok_or_else(|| {
        let found = format!("{} voxels along x", dims.x);
        VolumeError::field(path, "sizes", found, "at most 1431655765")
    })?;
    let colors = ColorVolume {
        name: path
            .file_name()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned(),
        dims,
        values: payload.read(&mut |_, _| {})?,
    };
    match colors.first_outside() {
        None => Ok(colors),
        Some(index) => {
            let found = format!("{} as value {index}", colors.values.get(index));
            let expected = "colours from 0 to 1";
            Err(VolumeError::field(path, "voxel data", found, expected))
        }
    }
}

impl ColorVolume {
    /// A volume from its colours, x fastest.
    ///
    /// # Panics
    /// There are not as many colours as voxels.
    #[must_use]
    pub fn new(name: &str, dims: UVec3, colors: &[[f32; 3]]) -> Self {
        let voxels = dims.as_u64vec3().element_product();
        assert_eq!(voxels, colors.len() as u64, "one colour a voxel");
        Self {
            name: name.to_owned(),
            dims,
            values: Voxels::F32(colors.as_flattened().to_vec()),
        }
    }

    /// Whether 8 bits hold every colour exactly.
    #[must_use]
    pub fn is_8_bit(&self) -> bool {
        self.values.scalar_type() == ScalarType::U8
    }

    /// The colours as they are stored.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        self.values.bytes()
    }

    /// The colour of voxel `index` in storage order.
    ///
    /// # Panics
    /// If `index` is outside the volume.
    #[must_use]
    pub fn color(&self, index: usize) -> DVec3 {
        let scale = match self.values.scalar_type() {
            ScalarType::U8 => 1.0 / 255.0,
            ScalarType::U16 => 1.0 / 65535.0,
            _ => 1.0,
        };
        let value = |i| scale * self.values.get(3 * index + i);
        DVec3::new(value(0), value(1), value(2))
    }

    /// The colour at continuous index `p`, as [`super::Volume::sample_index`].
    #[must_use]
    pub fn sample_index(&self, p: DVec3) -> DVec3 {
        let last = self.dims - 1;
        let p = p.clamp(DVec3::ZERO, last.as_dvec3());
        let (base, f) = (p.floor().as_uvec3(), p - p.floor());
        let mut sum = DVec3::ZERO;
        for corner in 0..8u32 {
            let o = UVec3::new(corner & 1, (corner >> 1) & 1, corner >> 2);
            let at = (base + o).min(last);
            let index = at.x + self.dims.x * (at.y + self.dims.y * at.z);
            let w = DVec3::select(o.cmpeq(UVec3::ONE), f, 1.0 - f);
            sum += w.element_product() * self.color(index as usize);
        }
        sum
    }

    /// The first stored value that is no share of a colour.
    fn first_outside(&self) -> Option<usize> {
        let outside = |v: f64| !(0.0..=1.0).contains(&v);
        match &self.values {
            Voxels::F32(v) => v.par_iter().position_first(|v| outside(f64::from(*v))),
            Voxels::F64(v) => v.par_iter().position_first(|v| outside(*v)),
            _ => None,
        }
    }
}
