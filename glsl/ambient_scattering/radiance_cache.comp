// The light of one source that arrives at every node of a grid over the volume, dimmed along a tube
// [Ament2013, Section 4.2.2].
// Domain: nodes along x and y, slices of nodes along z; 8 x 8 nodes a workgroup. Dispatched by
// technique/ambient_scattering/record.rs.
#version 460
#extension GL_GOOGLE_include_directive : require
layout(local_size_x = 8, local_size_y = 8) in;

layout(constant_id = 0) const bool CLIP_BOX = false;
layout(constant_id = 1) const bool CLIP_PLANE = false;
layout(constant_id = 2) const bool POINT_LIGHTS = false;
layout(constant_id = 3) const bool LINEAR_TUBE = false;
layout(constant_id = 4) const uint SPREAD = 1;
layout(constant_id = 19) const bool NEAR_ONLY = false;

#define AMBIENT_BINDING 0
#include "ambient_scattering/tube.glsl"

layout(set = 0, binding = 4) writeonly uniform image3D radiance_cache;

layout(push_constant) uniform Push {
    uint light;
    uint first_slice;
    uint slice_count;
} push;

void main() {
    load_ambient();
    // Slices are dealt out to SPREAD streams, so that drivers which give each thread one contiguous run
    // of workgroups still share the busy ones evenly.
    uint streams = (push.slice_count + SPREAD - 1) / SPREAD;
    uint slice = (gl_WorkGroupID.z % streams) * SPREAD + gl_WorkGroupID.z / streams;
    ivec3 node = ivec3(gl_GlobalInvocationID.xy, push.first_slice + slice);
    ivec3 last = ivec3(ambient.node_last.xyz);
    if (slice >= push.slice_count || any(greaterThan(node, last))) return;
    vec4 q = vec4(ambient.node_first.xyz + vec3(node) * ambient.node_spacing.xyz, 1.0);
    vec3 x = vec3(dot(ambient.world_from_grid[0], q), dot(ambient.world_from_grid[1], q),
                  dot(ambient.world_from_grid[2], q));
    vec4 light = vec4(1.0);
    // A loop, not a branch: software drivers go through branches that no lane takes.
    int rounds = NEAR_ONLY && ambient_depth(texture_point(x)) <= 0.0 ? 0 : 1;
    for (int i = 0; i < rounds; ++i) light = arriving(x, ambient.lights[push.light]);
    // The paper's own transmission can exceed what half floats hold.
    imageStore(radiance_cache, ivec3(node.xy, node.z + int(push.light) * (last.z + 1)), min(light, vec4(6e4)));
}
