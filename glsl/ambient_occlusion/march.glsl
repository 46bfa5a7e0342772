// The march, whatever the medium is read through: shared/medium_filtered.glsl or
// shared/medium_loaded.glsl.
layout(local_size_x = 64) in;

layout(constant_id = 0) const bool SKIP_EMPTY = false;
layout(constant_id = 1) const bool MASKED = false;
layout(constant_id = 2) const bool CLIP_BOX = false;
layout(constant_id = 3) const bool CLIP_PLANE = false;
layout(constant_id = 4) const uint SPREAD = 1;
layout(constant_id = 5) const bool ENVIRONMENT = false;
layout(constant_id = 6) const bool EMISSION = false;
layout(constant_id = 7) const bool ALBEDO_VOLUME = false;

#include "shared/view.glsl"
#include "shared/intersect.glsl"
#include "shared/inside.glsl"
#include "shared/transmittance.glsl"
#include "shared/empty_space.glsl"

#define MATERIAL 9
#include "shared/material.glsl"

const int BLOCK = 4;

layout(std140, set = 0, binding = 1) uniform Occluded {
    vec4 table;           // texture value of the first entry, entries a unit of it, entries; w unused
    vec4 dims;            // voxels along x, y, z; w: largest step, world units
    vec4 cell_scale;      // cells a unit of texture coordinate; w: optical depth that ends a ray
    vec4 occlusion_scale; // texture coordinates of the occlusion a unit of the volume's; w unused
    vec4 environment;     // radiance times the factor of the albedo; w: factor on the colour that gives the emission
} occluded;

layout(set = 0, binding = 6, rgba32f) uniform image2D radiance;
layout(set = 0, binding = 7) uniform sampler3D occlusion;
layout(set = 0, binding = 8) uniform sampler3D albedo_volume;

// The block's values in registers: lavapipe reads a uniform anew at each use, lane by lane.
float tau_end;

#include "shared/tiles.glsl"

layout(push_constant) uniform Push {
    uint first_tile;
    uint tile_count;
    uint sub_sample;
} push;

#include "shared/block.glsl"

// What a block scatters of the environment's light, of which the share that arrives is looked at where the
// block begins and ends; field: the ray in texture coordinates of the occlusion.
vec3 gathered(Block block, SteppedRay grid, SteppedRay field, int i, int count) {
    // Two looks a block cost less than to remember one for the next.
    int end = min(i + BLOCK, count);
    float first = textureLod(occlusion, field.first + (float(i) - 0.5) * field.per_step, 0.0).r;
    float last = textureLod(occlusion, field.first + (float(end) - 0.5) * field.per_step, 0.0).r;
    float per_sample = 1.0 / float(end - i);
    vec3 sum = vec3(0.0);
    for (int k = 0; k < BLOCK; ++k) {
        vec3 albedo = block.color[k];
        if (ALBEDO_VOLUME) {
            vec3 q = grid.first + float(i + k) * grid.per_step;
            albedo = textureLod(albedo_volume, texture_of(q), 0.0).rgb;
        }
        sum += block.weight[k] * mix(first, last, (float(k) + 0.5) * per_sample) * albedo;
    }
    return sum;
}

vec4 march_ray(Ray ray, vec2 t) {
    int count = steps_along(t.y - t.x, occluded.dims.w);
    float dt = (t.y - t.x) / float(count);
    vec3 p_first = texture_point(ray.origin + (t.x + 0.5 * dt) * ray.direction);
    vec3 dp = texture_direction(ray.direction) * dt;
    CellRay cells = cell_ray(p_first, dp, occluded.cell_scale.xyz);
    vec3 dims = last_voxel + 1.0;
    SteppedRay grid = SteppedRay(p_first * dims - 0.5, dp * dims);
    vec3 scale = occluded.occlusion_scale.xyz;
    SteppedRay field = SteppedRay(p_first * scale, dp * scale);
    Before before = Before(0.0, 1.0);
    vec3 lit = vec3(0.0), emitted = vec3(0.0);
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
        }
        Block block = sample_block(grid, i, count, dt, before);
        if (ENVIRONMENT) lit += gathered(block, grid, field, i, count);
        if (EMISSION) {
            for (int k = 0; k < BLOCK; ++k) emitted += block.weight[k] * block.color[k];
        }
        i += BLOCK;
    }
    vec4 environment = occluded.environment;
    vec3 sum = environment.rgb * lit + environment.w * emitted;
    return vec4(sum + before.transmittance * view.background.rgb, absorbed(1.0, before.transmittance, before.tau));
}

void main() {
    table = occluded.table;
    last_voxel = occluded.dims.xyz - 1.0;
    load_material();
    tau_end = occluded.cell_scale.w;
    uvec2 pixel;
    if (!pixel_of(push.first_tile, push.tile_count, pixel)) return;

    Ray ray = camera_ray(pixel, push.sub_sample);
    vec2 t = inside(vec2(ray.t_min, 3.0e38), ray.origin, ray.direction);
    vec4 result = t.x < t.y ? march_ray(ray, t) : vec4(view.background.rgb, 0.0);
    result /= float(view.image.z * view.image.z);
    if (push.sub_sample > 0) result += imageLoad(radiance, ivec2(pixel));
    imageStore(radiance, ivec2(pixel), result);
}
