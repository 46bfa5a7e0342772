// Light from all around, dimmed by what is near, and emission along one ray a pixel,
// L = int T sigma_t (emission colour + albedo colour L_env V) ds + T_b L_b [Schlegel2011]; the volume is
// read by loads of r8 texels, as suits software drivers.
// Domain: 64 pixels (8 x 8) a workgroup, tiles in linear order. Dispatched by
// technique/ambient_occlusion/record.rs.
#version 460
#extension GL_GOOGLE_include_directive : require
#define TEXEL_FORMAT r8
#include "shared/medium_loaded.glsl"
#include "ambient_occlusion/march.glsl"
