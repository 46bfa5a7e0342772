// The march, whatever the medium is read through: shared/medium_filtered.glsl or
// shared/medium_loaded.glsl.
layout(local_size_x = 64) in;

layout(constant_id = 0) const bool CLIP_BOX = false;
layout(constant_id = 1) const bool CLIP_PLANE = false;
layout(constant_id = 2) const bool POINT_LIGHTS = false;
layout(constant_id = 3) const bool LINEAR_TUBE = false;
layout(constant_id = 4) const uint SPREAD = 1;
layout(constant_id = 5) const bool SKIP_EMPTY = false;
layout(constant_id = 6) const bool MASKED = false;
layout(constant_id = 7) const uint LIGHT_COUNT = 0;
layout(constant_id = 8) const bool CACHED = false;
layout(constant_id = 9) const bool ISOTROPIC = false;
layout(constant_id = 10) const bool EMISSION = false;
layout(constant_id = 11) const bool ALBEDO_VOLUME = false;
layout(constant_id = 12) const bool LITERAL_GATHER = false;
layout(constant_id = 13) const bool SPECULAR = false;
layout(constant_id = 14) const bool ENVIRONMENT = false;
layout(constant_id = 15) const int INTERVAL = 4; // samples between two looks at the light
layout(constant_id = 16) const bool HAS_LIGHTS = false;
layout(constant_id = 17) const uint APART = 0;
layout(constant_id = 18) const bool GATHERED = false; // looks are those that the cache's nodes have taken

const int BLOCK = 4;
const float INV_4_PI = 0.0795774715;
const float INV_PI = 0.318309886;
const bool AT_NODES = false;

#define AMBIENT_BINDING 5
#define LOOK_BINDING 10
#include "ambient_scattering/tube.glsl"
#include "shared/empty_space.glsl"
#include "shared/phase.glsl"
#include "shared/transmittance.glsl"
#define MATERIAL 14
#include "shared/material.glsl"

layout(set = 0, binding = 6, rgba32f) uniform image2D radiance;
layout(set = 0, binding = 12) uniform sampler3D albedo_volume;

#include "ambient_scattering/look.glsl"
#include "ambient_scattering/cache.glsl"
#include "ambient_scattering/block.glsl"
#include "ambient_scattering/interval.glsl"
#include "ambient_scattering/highlight.glsl"

#include "shared/tiles.glsl"

layout(push_constant) uniform Push {
    uint first_tile;
    uint tile_count;
    uint sub_sample;
} push;

vec4 march_ray(Ray camera, vec2 t) {
    int count = steps_along(t.y - t.x, ambient.dims.w);
    ViewRay ray = view_ray(camera, t, count);
    CellRay cell = cell_ray((ray.grid.first + 0.5) / (last_voxel + 1.0), ray.grid.per_step / (last_voxel + 1.0),
                            ambient.cell_scale.xyz);
    float tau_end = ambient.cell_scale.w;
    vec3 sum = vec3(0.0);
    Depths depths = Depths(0.0, 0.0);
    Interval interval;
    interval.end = -1;
    int i = 0;
    while (i < count && depths.from < tau_end) {
        if (SKIP_EMPTY) {
            // Neighbouring rays skip together, so that they also sample together.
            int skipped;
            do {
                skipped = empty_steps(cell, float(i), last_voxel);
                if (LITERAL_GATHER) skipped = min(skipped, empty_steps(cell, max(float(i) - ray.delay, 0.0), last_voxel));
                i += skipped;
            } while (skipped > 0 && i < count);
            if (i >= count) break;
        }
        Block block = sample_block(ray, i, count, tau_end, depths);
        take_looks(ray, i, block.is_lit, interval);
        sum += block.is_lit ? gathered(block, ray, i, interval) : vec3(0.0);
        if (SPECULAR) sum += highlight(block, ray, i);
        if (EMISSION) {
            for (int k = 0; k < BLOCK; ++k) sum += ambient.node_last.w * seen(block, k) * block.color[k];
        }
        i += BLOCK;
    }
    return vec4(sum, absorbed(1.0, exp(-depths.at), depths.at));
}

void main() {
    table = ambient.table;
    last_voxel = ambient.dims.xyz - 1.0;
    load_material();
    load_ambient();
    load_look();
    load_cache();
    uvec2 pixel;
    if (!pixel_of(push.first_tile, push.tile_count, pixel)) return;

    Ray ray = camera_ray(pixel, push.sub_sample);
    vec2 t = inside(vec2(ray.t_min, 3.0e38), ray.origin, ray.direction);
    vec4 result = t.x < t.y ? march_ray(ray, t) : vec4(0.0);
    result.rgb += (1.0 - result.a) * view.background.rgb;
    result /= float(view.image.z * view.image.z);
    if (push.sub_sample > 0) result += imageLoad(radiance, ivec2(pixel));
    imageStore(radiance, ivec2(pixel), result);
}
