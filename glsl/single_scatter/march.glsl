// The march, whatever the medium is read through: shared/medium_filtered.glsl or
// shared/medium_loaded.glsl.
layout(local_size_x = 64) in;

layout(constant_id = 0) const bool SKIP_EMPTY = false;
layout(constant_id = 1) const bool MASKED = false;
layout(constant_id = 2) const bool CLIP_BOX = false;
layout(constant_id = 3) const bool CLIP_PLANE = false;
layout(constant_id = 4) const bool POINT_LIGHTS = false;
layout(constant_id = 5) const uint SPREAD = 1;
layout(constant_id = 6) const uint LIGHT_COUNT = 0;
layout(constant_id = 7) const bool CACHED = false;
layout(constant_id = 8) const bool ISOTROPIC = false;
layout(constant_id = 9) const bool EMISSION = false;
layout(constant_id = 10) const bool ALBEDO_VOLUME = false;

#define MATERIAL 9
#include "single_scatter/shadow.glsl"
#include "single_scatter/depths.glsl"
#include "shared/phase.glsl"
#include "shared/transmittance.glsl"

const float INV_4_PI = 0.0795774715;

layout(set = 0, binding = 6, rgba32f) uniform image2D radiance;
layout(set = 0, binding = 8) uniform sampler3D albedo_volume;

#include "shared/tiles.glsl"

layout(push_constant) uniform Push {
    uint first_tile;
    uint tile_count;
    uint sub_sample;
    uint first_sample; // samples that begin a block before it have had their light
    uint end_sample;   // and those from here on get it later
} push;

float phase(float cos_theta) {
    return ISOTROPIC ? INV_4_PI : phase_hg(cos_theta, scatter.node_spacing.w);
}

// Samples i to i + BLOCK - 1; those past the ray's end, or its last that can be seen, are empty.
Block sample_block(ViewRay ray, int i, int count, float tau, float tau_end) {
    Block block;
    float values[MAX_BLOCK];
    values_of(ray.grid.first, ray.grid.per_step, i, BLOCK, values);
    block.tau[0] = tau;
    for (int k = 0; k < BLOCK; ++k) {
        vec3 q = ray.grid.first + float(i + k) * ray.grid.per_step;
        vec4 material = material_of(values[k], q);
        float dtau = i + k < count && tau < tau_end ? material.a * ray.dt : 0.0;
        if (MASKED) dtau *= finite_weight(q);
        tau += dtau;
        block.dtau[k] = dtau;
        block.tau[k + 1] = tau;
        block.color[k] = material.rgb;
        block.albedo[k] = material.rgb;
        if (ALBEDO_VOLUME) block.albedo[k] = textureLod(albedo_volume, texture_of(q), 0.0).rgb;
    }
    return block;
}

// Light of one source that the block scatters towards the viewer. Over a sample, extinction, the depth to
// the light and with them the exponent change evenly: exact in a homogeneous medium at any step.
vec3 scattered(Block block, ViewRay ray, int i, int count, int l) {
    Light light = scatter.lights[l];
    float depths[BLOCK + 1];
    if (CACHED) {
        cached_depths(block, ray, i, count, light, l, depths);
        int direct = POINT_LIGHTS && is_close(ray, i, light) ? BLOCK + 1 : 0;
        for (int k = 0; k < direct; ++k) {
            depths[k] = shadow_depth(end_of(ray, i + k, count), light);
        }
    } else {
        for (int k = 0; k <= BLOCK; ++k) {
            depths[k] = shadow_depth(end_of(ray, i + k, count), light);
        }
    }
    vec3 sum = vec3(0.0);
    float along = phase(dot(light.place.xyz, ray.direction));
    float before = exp(-(block.tau[0] + depths[0]));
    for (int k = 0; k < BLOCK; ++k) {
        float after = exp(-(block.tau[k + 1] + depths[k + 1]));
        float rise = block.dtau[k] + depths[k + 1] - depths[k];
        float weight = block.dtau[k] * mean_between(before, after, rise);
        before = after;
        if (POINT_LIGHTS) {
            vec3 x = ray.x_first + float(i + k) * ray.dt * ray.direction;
            vec3 w_i = normalize(light.place.xyz - x);
            float falloff = light.irradiance.w > 0.0 ? mean_falloff(light.place.xyz, x, ray.direction, ray.dt)
                                                     : 1.0;
            weight *= light.place.w > 0.0 ? falloff * phase(dot(w_i, ray.direction)) : along;
        } else {
            weight *= along;
        }
        sum += weight * block.albedo[k];
    }
    return scatter.table.w * sum * light.irradiance.rgb;
}

// Radiance (rgb) of the samples from first_sample to end_sample, and `1 - transmittance` of the ray up to
// there.
vec4 march_ray(Ray camera, vec2 t) {
    int count = steps_along(t.y - t.x, scatter.dims.w);
    float dt = (t.y - t.x) / float(count);
    vec3 x_first = camera.origin + (t.x + 0.5 * dt) * camera.direction;
    vec3 p_first = texture_point(x_first);
    vec3 dp = texture_direction(camera.direction) * dt;
    CellRay cell = cell_ray(p_first, dp, cells);
    ViewRay ray = ViewRay(x_first, camera.direction, grid_ray(p_first, dp), dt);
    float tau_end = scatter.cell_scale.w;
    vec3 gathered = vec3(0.0);
    float tau = 0.0;
    int i = 0;
    int end = int(min(uint(count), push.end_sample));
    while (i < end && tau < tau_end) {
        if (SKIP_EMPTY) {
            // Neighbouring rays skip together, so that they also sample together.
            int skipped;
            do {
                skipped = empty_steps(cell, float(i), last_voxel);
                i += skipped;
            } while (skipped > 0 && i < end);
            if (i >= end) break;
        }
        Block block = sample_block(ray, i, count, tau, tau_end);
        bool now = i >= int(push.first_sample);
        // A loop, not a branch: software drivers go through branches that no lane takes.
        int lit = now && block.tau[BLOCK] > tau ? int(LIGHT_COUNT) : 0;
        for (int l = 0; l < lit; ++l) gathered += scattered(block, ray, i, count, l);
        if (EMISSION && now) {
            for (int k = 0; k < BLOCK; ++k) {
                float weight = absorbed(exp(-block.tau[k]), exp(-block.tau[k + 1]), block.dtau[k]);
                gathered += scatter.node_last.w * weight * block.color[k];
            }
        }
        tau = block.tau[BLOCK];
        i += BLOCK;
    }
    return vec4(gathered, absorbed(1.0, exp(-tau), tau));
}

void main() {
    load_block();
    if (CACHED) load_nodes();
    uvec2 pixel;
    if (!pixel_of(push.first_tile, push.tile_count, pixel)) return;

    Ray ray = camera_ray(pixel, push.sub_sample);
    vec2 t = inside(vec2(ray.t_min, 3.0e38), ray.origin, ray.direction);
    vec4 result = t.x < t.y ? march_ray(ray, t) : vec4(0.0);

    // The last range of samples knows how much is seen of the background.
    bool last = push.end_sample == 0xffffffffu;
    result.rgb += last ? (1.0 - result.a) * view.background.rgb : vec3(0.0);
    result.a = last ? result.a : 0.0;
    float weight = 1.0 / float(view.image.z * view.image.z);
    bool fresh = push.sub_sample == 0 && push.first_sample == 0;
    if (!fresh) result = imageLoad(radiance, ivec2(pixel)) + result * weight;
    else result *= weight;
    imageStore(radiance, ivec2(pixel), result);
}
