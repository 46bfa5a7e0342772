//! Headerless volumes.

use super::ScalarType;

/// Everything a headerless file does not say.
#[derive(Clone, Debug, PartialEq)]
pub struct RawLayout {
    /// Voxels along x (fastest), y, z.
    pub dims: [u32; 3],
    /// Stored type.
    pub scalar_type: ScalarType,
    /// World units between voxel centres.
    pub spacing: [f64; 3],
    /// Big-endian voxels.
    pub big_endian: bool,
    /// Bytes to skip before the first voxel.
    pub skip_bytes: u64,
}
