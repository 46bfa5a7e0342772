// What is scattered towards the viewer at one point, by every light.

layout(set = 0, binding = 9) uniform sampler3D radiance_cache;
layout(set = 0, binding = 10) uniform sampler2D scattered;
layout(set = 0, binding = 11) uniform sampler3D occlusion;

// Places of lights and, the last, of the environment.
const uint LOOKS = LIGHT_COUNT + 1;

// The light that arrives at x, whose grid coordinates are q: one block of nodes a light, stacked along z.
vec4 light_at(vec3 x, vec3 q, uint l) {
    if (!CACHED) return arriving(x, ambient.lights[l]);
    vec3 last = ambient.node_last.xyz;
    vec3 at = clamp((q - ambient.node_first.xyz) / ambient.node_spacing.xyz, vec3(0.0), last);
    at.z += float(l) * (last.z + 1.0);
    return textureLod(radiance_cache, (at + 0.5) / vec3(textureSize(radiance_cache, 0)), 0.0);
}

float phase(float cos_theta, float g) {
    return ISOTROPIC ? INV_4_PI : phase_hg(cos_theta, g);
}

// Radiance that a sample at x scatters against `direction`, per unit albedo: of each light, but for how it
// weakens with distance, and of the environment.
void look(vec3 x, vec3 direction, out vec3 radiance[LOOKS]) {
    vec3 p = texture_point(x);
    vec3 q = p * (last_voxel + 1.0) - 0.5;
    // The optical depth of a radius: the sphere's, and the tube's within it.
    float depth = LIGHT_COUNT > 0 ? ambient_depth(p) : 0.0;
    vec3 passed = LITERAL_GATHER ? vec3(0.0) : exp(-depth * dimming(depth));
    vec2 entries = vec2(textureSize(scattered, 0));
    float place = place_of(depth, entries.y);
    for (uint l = 0; l < LIGHT_COUNT; ++l) {
        Light light = ambient.lights[l];
        vec3 w_i = light.place.xyz;
        if (POINT_LIGHTS && light.place.w > 0.0) w_i = normalize(w_i - x);
        float cos_theta = clamp(dot(w_i, direction), -1.0, 1.0);
        // The table's other axis is the sine of half the angle.
        float angle = sqrt(max(0.5 - 0.5 * cos_theta, 0.0));
        vec3 about = textureLod(scattered, vec2((angle * (entries.x - 1.0) + 0.5) / entries.x, place), 0.0).rgb;
        vec4 arrived = light_at(x, q, l);
        vec3 sum = arrived.rgb * about;
        if (!LITERAL_GATHER) {
            vec3 spread = max(arrived.rgb * passed - arrived.a, vec3(0.0));
            sum += arrived.a * phase(cos_theta, ambient.node_spacing.w)
                 + spread * phase(cos_theta, ambient.extinction_scale.w);
        }
        radiance[l] = sum * light.irradiance.rgb;
    }
    radiance[LIGHT_COUNT] = ENVIRONMENT
        ? textureLod(occlusion, p * ambient.occlusion_scale.xyz, 0.0).r * ambient.environment.rgb : vec3(0.0);
}
