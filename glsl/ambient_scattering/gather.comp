// What every node of the radiance cache scatters towards the viewer: camera rays look it up instead of putting it
// together from cache and tables at every look.
// Domain: nodes along x and y, nodes along z; 8 x 8 nodes a workgroup. Dispatched by
// technique/ambient_scattering/record.rs.
#version 460
#extension GL_GOOGLE_include_directive : require
layout(local_size_x = 8, local_size_y = 8) in;

layout(constant_id = 2) const bool POINT_LIGHTS = false;
layout(constant_id = 7) const uint LIGHT_COUNT = 0;
layout(constant_id = 9) const bool ISOTROPIC = false;
layout(constant_id = 12) const bool LITERAL_GATHER = false;
layout(constant_id = 14) const bool ENVIRONMENT = false;
layout(constant_id = 16) const bool HAS_LIGHTS = false;
layout(constant_id = 17) const uint APART = 0;

const float INV_4_PI = 0.0795774715;
const bool AT_NODES = true;

#define AMBIENT_BINDING 0
#define LOOK_BINDING 4
#include "ambient_scattering/ambient.glsl"
#include "shared/phase.glsl"
#include "ambient_scattering/look.glsl"

layout(set = 0, binding = 3) uniform sampler3D radiance_cache;
// As the cache one block of nodes a look.
layout(set = 0, binding = 6) writeonly uniform image3D gathered_light;

layout(push_constant) uniform Push {
    uint first_slice;
    uint slice_count;
} push;

ivec3 node;
int slices;

vec4 light_at(vec3 x, vec3 q, uint l) {
    return texelFetch(radiance_cache, ivec3(node.xy, node.z + int(l) * slices), 0);
}

void main() {
    load_ambient();
    load_look();
    node = ivec3(gl_GlobalInvocationID.xy, push.first_slice + gl_GlobalInvocationID.z);
    ivec3 last = ivec3(ambient.node_last.xyz);
    if (gl_GlobalInvocationID.z >= push.slice_count || any(greaterThan(node, last))) return;
    slices = last.z + 1;
    vec4 q = vec4(ambient.node_first.xyz + vec3(node) * ambient.node_spacing.xyz, 1.0);
    vec3 x = vec3(dot(ambient.world_from_grid[0], q), dot(ambient.world_from_grid[1], q),
                  dot(ambient.world_from_grid[2], q));
    vec3 seen[LOOKS];
    look(x, q.xyz, direction_to(x), seen);
    for (uint l = 0; l < LOOKS; ++l)
        imageStore(gathered_light, ivec3(node.xy, node.z + int(l) * slices), vec4(seen[l], 0.0));
}
