// Single scattering along one ray a pixel, L = int T sigma_t (e colour + albedo sum p E T_light) ds + T_b L_b
// [Max1995]; the depths to the lights come from the light cache or from shadow rays;
// the volume is read by loads of r8 texels, as suits software drivers.
// Domain: 64 pixels (8 x 8) a workgroup, tiles in linear order. Dispatched by technique/single_scatter/record.rs.
#version 460
#extension GL_GOOGLE_include_directive : require
#define TEXEL_FORMAT r8
#include "shared/medium_loaded.glsl"
#include "single_scatter/march.glsl"
