// Multiple scattering along random paths, L = int T sigma_t (albedo int p L_i dw + ...) ds + T_b L_b,
// estimated without bias by delta tracking and next-event estimation [Woodcock1965, Novak2014];
// the medium is read by loads, the volume's of r16 texels, as suits software drivers.
// Domain: 64 pixels (8 x 8) a workgroup, tiles in linear order. Dispatched by technique/path_trace/record.rs.
#version 460
#extension GL_GOOGLE_include_directive : require
#define TEXEL_FORMAT r16
#define NO_CELLS
#include "shared/medium_loaded.glsl"
#include "path_trace/trace.glsl"
