// Light on its way through a slice, whatever the medium is read through: shared/medium_filtered.glsl or
// shared/medium_loaded.glsl.
layout(local_size_x = 8, local_size_y = 8) in;

layout(constant_id = 0) const bool SKIP_EMPTY = false;
layout(constant_id = 1) const bool MASKED = false;
layout(constant_id = 2) const bool CLIP_BOX = false;
layout(constant_id = 3) const bool CLIP_PLANE = false;
layout(constant_id = 4) const bool POINT_LIGHTS = false;
layout(constant_id = 5) const bool INDIRECT = false;
layout(constant_id = 6) const bool ISOTROPIC = false;
layout(constant_id = 7) const bool ALBEDO_VOLUME = false;
layout(constant_id = 8) const bool TRANSPORT_TABLE = false;
layout(constant_id = 9) const int QUADS = 1;
layout(constant_id = 10) const uint ROWS = 1;

#define MATERIAL 10
#include "half_angle/sweep.glsl"

const int MAX_QUADS = 4;
const float HALF_PI = 1.57079633;

// Where light leaves the slice.
layout(set = 0, binding = 9, rgba32f) writeonly uniform image2D next;

// A ray of light: a point on it near the volume, its direction, where it begins, and whether it leaves a point.
struct LightRay {
    vec3 origin;
    vec3 direction;
    float t_min;
    bool diverges;
};

LightRay light_ray(ivec2 texel) {
    vec2 at = sweep.light_low.xy + (vec2(texel) + 0.5) * sweep.light_low.z;
    vec3 beside = at.x * sweep.light_u.xyz + at.y * sweep.light_v.xyz;
    if (POINT_LIGHTS && sweep.light.place.w > 0.0) {
        vec3 origin = sweep.light_anchor.xyz + sweep.light_anchor.w * beside;
        vec3 direction = sweep.light_axis.xyz + beside;
        float stretched = length(direction);
        return LightRay(origin, direction / stretched, -sweep.light_anchor.w * stretched, true);
    }
    return LightRay(sweep.light_anchor.xyz + beside, sweep.light_axis.xyz, -3.0e38, false);
}

// In [0, 1), by texel and slice: the gradient noise of [Jimenez2014], shifted from slice to slice.
float random_of(ivec2 texel) {
    vec2 place = vec2(texel) + 5.588238 * float(push.slice & 63u);
    return fract(52.9829189 * fract(dot(place, vec2(0.06711056, 0.00583715))));
}

// Scattered light about a texel: a share of it that lies around, in squares turned by noise, such that the spread
// has the variance of `variance` square texels along each axis, whatever the noise.
vec3 spread(ivec2 texel, vec3 here, float variance) {
    ivec2 last = ivec2(sweep.light_u.w, sweep.light_v.w) - 1;
    float turn = random_of(texel);
    ivec2 offsets[MAX_QUADS];
    float squares = 0.0;
    for (int i = 0; i < QUADS; ++i) {
        // Rings of equal areas, about a ring of that variance.
        float ring = sqrt((float(i) + 0.5) / (0.5 * float(QUADS)));
        float radius = max(ring * sqrt(2.0 * variance) + 0.71, 1.0);
        float angle = HALF_PI * fract(turn + 0.618034 * float(i));
        offsets[i] = ivec2(round(radius * vec2(cos(angle), sin(angle))));
        squares += float(offsets[i].x * offsets[i].x + offsets[i].y * offsets[i].y);
    }
    float share = min(2.0 * variance * float(QUADS) / squares, 1.0);
    vec3 around = vec3(0.0);
    for (int i = 0; i < QUADS; ++i) {
        ivec2 o = offsets[i];
        for (int side = 0; side < 4; ++side) {
            ivec2 at = texel + o;
            ivec2 on = clamp(at, ivec2(0), last);
            // Beyond the buffer there is no medium, or another part of the light.
            float there = at == on ? 1.0 : sweep.light_axis.w;
            around += there * imageLoad(current, on).rgb;
            o = ivec2(-o.y, o.x);
        }
    }
    return mix(here, around / float(4 * QUADS), share);
}

// Carries a texel's light through the slice.
void propagate_texel(ivec2 texel) {
    bool is_there = all(lessThan(texel, push.end));
    LightRay ray = light_ray(texel);
    vec4 light = imageLoad(current, min(texel, push.end - 1));
    SliceRay way = slice_ray(ray.origin, ray.direction);
    vec2 t = in_slice(way, ray.t_min);
    int count = is_there && t.x < t.y ? steps_along(t.y - t.x, axis.w) : 0;
    float dt = (t.y - t.x) / float(max(count, 1));
    float tau = 0.0;
    vec3 tau_i = vec3(0.0);
    for (int i = 0; i < count; ++i) {
        vec3 p = way.p + (t.x + (float(i) + 0.5) * dt) * way.dp;
        int occupied = is_empty(p) ? 0 : 1;
        for (int once = 0; once < occupied; ++once) {
            Sample m = sample_at(p);
            tau += m.sigma_t * dt;
            tau_i += m.sigma_t * dt * m.dims_light;
        }
    }
    if (INDIRECT) {
        // A loop, not a branch: software drivers go through branches that no lane takes.
        int rounds = tau > 0.0 ? 1 : 0;
        for (int once = 0; once < rounds; ++once) {
            float depth = 1.0;
            if (ray.diverges) {
                float beyond = 0.5 * (t.x + t.y) * dot(ray.direction, sweep.light_axis.xyz);
                depth = sweep.light_anchor.w + beyond;
            }
            float size = sweep.light_low.z * depth;
            // Light turns where it is scattered: not in vacuum.
            float turns = (t.y - t.x) * (1.0 - exp(-tau / (t.y - t.x) * sweep.phase.w));
            vec3 around = spread(texel, light.rgb, sweep.light_low.w * turns / max(size * size, 1e-37));
            vec3 stays = exp(-tau_i);
            float direct = exp(-light.a);
            // What direct light loses and scattered light does not: exp(-tau_i) - exp(-tau).
            vec3 turned = vec3(absorbed(stays.r, exp(-tau), tau - tau_i.r), absorbed(stays.g, exp(-tau), tau - tau_i.g),
                               absorbed(stays.b, exp(-tau), tau - tau_i.b));
            // Both together are never more than the light brings.
            float most = absorbed(1.0, direct * exp(-tau), light.a + tau);
            light.rgb = min(stays * around + direct * max(turned, 0.0), vec3(most));
        }
    }
    light.a += tau;
    if (is_there) imageStore(next, texel, light);
}

void main() {
    load_block();
    for (uint row = 0; row < ROWS; ++row) propagate_texel(place_of(row));
}
