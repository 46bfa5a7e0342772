//! How stored voxels become texels, without losing a bit that matters.

use glam::UVec3;

use crate::gpu::{Format, Limits};
use crate::technique::PlanError;
use crate::volume::{ScalarType, Statistics, Volume, Voxels};

/// Texel format of a volume, and what a texel means.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Encoding {
    /// `R8_UNORM`, `R16_UNORM` or `R32_SFLOAT`.
    pub format: Format,
    /// `data value = scale * texture value + offset`; `scale` is not 0.
    pub scale: f64,
    /// See `scale`.
    pub offset: f64,
    conversion: Conversion,
}

/// Stored value to texel.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Conversion {
    /// The bits as they are.
    Copy,
    /// Signed integers shifted to unsigned ones (top bit flipped): normalised formats are symmetric
    /// and would merge the two lowest values.
    FlipSign,
    /// Finite values as they are, others 0.
    Finite,
    /// `(stored - min) * factor` in f64: wide types keep 24 bits over the range they really have.
    Normalise { min: f64, factor: f64 },
}

impl Encoding {
    /// 8-bit voxels stay 8-bit, 16-bit stay 16-bit (f32 where the device cannot filter those), f32
    /// stays f32; u32, i32 and f64 become f32 over [min, max].
    ///
    /// # Errors
    /// The device cannot filter the format that is needed.
    pub fn choose(
        volume: &Volume,
        statistics: &Statistics,
        limits: &Limits,
    ) -> Result<Self, PlanError> {
        let r = volume.rescale;
        let scalar_type = volume.voxels.scalar_type();
        let unorm = |format, levels: f64, lowest: f64, conversion| Self {
            format,
            scale: r.slope * levels,
            offset: r.apply(lowest),
            conversion,
        };
        let encoding = match scalar_type {
            ScalarType::U8 => unorm(Format::R8_UNORM, 255.0, 0.0, Conversion::Copy),
            ScalarType::I8 => unorm(Format::R8_UNORM, 255.0, -128.0, Conversion::FlipSign),
            ScalarType::U16 if limits.linear_r16_unorm => {
                unorm(Format::R16_UNORM, 65535.0, 0.0, Conversion::Copy)
            }
            ScalarType::I16 if limits.linear_r16_unorm => {
                unorm(Format::R16_UNORM, 65535.0, -32768.0, Conversion::FlipSign)
            }
            ScalarType::F32 | ScalarType::U16 | ScalarType::I16 => Self {
                format: Format::R32_SFLOAT,
                scale: r.slope,
                offset: r.intercept,
                conversion: Conversion::Finite,
            },
            ScalarType::U32 | ScalarType::I32 | ScalarType::F64 => {
                Self::normalised(volume, statistics)
            }
        };
        if encoding.format == Format::R32_SFLOAT && !limits.linear_r32_sfloat {
            return Err(PlanError::Limit {
                what: format!("volume of {scalar_type}"),
                found: "needs linear filtering of 32-bit float images".to_owned(),
                limit: "the device has none".to_owned(),
                fix: "use another device (`tyndall devices`) or a u16 volume".to_owned(),
            });
        }
        Ok(encoding)
    }

    fn normalised(volume: &Volume, statistics: &Statistics) -> Self {
        let r = volume.rescale;
        // Halved first, so that a range from -f64::MAX to f64::MAX does not overflow.
        let half_range = 0.5 * statistics.max - 0.5 * statistics.min;
        let (a, b) = (
            (statistics.min - r.intercept) / r.slope,
            (statistics.max - r.intercept) / r.slope,
        );
        let min = a.min(b);
        let half_stored = 0.5 * a.max(b) - 0.5 * min;
        let (scale, factor) = if half_range > 0.0 && half_stored > 0.0 {
            (2.0 * half_range * r.slope.signum(), 0.5 / half_stored)
        } else {
            (1.0, 1.0)
        };
        let offset = if r.slope < 0.0 {
            statistics.max
        } else {
            statistics.min
        };
        Self {
            format: Format::R32_SFLOAT,
            scale,
            offset,
            conversion: Conversion::Normalise { min, factor },
        }
    }

    /// Bytes a texel.
    #[must_use]
    pub fn texel_bytes(&self) -> u64 {
        match self.format {
            Format::R8_UNORM => 1,
            Format::R16_UNORM => 2,
            _ => 4,
        }
    }

    /// The format of a (min, max) pair of texels, and its bytes.
    #[must_use]
    pub fn pair_format(&self) -> (Format, u64) {
        match self.format {
            Format::R8_UNORM => (Format::R8G8_UNORM, 2),
            Format::R16_UNORM => (Format::R16G16_UNORM, 4),
            _ => (Format::R32G32_SFLOAT, 8),
        }
    }

    /// The texture value that stands for a data value.
    #[must_use]
    pub fn texture_value(&self, data: f64) -> f64 {
        (data - self.offset) / self.scale
    }

    /// Writes the texels of `count` xy-slices from `first` on.
    pub fn encode(&self, volume: &Volume, first: u32, count: u32, target: &mut [u8]) {
        let at = volume.grid.linear_index(UVec3::new(0, 0, first));
        let end = volume.grid.linear_index(UVec3::new(0, 0, first + count));
        match &volume.voxels {
            Voxels::U8(v) => target.copy_from_slice(&v[at..end]),
            Voxels::I8(v) => fill(target, &v[at..end], |s| [s.cast_unsigned() ^ 0x80]),
            Voxels::U16(v) if self.conversion == Conversion::Copy => {
                fill(target, &v[at..end], |s| s.to_ne_bytes());
            }
            Voxels::I16(v) if self.conversion == Conversion::FlipSign => {
                fill(target, &v[at..end], |s| {
                    (s.cast_unsigned() ^ 0x8000).to_ne_bytes()
                });
            }
            Voxels::F32(v) => fill(target, &v[at..end], |s| finite(*s).to_ne_bytes()),
            Voxels::U16(v) => fill(target, &v[at..end], |s| f32::from(*s).to_ne_bytes()),
            Voxels::I16(v) => fill(target, &v[at..end], |s| f32::from(*s).to_ne_bytes()),
            Voxels::U32(v) => fill(target, &v[at..end], |s| self.normalise(f64::from(*s))),
            Voxels::I32(v) => fill(target, &v[at..end], |s| self.normalise(f64::from(*s))),
            Voxels::F64(v) => fill(target, &v[at..end], |s| self.normalise(*s)),
        }
    }

    fn normalise(&self, stored: f64) -> [u8; 4] {
        let value = match self.conversion {
            // Halved as in `normalised`; the factor is for halves doubled.
            Conversion::Normalise { min, factor } => (0.5 * stored - 0.5 * min) * (2.0 * factor),
            _ => stored,
        };
        finite(value as f32).to_ne_bytes()
    }
}

/// NaN and infinities become 0; a mask makes them empty.
fn finite(value: f32) -> f32 {
    if value.is_finite() { value } else { 0.0 }
}

fn fill<T, const N: usize>(target: &mut [u8], source: &[T], texel: impl Fn(&T) -> [u8; N]) {
    for (to, from) in target.chunks_exact_mut(N).zip(source) {
        to.copy_from_slice(&texel(from));
    }
}
