// Light as a sample finds it: from where, how far within the slice, and what the light buffer holds of it.
#include "shared/phase.glsl"

const float INV_4_PI = 0.0795774715;

layout(set = 0, binding = 10, rgba32f) readonly uniform image1D phase_table;

// As in sweep.glsl.
Light lamp;
vec4 lamp_axis;
vec4 lamp_anchor;
vec4 lamp_u;
vec4 lamp_v;
vec4 lamp_low;
vec3 lamp_dp; // towards a directional light, in texture coordinates

void load_light() {
    lamp = sweep.light;
    lamp_axis = sweep.light_axis;
    lamp_anchor = sweep.light_anchor;
    lamp_u = sweep.light_u;
    lamp_v = sweep.light_v;
    lamp_low = sweep.light_low;
    lamp_dp = to_texture_direction(lamp.place.xyz);
}

// Per steradian, for each colour; cos_theta = 1 is straight on.
vec3 phase(float cos_theta) {
    if (PHASE_TABLE) {
        float at = clamp(0.5 + 0.5 * cos_theta, 0.0, 1.0) * sweep.phase.z;
        int lo = int(at);
        int hi = min(lo + 1, int(sweep.phase.z));
        return mix(imageLoad(phase_table, lo).rgb, imageLoad(phase_table, hi).rgb, at - float(lo));
    }
    return vec3(ISOTROPIC ? INV_4_PI : phase_hg(cos_theta, sweep.phase.x));
}

// Of light that was scattered on its way: it comes from about the light's direction.
float spread_phase(float cos_theta) {
    return ISOTROPIC ? INV_4_PI : phase_hg(cos_theta, sweep.phase.y);
}

vec3 towards_light(vec3 x) {
    if (POINT_LIGHTS && lamp.place.w > 0.0) {
        vec3 to = lamp.place.xyz - x;
        return to / max(length(to), 1e-30);
    }
    return lamp.place.xyz;
}

// How far from p a ray of direction d leaves the box from 0 to 1.
float leaving(vec3 p, vec3 d) {
    d = mix(d, vec3(1e-20), lessThan(abs(d), vec3(1e-20)));
    vec3 t = (step(vec3(0.0), d) - p) / d;
    return min(t.x, min(t.y, t.z));
}

// Length of the way of light to x, p in texture coordinates, within the slice and the medium.
float way_in_slice(vec3 x, vec3 p, vec3 w_i) {
    float way = (dot(axis.xyz, x) - faces.x) / max(-dot(axis.xyz, w_i), 1e-3);
    bool is_far = true;
    if (POINT_LIGHTS) is_far = lamp.place.w == 0.0;
    way = min(way, leaving(p, is_far ? lamp_dp : to_texture_direction(w_i)));
    if (CLIP_BOX) {
        vec3 size = view.clip_max.xyz - view.clip_min.xyz;
        way = min(way, leaving((x - view.clip_min.xyz) / size, w_i / size));
    }
    if (CLIP_PLANE) way = min(way, clip_to_half_space(vec2(0.0, way), x, w_i, view.clip_plane).y);
    if (POINT_LIGHTS && lamp.place.w > 0.0) way = min(way, distance(x, lamp.place.xyz));
    return max(way, 0.0);
}

// The light buffer between its texels' centres, and how much the depth to the light rises along half of `way` about
// x: of the same four texels.
struct Arriving {
    vec4 light;
    float rise;
};

Arriving arriving_at(vec3 x, vec3 way) {
    vec3 from = x - lamp_anchor.xyz;
    float depth = 1.0, deeper = 0.0;
    if (POINT_LIGHTS && lamp.place.w > 0.0) {
        depth = max(lamp_anchor.w + dot(from, lamp_axis.xyz), 1e-30);
        deeper = dot(way, lamp_axis.xyz);
    }
    vec3 u = lamp_u.xyz, v = lamp_v.xyz;
    vec2 place = vec2(dot(from, u), dot(from, v)) / depth;
    vec2 half_way = 0.5 * (vec2(dot(way, u), dot(way, v)) - place * deeper) / (depth * lamp_low.z);
    vec2 last = vec2(lamp_u.w, lamp_v.w) - 1.0;
    vec2 at = clamp((place - lamp_low.xy) / lamp_low.z - 0.5, vec2(0.0), last);
    ivec2 lo = ivec2(at), hi = min(lo + 1, ivec2(last));
    vec2 f = at - vec2(lo);
    vec4 a = imageLoad(current, lo), b = imageLoad(current, ivec2(hi.x, lo.y));
    vec4 c = imageLoad(current, ivec2(lo.x, hi.y)), d = imageLoad(current, hi);
    vec4 light = mix(mix(a, b, f.x), mix(c, d, f.x), f.y);
    vec2 slope = vec2(mix(b.a - a.a, d.a - c.a, f.y), mix(c.a - a.a, d.a - b.a, f.x));
    // No depth is below 0, nor, on the other side, twice as large.
    return Arriving(light, clamp(dot(slope, half_way), -light.a, light.a));
}

// The stretch of a ray that the buffer's part of a point light shines on: a pyramid of a cube's face.
vec2 in_frustum(vec2 t, vec3 o, vec3 d) {
    vec3 from = o - lamp.place.xyz;
    t = clip_to_half_space(t, from, d, vec4(lamp_axis.xyz + lamp_u.xyz, 0.0));
    t = clip_to_half_space(t, from, d, vec4(lamp_axis.xyz - lamp_u.xyz, 0.0));
    t = clip_to_half_space(t, from, d, vec4(lamp_axis.xyz + lamp_v.xyz, 0.0));
    return clip_to_half_space(t, from, d, vec4(lamp_axis.xyz - lamp_v.xyz, 0.0));
}
