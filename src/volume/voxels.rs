//! Typed voxel arrays.

use serde::{Deserialize, Serialize};

/// The stored type of one voxel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum ScalarType {
    /// Unsigned 8 bit.
    U8,
    /// Signed 8 bit.
    I8,
    /// Unsigned 16 bit.
    U16,
    /// Signed 16 bit.
    I16,
    /// Unsigned 32 bit.
    U32,
    /// Signed 32 bit.
    I32,
    /// IEEE 754 single.
    F32,
    /// IEEE 754 double.
    F64,
}

impl ScalarType {
    /// All types, in order of declaration.
    pub const ALL: [Self; 8] = [
        Self::U8,
        Self::I8,
        Self::U16,
        Self::I16,
        Self::U32,
        Self::I32,
        Self::F32,
        Self::F64,
    ];

    /// Bytes a voxel takes.
    #[must_use]
    pub const fn bytes(self) -> usize {
        match self {
            Self::U8 | Self::I8 => 1,
            Self::U16 | Self::I16 => 2,
            Self::U32 | Self::I32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    /// Values as floats of as many bits as voxels of this type need.
    #[must_use]
    pub fn floats(self, values: impl Iterator<Item = f64>) -> Voxels {
        match self {
            Self::U32 | Self::I32 | Self::F64 => Voxels::F64(values.collect()),
            _ => Voxels::F32(values.map(|v| v as f32).collect()),
        }
    }

    /// The name used in scene files and on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::U8 => "u8",
            Self::I8 => "i8",
            Self::U16 => "u16",
            Self::I16 => "i16",
            Self::U32 => "u32",
            Self::I32 => "i32",
            Self::F32 => "f32",
            Self::F64 => "f64",
        }
    }
}

impl std::fmt::Display for ScalarType {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

/// Voxels in native endianness, one variant a stored type.
#[derive(Clone, Debug, PartialEq)]
#[allow(missing_docs, reason = "the variants are the scalar types")]
pub enum Voxels {
    U8(Vec<u8>),
    I8(Vec<i8>),
    U16(Vec<u16>),
    I16(Vec<i16>),
    U32(Vec<u32>),
    I32(Vec<i32>),
    F32(Vec<f32>),
    F64(Vec<f64>),
}

/// Runs the same expression for every voxel type: `with_voxels!(voxels, v => v.len())`.
macro_rules! with_voxels {
    ($voxels:expr, $v:ident => $body:expr) => {
        match $voxels {
            $crate::volume::Voxels::U8($v) => $body,
            $crate::volume::Voxels::I8($v) => $body,
            $crate::volume::Voxels::U16($v) => $body,
            $crate::volume::Voxels::I16($v) => $body,
            $crate::volume::Voxels::U32($v) => $body,
            $crate::volume::Voxels::I32($v) => $body,
            $crate::volume::Voxels::F32($v) => $body,
            $crate::volume::Voxels::F64($v) => $body,
        }
    };
}

impl Voxels {
    /// The values as they are in memory.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        with_voxels!(self, v => bytemuck::cast_slice(v))
    }

    /// The stored type.
    #[must_use]
    pub const fn scalar_type(&self) -> ScalarType {
        match self {
            Self::U8(_) => ScalarType::U8,
            Self::I8(_) => ScalarType::I8,
            Self::U16(_) => ScalarType::U16,
            Self::I16(_) => ScalarType::I16,
            Self::U32(_) => ScalarType::U32,
            Self::I32(_) => ScalarType::I32,
            Self::F32(_) => ScalarType::F32,
            Self::F64(_) => ScalarType::F64,
        }
    }

    /// Number of voxels.
    #[must_use]
    pub const fn len(&self) -> usize {
        with_voxels!(self, v => v.len())
    }

    /// Whether there is no voxel.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The values at these indices, in their order.
    ///
    /// # Panics
    /// If an index is out of range.
    #[must_use]
    pub fn gathered(&self, indices: impl Iterator<Item = usize>) -> Self {
        match self {
            Self::U8(v) => Self::U8(indices.map(|i| v[i]).collect()),
            Self::I8(v) => Self::I8(indices.map(|i| v[i]).collect()),
            Self::U16(v) => Self::U16(indices.map(|i| v[i]).collect()),
            Self::I16(v) => Self::I16(indices.map(|i| v[i]).collect()),
            Self::U32(v) => Self::U32(indices.map(|i| v[i]).collect()),
            Self::I32(v) => Self::I32(indices.map(|i| v[i]).collect()),
            Self::F32(v) => Self::F32(indices.map(|i| v[i]).collect()),
            Self::F64(v) => Self::F64(indices.map(|i| v[i]).collect()),
        }
    }

    /// The stored value as f64 (exact for every type).
    ///
    /// # Panics
    /// If `index` is out of range.
    #[must_use]
    pub fn get(&self, index: usize) -> f64 {
        match self {
            Self::U8(v) => f64::from(v[index]),
            Self::I8(v) => f64::from(v[index]),
            Self::U16(v) => f64::from(v[index]),
            Self::I16(v) => f64::from(v[index]),
            Self::U32(v) => f64::from(v[index]),
            Self::I32(v) => f64::from(v[index]),
            Self::F32(v) => f64::from(v[index]),
            Self::F64(v) => v[index],
        }
    }
}
