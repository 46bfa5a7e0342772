// What is scattered towards the viewer at one point, by every light.

layout(set = 0, binding = 9) uniform sampler3D radiance_cache;
layout(set = 0, binding = 10) uniform sampler2D scattered;
layout(set = 0, binding = 11) uniform sampler3D occlusion;

// Places of lights and, the last, of the environment.
const uint LOOKS = LIGHT_COUNT + 1;

// Entries of the table along the angle, as in lookup.rs.
const float ANGLES = 128.0;

// As above, in registers.
Light lights[LOOKS];
vec3 per_voxel;  // texture coordinates of the volume
vec3 cache_scale; // texture coordinates of the cache, those of the first light's nodes and of the last ones
vec3 cache_offset;
vec3 cache_first;
vec3 cache_last;
float cache_light; // from light to light
vec3 occlusion_scale;
vec3 environment;
float phase_g;
float spread_g;
vec3 dimming_ratio;

void load_look() {
    for (uint l = 0; l < LIGHT_COUNT; ++l) lights[l] = ambient.lights[l];
    per_voxel = 1.0 / ambient.dims.xyz;
    vec3 nodes = ambient.node_last.xyz + 1.0;
    vec3 per_node = 1.0 / vec3(textureSize(radiance_cache, 0));
    cache_scale = per_node / ambient.node_spacing.xyz;
    cache_first = 0.5 * per_node;
    cache_offset = cache_first - cache_scale * ambient.node_first.xyz;
    cache_last = (nodes - 0.5) * per_node;
    cache_light = nodes.z * per_node.z;
    occlusion_scale = ambient.occlusion_scale.xyz;
    environment = ambient.environment.rgb;
    phase_g = ambient.node_spacing.w;
    spread_g = ambient.extinction_scale.w;
    dimming_ratio = ambient.dimming_ratio.rgb;
}

// The light that arrives at x, whose grid coordinates are q: one block of nodes a light, stacked along z.
vec4 light_at(vec3 x, vec3 q, uint l) {
    vec4 arrived;
    if (CACHED) {
        // Within the block's own nodes: nothing of the next light's.
        vec3 at = clamp(q * cache_scale + cache_offset, cache_first, cache_last);
        at.z += float(l) * cache_light;
        arrived = textureLod(radiance_cache, at, 0.0);
    } else {
        arrived = arriving(x, lights[l]);
    }
    return arrived;
}

float phase(float cos_theta, float g) {
    return ISOTROPIC ? INV_4_PI : phase_hg(cos_theta, g);
}

// Radiance that a sample at x, whose grid coordinates are q, scatters against `direction`, per unit albedo: of
// each light, but for how it weakens with distance, and of the environment.
void look(vec3 x, vec3 q, vec3 direction, out vec3 radiance[LOOKS]) {
    vec3 p = (q + 0.5) * per_voxel;
    // The optical depth of a radius: the sphere's, and the tube's within it.
    float depth = 0.0;
    if (HAS_LIGHTS) depth = ambient_depth(p);
    float place = place_of(depth);
    for (uint l = 0; l < LIGHT_COUNT; ++l) {
        vec3 w_i = lights[l].place.xyz;
        if (POINT_LIGHTS && lights[l].place.w > 0.0) w_i = normalize(w_i - x);
        float cos_theta = clamp(dot(w_i, direction), -1.0, 1.0);
        // The table's other axis is the sine of half the angle.
        float angle = sqrt(max(0.5 - 0.5 * cos_theta, 0.0));
        vec4 about = textureLod(scattered, vec2((angle * (ANGLES - 1.0) + 0.5) / ANGLES, place), 0.0);
        vec4 arrived = light_at(x, q, l);
        vec3 sum = arrived.rgb * about.rgb;
        // The tube's last half step; the table holds the mean over the channels.
        vec3 passed = exp(-depth * about.a * dimming_ratio);
        vec3 spread = max(arrived.rgb * passed - arrived.a, vec3(0.0));
        vec3 split = arrived.a * phase(cos_theta, phase_g) + spread * phase(cos_theta, spread_g);
        sum += LITERAL_GATHER ? vec3(0.0) : split;
        radiance[l] = sum * lights[l].irradiance.rgb;
    }
    radiance[LIGHT_COUNT] = ENVIRONMENT ? textureLod(occlusion, p * occlusion_scale, 0.0).r * environment : vec3(0.0);
}
