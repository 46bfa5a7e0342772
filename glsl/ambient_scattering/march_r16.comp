// Ambient ray casting along one ray a pixel: every sample gathers what is scattered about it towards the viewer
// [Ament2013, Eq. 20, Algorithm 1]; the volume is read by loads of r16 texels, as
// suits software drivers.
// Domain: 64 pixels (8 x 8) a workgroup, tiles in linear order. Dispatched by
// technique/ambient_scattering/record.rs.
#version 460
#extension GL_GOOGLE_include_directive : require
#define TEXEL_FORMAT r16
#include "shared/medium_loaded.glsl"
#include "ambient_scattering/march.glsl"
