// Mean extinction of a cell of voxels, in whole levels, and its square: what the summed-area tables sum; by loads of
// r8 texels, as suits software drivers.
// Domain: one invocation a cell, slices of cells along z. Dispatched by technique/summed_area/record.rs.
// Empty, clipped and non-finite voxels count as 0 [Ament2013, Eq. 12].
#version 460
#extension GL_GOOGLE_include_directive : require
#define TEXEL_FORMAT r8
#include "shared/medium_loaded.glsl"
#include "summed_area/extinction.glsl"
