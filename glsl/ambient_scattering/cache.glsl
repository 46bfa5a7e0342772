// The radiance cache as camera rays read it: one block of nodes a light, stacked along z.

layout(set = 0, binding = 9) uniform sampler3D radiance_cache;

// The block's values in registers.
vec3 node_first; // grid coordinates
vec3 per_spacing;
vec3 node_last;

void load_cache() {
    node_first = ambient.node_first.xyz;
    per_spacing = 1.0 / ambient.node_spacing.xyz;
    node_last = ambient.node_last.xyz;
}

// Of an image of such blocks, at grid coordinates q: within block l, nothing of the next one's nodes.
vec3 place_in_block(vec3 q, uint l, vec3 per_texel) {
    vec3 node = clamp((q - node_first) * per_spacing, vec3(0.0), node_last);
    node.z += float(l) * (node_last.z + 1.0);
    return (node + 0.5) * per_texel;
}

// The light that arrives at x, whose grid coordinates are q.
vec4 light_at(vec3 x, vec3 q, uint l) {
    vec4 arrived;
    if (CACHED) {
        arrived = textureLod(radiance_cache, place_in_block(q, l, 1.0 / vec3(textureSize(radiance_cache, 0))), 0.0);
    } else {
        arrived = arriving(x, lights[l]);
    }
    return arrived;
}
