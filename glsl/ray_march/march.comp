// Emission and absorption along one ray a pixel, L = int T sigma_t colour ds + T_b L_b [Max1995],
// the colour taken as source radiance or lit by Blinn-Phong shading on the gradient [Levoy1988].
// Domain: 64 pixels (8 x 8) a workgroup, tiles in linear order. Dispatched by technique/ray_march/record.rs.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/medium_filtered.glsl"
#include "ray_march/march.glsl"
