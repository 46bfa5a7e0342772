// The ambient extinction [Ament2013, Eq. 13] of every cell: the mean over a box with the volume of a sphere, as
// the optical depth of the sphere's radius.
// Domain: one invocation a cell, slices of cells along z. Dispatched by technique/summed_area/field.rs.
#version 460
#extension GL_GOOGLE_include_directive : require
layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 0, r32ui) readonly uniform uimage3D sums;
layout(set = 0, binding = 1, r16f) writeonly uniform image3D ambient_extinction;

layout(push_constant) uniform Push {
    float half_box_x;    // cells to either side
    float half_box_y;
    float half_box_z;
    float depth_a_level; // optical depth of a radius, a level that the whole box holds
    uint first_slice;
    uint slice_count;
} push;

#define WHOLE uint
#define SIGNED int
#define REAL float
WHOLE sum_at(ivec3 at) {
    return imageLoad(sums, at).r;
}
#include "shared/box_sum.glsl"

void main() {
    ivec3 cell = ivec3(gl_GlobalInvocationID.xy, gl_GlobalInvocationID.z + push.first_slice);
    ivec3 cells = imageSize(sums);
    if (gl_GlobalInvocationID.z >= push.slice_count || any(greaterThanEqual(cell, cells))) return;
    vec3 half_box = vec3(push.half_box_x, push.half_box_y, push.half_box_z);
    vec3 centre = vec3(cell) + 0.5;
    int planes = is_empty(centre - half_box, centre + half_box, cells) ? 0 : 4;
    float depth = push.depth_a_level * box_sum(centre - half_box, centre + half_box, cells, planes);
    // The largest half float is 65504.
    imageStore(ambient_extinction, cell, vec4(clamp(depth, 0.0, 6e4)));
}
