// Ambient ray casting along one ray a pixel: every sample gathers what is scattered about it towards the viewer
// [Ament2013, Eq. 20, Algorithm 1].
// Domain: 64 pixels (8 x 8) a workgroup, tiles in linear order. Dispatched by
// technique/ambient_scattering/record.rs.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/medium_filtered.glsl"
#include "ambient_scattering/march.glsl"
