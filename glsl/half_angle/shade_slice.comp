// A slice as the viewer sees it: L += T sigma_t (e colour + sum p E T_light) ds, light taken from the current light
// buffer [Kniss2003, Eq. 10 to 12].
// Domain: pixels about the slice, 8 x 8 a workgroup. Dispatched by technique/half_angle/record.rs.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/medium_filtered.glsl"
#include "half_angle/shade_slice.glsl"
