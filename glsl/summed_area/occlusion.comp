// Share of the light from all around that is not absorbed within a box about every cell: three boxes tell the
// extinction of three shells [Schlegel2011], mean depth d and mean square e, and V is the product of
// 1 - d^2 / e (1 - exp(-e / d)): a part d^2 / e of all directions is e / d deep, the rest is free.
// Domain: one invocation a cell, slices of cells along z. Dispatched by technique/summed_area/field.rs.
#version 460
#extension GL_GOOGLE_include_directive : require
layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 0, r32ui) readonly uniform uimage3D sums;
layout(set = 0, binding = 1, r32ui) readonly uniform uimage3D squares;
layout(set = 0, binding = 2, r16f) writeonly uniform image3D occlusion;

layout(push_constant) uniform Push {
    float half_box_x;    // cells to either side
    float half_box_y;
    float half_box_z;
    float depth_a_level; // optical depth of a shell of a third of the box, a level that a box of
                         // the largest size holds
    uint first_slice;
    uint slice_count;
    float square_a_level; // square of that depth, a level of squares
} push;

#define WHOLE uvec2
#define SIGNED ivec2
#define REAL vec2
WHOLE sum_at(ivec3 at) {
    return uvec2(imageLoad(sums, at).r, imageLoad(squares, at).r);
}
#include "shared/box_sum.glsl"

const int SHELLS = 3;

void main() {
    ivec3 cell = ivec3(gl_GlobalInvocationID.xy, gl_GlobalInvocationID.z + push.first_slice);
    ivec3 cells = imageSize(sums);
    if (gl_GlobalInvocationID.z >= push.slice_count || any(greaterThanEqual(cell, cells))) return;
    vec3 half_box = vec3(push.half_box_x, push.half_box_y, push.half_box_z);
    vec3 centre = vec3(cell) + 0.5;
    int planes = is_empty(centre - half_box, centre + half_box, cells) ? 0 : 4;
    vec2 a_level = vec2(push.depth_a_level, push.square_a_level);
    vec2 sum_within = vec2(0.0);
    float share_seen = 1.0, volume_within = 0.0;
    for (int i = 1; i <= SHELLS; ++i) {
        float share = float(i) / float(SHELLS);
        vec2 sum = box_sum(centre - share * half_box, centre + share * half_box, cells, planes);
        float volume = share * share * share;
        vec2 shell = a_level * max(sum - sum_within, vec2(0.0)) / (volume - volume_within);
        // No mean of squares is below the square of the mean, but for rounding: then the shell is even.
        float depth = max(shell.x, 1e-15);
        float square = max(shell.y, depth * depth);
        // Vacuum is exactly clear.
        share_seen *= shell.x > 0.0 ? 1.0 - depth * depth / square * (1.0 - exp(-square / depth)) : 1.0;
        sum_within = sum;
        volume_within = volume;
    }
    imageStore(occlusion, cell, vec4(share_seen));
}
