// The march, whatever the medium is read through: shared/medium_filtered.glsl or
// shared/medium_loaded.glsl.
layout(local_size_x = 64) in;

layout(constant_id = 0) const bool SKIP_EMPTY = false;
layout(constant_id = 1) const bool SHADE = false;
layout(constant_id = 2) const bool SPECULAR = false;
layout(constant_id = 3) const bool MASKED = false;
layout(constant_id = 4) const bool CLIP_BOX = false;
layout(constant_id = 5) const bool CLIP_PLANE = false;
layout(constant_id = 6) const uint LIGHT_COUNT = 0;
layout(constant_id = 7) const bool POINT_LIGHTS = false;
layout(constant_id = 8) const uint SPREAD = 1;
layout(constant_id = 9) const int BLOCK = 4;

#include "shared/view.glsl"
#include "shared/intersect.glsl"
#include "shared/lights.glsl"
#include "shared/transmittance.glsl"
#include "shared/empty_space.glsl"

#define MATERIAL 7
#include "shared/material.glsl"

const float INV_PI = 0.318309886;

layout(std140, set = 0, binding = 1) uniform March {
    vec4 table;        // texture value of the first entry, entries a unit of it, entries, unused
    vec4 dims;         // voxels along x, y, z; w: largest step, world units
    vec4 cell_scale;   // cells a unit of texture coordinate; w: optical depth that ends a ray
    vec4 ambient;      // rgb: ambient factor times environment radiance; w: diffuse factor
    vec4 specular;     // x: factor, y: exponent, z: opacity gathered under one gradient
    vec4 gradient[3];  // world direction of a difference along x, y, z
    Light lights[MAX_LIGHTS];
} march;

layout(set = 0, binding = 6, rgba32f) uniform image2D radiance;

// The block's values in registers: lavapipe reads a uniform anew at each use, lane by lane.
float tau_end;
mat3 world_from_difference;
vec4 ambient;
vec4 specular;
Light lights[LIGHT_COUNT + 1];

#include "shared/tiles.glsl"

layout(push_constant) uniform Push {
    uint first_tile;
    uint tile_count;
    uint sub_sample;
} push;

// Central differences one voxel to either side (clamped at the faces), turned into a world-space
// direction; its length is relative to the data range a voxel.
vec3 world_gradient(vec3 q) {
    return world_from_difference * differences_at(q);
}

// Radiance towards w_o, at world position x, of samples of the given weight and weighted colour.
vec3 shade(float weight, vec3 color, vec3 gradient, vec3 x, vec3 w_o) {
    vec3 radiance = ambient.rgb * color;
    // No direction can be told below 1e-15 of the data range a voxel.
    vec3 n = gradient * inversesqrt(max(dot(gradient, gradient), 1e-30));
    // The side that faces the viewer is lit.
    n = dot(n, w_o) < 0.0 ? -n : n;
    for (uint i = 0; i < LIGHT_COUNT; ++i) {
        Light light = lights[i];
        vec3 w_i = light.place.xyz;
        vec3 irradiance = light.irradiance.rgb;
        if (POINT_LIGHTS && light.place.w > 0.0) {
            w_i -= x;
            float d = max(length(w_i), 1e-30);
            w_i /= d;
            if (light.irradiance.w > 0.0) irradiance = irradiance / d / d;
        }
        float cos_i = max(dot(n, w_i), 0.0);
        vec3 reflected = ambient.w * cos_i * color;
        if (SPECULAR) {
            float cos_h = max(dot(n, normalize(w_i + w_o)), 0.0);
            reflected += cos_i > 0.0 ? weight * specular.x * pow(cos_h, specular.y) : 0.0;
        }
        radiance += irradiance * INV_PI * reflected;
    }
    return radiance;
}

#include "shared/block.glsl"

// Radiance of a block, lit. Samples in a row share the gradient at their weighted mean place until they
// have gathered a little opacity together: a gradient costs as much as three samples, and the faint
// ones hardly show. Each keeps its own colour.
vec3 shade_block(Block block, SteppedRay ray, int i, float dt, vec3 x_first, vec3 direction) {
    // Groups are counted first: on lavapipe 22.3 a loop that ended on what it chose itself lost samples.
    int group[MAX_BLOCK];
    int groups = 0;
    float gathered = 0.0;
    for (int k = 0; k < BLOCK; ++k) {
        bool full = gathered > specular.z && block.weight[k] > 0.0;
        gathered = block.weight[k] + (full ? 0.0 : gathered);
        groups += full ? 1 : 0;
        group[k] = groups;
    }
    vec3 radiance = vec3(0.0);
    for (int g = 0; g <= groups; ++g) {
        float weight = 0.0, moment = 0.0;
        vec3 color = vec3(0.0);
        for (int k = 0; k < BLOCK; ++k) {
            float w = group[k] == g ? block.weight[k] : 0.0;
            weight += w;
            moment += float(k) * w;
            color += w * block.color[k];
        }
        float at = float(i) + moment / max(weight, 1e-30);
        vec3 gradient = world_gradient(ray.first + at * ray.per_step);
        radiance += shade(weight, color, gradient, x_first + at * dt * direction, -direction);
    }
    return radiance;
}

vec4 march_ray(Ray ray, vec2 t) {
    float length_t = t.y - t.x;
    // A length of a whole number of steps must not become one more by rounding.
    int count = max(1, int(ceil(length_t / march.dims.w - 1e-3)));
    float dt = length_t / float(count);
    vec3 dp = texture_direction(ray.direction) * dt;
    vec3 x_first = ray.origin + (t.x + 0.5 * dt) * ray.direction;
    vec3 p_first = texture_point(x_first);
    CellRay cells = cell_ray(p_first, dp, march.cell_scale.xyz);
    vec3 dims = last_voxel + 1.0;
    SteppedRay grid = SteppedRay(p_first * dims - 0.5, dp * dims);
    Before before = Before(0.0, 1.0);
    vec3 sum = vec3(0.0);
    int i = 0;
    while (i < count && before.tau < tau_end) {
        if (SKIP_EMPTY) {
            // Neighbouring rays skip together, so that they also sample together.
            int skipped;
            do {
                skipped = empty_steps(cells, float(i), last_voxel);
                i += skipped;
            } while (skipped > 0 && i < count);
            if (i >= count) break;
            // Lit, blocks are the same whatever was skipped.
            if (SHADE) i -= i % BLOCK;
        }
        Block block = sample_block(grid, i, count, dt, before);
        if (SHADE) {
            sum += shade_block(block, grid, i, dt, x_first, ray.direction);
        } else {
            for (int k = 0; k < BLOCK; ++k) sum += block.weight[k] * block.color[k];
        }
        i += BLOCK;
    }
    float alpha = before.tau < 0.03 ? absorbed(1.0, 0.0, before.tau) : 1.0 - before.transmittance;
    return vec4(sum + before.transmittance * view.background.rgb, alpha);
}

void main() {
    table = march.table;
    last_voxel = march.dims.xyz - 1.0;
    load_material();
    tau_end = march.cell_scale.w;
    if (SHADE) {
        world_from_difference = mat3(march.gradient[0].xyz, march.gradient[1].xyz, march.gradient[2].xyz);
        ambient = march.ambient;
        specular = march.specular;
        for (uint i = 0; i < LIGHT_COUNT; ++i) lights[i] = march.lights[i];
    }
    uvec2 pixel;
    if (!pixel_of(push.first_tile, push.tile_count, pixel)) return;

    Ray ray = camera_ray(pixel, push.sub_sample);
    vec2 t = clip_to_box(vec2(ray.t_min, 3.0e38), texture_point(ray.origin),
                         texture_direction(ray.direction), vec3(0.0), vec3(1.0));
    if (CLIP_BOX) t = clip_to_box(t, ray.origin, ray.direction, view.clip_min.xyz, view.clip_max.xyz);
    if (CLIP_PLANE) t = clip_to_half_space(t, ray.origin, ray.direction, view.clip_plane);
    vec4 result = t.x < t.y ? march_ray(ray, t) : vec4(view.background.rgb, 0.0);

    float weight = 1.0 / float(view.image.z * view.image.z);
    if (push.sub_sample > 0) result = imageLoad(radiance, ivec2(pixel)) + result * weight;
    else result *= weight;
    imageStore(radiance, ivec2(pixel), result);
}
