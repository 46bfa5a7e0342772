// Share of the light from all around that is not absorbed within a box about every cell: three boxes tell the
// mean extinction of three shells, of which each dims by its thickness [Schlegel2011].
// Domain: one invocation a cell, slices of cells along z. Dispatched by technique/summed_area/field.rs.
#version 460
#extension GL_GOOGLE_include_directive : require
layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 0, r32ui) readonly uniform uimage3D sums;
layout(set = 0, binding = 1, r16f) writeonly uniform image3D occlusion;

layout(push_constant) uniform Push {
    float half_box_x;    // cells to either side
    float half_box_y;
    float half_box_z;
    float depth_a_level; // optical depth of a shell of a third of the box, a level that a box of
                         // the largest size holds
    uint first_slice;
    uint slice_count;
} push;

#include "shared/box_sum.glsl"

const int SHELLS = 3;

void main() {
    ivec3 cell = ivec3(gl_GlobalInvocationID.xy, gl_GlobalInvocationID.z + push.first_slice);
    ivec3 cells = imageSize(sums);
    if (gl_GlobalInvocationID.z >= push.slice_count || any(greaterThanEqual(cell, cells))) return;
    vec3 half_box = vec3(push.half_box_x, push.half_box_y, push.half_box_z);
    vec3 centre = vec3(cell) + 0.5;
    int planes = is_empty(centre - half_box, centre + half_box, cells) ? 0 : 4;
    float depth = 0.0, sum_within = 0.0, volume_within = 0.0;
    for (int i = 1; i <= SHELLS; ++i) {
        float share = float(i) / float(SHELLS);
        float sum = box_sum(centre - share * half_box, centre + share * half_box, cells, planes);
        float volume = share * share * share;
        depth += max(sum - sum_within, 0.0) / (volume - volume_within);
        sum_within = sum;
        volume_within = volume;
    }
    imageStore(occlusion, cell, vec4(exp(-push.depth_a_level * depth)));
}
