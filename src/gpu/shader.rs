//! The compiled shaders, embedded in the program.
//!
//! A shader's name is its path: `ray_march.march` is `glsl/ray_march/march.comp`, compiled to
//! `spirv/ray_march/march.spv`; it is also the stage's debug label and its row in timing tables.

use super::GpuError;

/// One compiled compute shader.
#[derive(Clone, Copy, Debug)]
pub struct Shader {
    /// `technique.stage`.
    pub name: &'static str,
    /// The SPIR-V module, little-endian words.
    pub spirv: &'static [u8],
}

macro_rules! shaders {
    ($($(#[$doc:meta])* $constant:ident = $technique:literal / $stage:literal;)*) => {
        $($(#[$doc])* pub const $constant: Shader = Shader {
            name: concat!($technique, ".", $stage),
            spirv: include_bytes!(concat!("../../spirv/", $technique, "/", $stage, ".spv")),
        };)*
        /// Every shader of the program.
        pub const ALL: &[Shader] = &[$($constant),*];
    };
}

shaders! {
    /// The radiance of every pixel, environments dimmed by ambient occlusion.
    AMBIENT_OCCLUSION_MARCH = "ambient_occlusion" / "march";
    /// The same, the volume read by loads of 8-bit texels.
    AMBIENT_OCCLUSION_MARCH_R8 = "ambient_occlusion" / "march_r8";
    /// The same, the volume read by loads of 16-bit texels.
    AMBIENT_OCCLUSION_MARCH_R16 = "ambient_occlusion" / "march_r16";
    /// The same, the volume read by loads of float texels.
    AMBIENT_OCCLUSION_MARCH_R32F = "ambient_occlusion" / "march_r32f";
    /// What the radiance cache's nodes scatter towards the viewer.
    AMBIENT_SCATTERING_GATHER = "ambient_scattering" / "gather";
    /// Light that arrives at every node of a grid.
    AMBIENT_SCATTERING_RADIANCE_CACHE = "ambient_scattering" / "radiance_cache";
    /// The radiance of every pixel by ambient ray casting.
    AMBIENT_SCATTERING_MARCH = "ambient_scattering" / "march";
    /// The same, the volume read by loads of 8-bit texels.
    AMBIENT_SCATTERING_MARCH_R8 = "ambient_scattering" / "march_r8";
    /// The same, the volume read by loads of 16-bit texels.
    AMBIENT_SCATTERING_MARCH_R16 = "ambient_scattering" / "march_r16";
    /// The same, the volume read by loads of float texels.
    AMBIENT_SCATTERING_MARCH_R32F = "ambient_scattering" / "march_r32f";
    /// Radiance out of spheres, one path for all angles to the light.
    AMBIENT_SCATTERING_PREINTEGRATE = "ambient_scattering" / "preintegrate";
    /// The same by one plain path an angle, to measure the former against.
    AMBIENT_SCATTERING_PREINTEGRATE_PLAIN = "ambient_scattering" / "preintegrate_plain";
    /// A slice as the viewer sees it.
    HALF_ANGLE_SHADE_SLICE = "half_angle" / "shade_slice";
    /// The same, the volume read by loads of 8-bit texels.
    HALF_ANGLE_SHADE_SLICE_R8 = "half_angle" / "shade_slice_r8";
    /// The same, the volume read by loads of 16-bit texels.
    HALF_ANGLE_SHADE_SLICE_R16 = "half_angle" / "shade_slice_r16";
    /// The same, the volume read by loads of float texels.
    HALF_ANGLE_SHADE_SLICE_R32F = "half_angle" / "shade_slice_r32f";
    /// Light on its way through a slice.
    HALF_ANGLE_PROPAGATE = "half_angle" / "propagate";
    /// The same, the volume read by loads of 8-bit texels.
    HALF_ANGLE_PROPAGATE_R8 = "half_angle" / "propagate_r8";
    /// The same, the volume read by loads of 16-bit texels.
    HALF_ANGLE_PROPAGATE_R16 = "half_angle" / "propagate_r16";
    /// The same, the volume read by loads of float texels.
    HALF_ANGLE_PROPAGATE_R32F = "half_angle" / "propagate_r32f";
    /// What a sweep gathered joins the image.
    HALF_ANGLE_COMPOSE = "half_angle" / "compose";
    /// Smallest and largest voxel of every cell.
    MEDIUM_CELL_MIN_MAX = "medium" / "cell_min_max";
    /// Which cells the transfer function leaves empty.
    MEDIUM_CELL_OCCUPANCY = "medium" / "cell_occupancy";
    /// Distance from every cell to the nearest occupied one.
    MEDIUM_CELL_DISTANCE = "medium" / "cell_distance";
    /// Paths of light, some collisions further.
    PATH_TRACE_TRACE = "path_trace" / "trace";
    /// The same, the volume read by loads of 8-bit texels.
    PATH_TRACE_TRACE_R8 = "path_trace" / "trace_r8";
    /// The same, the volume read by loads of 16-bit texels.
    PATH_TRACE_TRACE_R16 = "path_trace" / "trace_r16";
    /// The same, the volume read by loads of float texels.
    PATH_TRACE_TRACE_R32F = "path_trace" / "trace_r32f";
    /// The radiance of every pixel.
    RAY_MARCH_MARCH = "ray_march" / "march";
    /// The same, the volume read by loads of 8-bit texels.
    RAY_MARCH_MARCH_R8 = "ray_march" / "march_r8";
    /// The same, the volume read by loads of 16-bit texels.
    RAY_MARCH_MARCH_R16 = "ray_march" / "march_r16";
    /// The same, the volume read by loads of float texels.
    RAY_MARCH_MARCH_R32F = "ray_march" / "march_r32f";
    /// The optical depth from every node of a grid to a light.
    SINGLE_SCATTER_LIGHT_CACHE = "single_scatter" / "light_cache";
    /// The same, the volume read by loads of 8-bit texels.
    SINGLE_SCATTER_LIGHT_CACHE_R8 = "single_scatter" / "light_cache_r8";
    /// The same, the volume read by loads of 16-bit texels.
    SINGLE_SCATTER_LIGHT_CACHE_R16 = "single_scatter" / "light_cache_r16";
    /// The same, the volume read by loads of float texels.
    SINGLE_SCATTER_LIGHT_CACHE_R32F = "single_scatter" / "light_cache_r32f";
    /// The singly scattered radiance of every pixel.
    SINGLE_SCATTER_MARCH = "single_scatter" / "march";
    /// The same, the volume read by loads of 8-bit texels.
    SINGLE_SCATTER_MARCH_R8 = "single_scatter" / "march_r8";
    /// The same, the volume read by loads of 16-bit texels.
    SINGLE_SCATTER_MARCH_R16 = "single_scatter" / "march_r16";
    /// The same, the volume read by loads of float texels.
    SINGLE_SCATTER_MARCH_R32F = "single_scatter" / "march_r32f";
    /// Mean extinction of every cell.
    SUMMED_AREA_EXTINCTION = "summed_area" / "extinction";
    /// The same, the volume read by loads of 8-bit texels.
    SUMMED_AREA_EXTINCTION_R8 = "summed_area" / "extinction_r8";
    /// The same, the volume read by loads of 16-bit texels.
    SUMMED_AREA_EXTINCTION_R16 = "summed_area" / "extinction_r16";
    /// The same, the volume read by loads of float texels.
    SUMMED_AREA_EXTINCTION_R32F = "summed_area" / "extinction_r32f";
    /// Running sums along one axis, one invocation a line.
    SUMMED_AREA_SCAN = "summed_area" / "scan";
    /// Running sums along x by scans over subgroups.
    SUMMED_AREA_SCAN_SUBGROUP = "summed_area" / "scan_subgroup";
    /// Running sums along y or z, lines in segments.
    SUMMED_AREA_SCAN_SEGMENTS = "summed_area" / "scan_segments";
    /// Mean extinction of the box about every cell.
    SUMMED_AREA_AMBIENT_EXTINCTION = "summed_area" / "ambient_extinction";
    /// Occlusion of every cell by the boxes about it.
    SUMMED_AREA_OCCLUSION = "summed_area" / "occlusion";
}

const MAGIC: u32 = 0x0723_0203;
const OP_EXECUTION_MODE: u32 = 16;
const MODE_LOCAL_SIZE: u32 = 17;

impl Shader {
    /// The module as words.
    ///
    /// # Errors
    /// The bytes are not SPIR-V.
    pub fn words(&self) -> Result<Vec<u32>, GpuError> {
        let words: Vec<u32> = self
            .spirv
            .chunks_exact(4)
            .map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]))
            .collect();
        if words.first() == Some(&MAGIC) && words.len() * 4 == self.spirv.len() {
            Ok(words)
        } else {
            Err(self.error("not a SPIR-V module"))
        }
    }

    /// The workgroup's size, as the shader declares it.
    ///
    /// # Errors
    /// The module declares no literal local size.
    pub fn local_size(&self) -> Result<[u32; 3], GpuError> {
        let words = self.words()?;
        let mut rest = words.get(5..).unwrap_or(&[]);
        // An instruction's first word holds its length (high half) and opcode (low half).
        while let Some(&head) = rest.first() {
            let length = (head >> 16) as usize;
            if length == 0 || length > rest.len() {
                return Err(self.error("truncated SPIR-V"));
            }
            if head & 0xffff == OP_EXECUTION_MODE && length == 6 && rest[2] == MODE_LOCAL_SIZE {
                return Ok([rest[3], rest[4], rest[5]]);
            }
            rest = &rest[length..];
        }
        Err(self.error("declares no local size"))
    }

    fn error(&self, message: &str) -> GpuError {
        GpuError::Shader {
            name: self.name.to_owned(),
            message: message.to_owned(),
        }
    }
}
