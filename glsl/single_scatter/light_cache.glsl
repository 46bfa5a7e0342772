// The light cache, whatever the medium is read through: shared/medium_filtered.glsl or
// shared/medium_loaded.glsl.
layout(local_size_x = 8, local_size_y = 8) in;

layout(constant_id = 0) const bool SKIP_EMPTY = false;
layout(constant_id = 1) const bool MASKED = false;
layout(constant_id = 2) const bool CLIP_BOX = false;
layout(constant_id = 3) const bool CLIP_PLANE = false;
layout(constant_id = 4) const bool POINT_LIGHTS = false;
layout(constant_id = 5) const uint SPREAD = 1;

#define MATERIAL 7
#include "single_scatter/shadow.glsl"

layout(set = 0, binding = 6, r32f) writeonly uniform image3D light_depth;

layout(push_constant) uniform Push {
    uint light;
    uint first_slice;
    uint slice_count;
} push;

void main() {
    load_block();
    // Slices are dealt out to SPREAD streams, so that drivers which give each thread one contiguous run
    // of workgroups still share the busy ones evenly.
    uint streams = (push.slice_count + SPREAD - 1) / SPREAD;
    uint slice = (gl_WorkGroupID.z % streams) * SPREAD + gl_WorkGroupID.z / streams;
    ivec3 node = ivec3(gl_GlobalInvocationID.xy, push.first_slice + slice);
    ivec3 last = ivec3(scatter.node_last.xyz);
    if (slice >= push.slice_count || any(greaterThan(node, last))) return;
    vec4 q = vec4(scatter.node_first.xyz + vec3(node) * scatter.node_spacing.xyz, 1.0);
    vec3 x = vec3(dot(scatter.world_from_grid[0], q), dot(scatter.world_from_grid[1], q),
                  dot(scatter.world_from_grid[2], q));
    float tau = shadow_depth(x, scatter.lights[push.light]);
    imageStore(light_depth, ivec3(node.xy, node.z + int(push.light) * (last.z + 1)), vec4(tau));
}
