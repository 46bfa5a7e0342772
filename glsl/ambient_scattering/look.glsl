// What is scattered towards the viewer at one point, by every light. The includer declares light_at, the light that
// arrives there.

layout(set = 0, binding = LOOK_BINDING) uniform sampler2D scattered;
layout(set = 0, binding = 1 + LOOK_BINDING) uniform sampler3D occlusion;

// Lights that weaken with distance each, and last the sum of all others and of the environment.
const uint LOOKS = APART + 1;

// Entries of the table along the angle, as in lookup.rs.
const float ANGLES = 128.0;

// As above, in registers.
Light lights[LIGHT_COUNT + 1];
vec3 per_voxel; // texture coordinates of the volume
vec3 occlusion_scale;
vec3 environment;
float phase_g;
float spread_g;
vec3 dimming_ratio;

void load_look() {
    for (uint l = 0; l < LIGHT_COUNT; ++l) lights[l] = ambient.lights[l];
    per_voxel = 1.0 / ambient.dims.xyz;
    occlusion_scale = ambient.occlusion_scale.xyz;
    environment = ambient.environment.rgb;
    phase_g = ambient.node_spacing.w;
    spread_g = ambient.extinction_scale.w;
    dimming_ratio = ambient.dimming_ratio.rgb;
}

vec4 light_at(vec3 x, vec3 q, uint l);

float phase(float cos_theta, float g) {
    return ISOTROPIC ? INV_4_PI : phase_hg(cos_theta, g);
}

// Radiance that a sample at x, whose grid coordinates are q, scatters against `direction`, per unit albedo; of
// lights that weaken with distance apart, but for how they do.
void look(vec3 x, vec3 q, vec3 direction, out vec3 radiance[LOOKS]) {
    vec3 p = (q + 0.5) * per_voxel;
    for (uint l = 0; l < APART; ++l) radiance[l] = vec3(0.0);
    radiance[APART] = ENVIRONMENT ? textureLod(occlusion, p * occlusion_scale, 0.0).r * environment : vec3(0.0);
    // The optical depth of a radius: the sphere's, and the tube's within it.
    float depth = 0.0;
    if (HAS_LIGHTS) depth = ambient_depth(p);
    float place = place_of(depth);
    // Nodes with no medium near scatter nothing that a ray would find.
    uint count = AT_NODES && depth <= 0.0 ? 0 : LIGHT_COUNT;
    for (uint l = 0; l < count; ++l) {
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
        radiance[min(l, APART)] += sum * lights[l].irradiance.rgb;
    }
}
