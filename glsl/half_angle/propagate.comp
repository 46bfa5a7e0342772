// A slice as the light sees it: from the current light buffer to the next one, direct light dimmed, scattered light
// spread and dimmed [Kniss2003, Eq. 7 to 9].
// Domain: texels about the slice, 8 x 8 a workgroup. Dispatched by technique/half_angle/record.rs.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/medium_filtered.glsl"
#include "half_angle/propagate.glsl"
