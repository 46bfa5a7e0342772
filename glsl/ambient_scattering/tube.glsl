// Tubes: the light that reaches a point along wide steps.
#include "ambient_scattering/ambient.glsl"
#include "shared/intersect.glsl"
#include "shared/inside.glsl"

// Light dimmed by this optical depth is as good as gone: a ten-millionth is left.
const float DARK = 16.0;

// rgb: -log of the transmission over an optical depth, as a share of that depth.
layout(set = 0, binding = 3 + AMBIENT_BINDING) uniform sampler1D tube;

// The share of an optical depth that dims light in a tube: light scattered on may arrive all the same.
vec3 dimming(float place) {
    return textureLod(tube, place, 0.0).rgb;
}

// The light that arrives at x: rgb, of all of it as it enters the sphere about x, a radius nearer to the light
// [Ament2013, Eq. 16]; a, of the light that comes straight to x.
vec4 arriving(vec3 x, Light light) {
    vec3 w_i = light.place.xyz;
    float far = 3.0e38;
    if (POINT_LIGHTS && light.place.w > 0.0) {
        w_i -= x;
        far = length(w_i);
        w_i /= max(far, 1e-30);
    }
    vec2 t = inside_from(vec2(0.0, far), x, w_i);
    if (!(t.x < t.y)) return vec4(1.0);
    vec3 p = texture_point(x), dp = texture_direction(w_i);
    // The sphere's own half comes first; only direct light has to pass it.
    float begin = min(t.x + radius, t.y);
    float direct = (begin - t.x) / radius * ambient_depth(p + 0.5 * (t.x + begin) * dp);
    vec3 dimmed = vec3(0.0);
    int steps = begin < t.y ? steps_along(t.y - begin, 2.0 * radius) : 0;
    for (int i = 0; i < steps && (direct < DARK || min(dimmed.r, min(dimmed.g, dimmed.b)) < DARK); ++i) {
        float near = begin + float(i) * 2.0 * radius;
        float end = min(near + 2.0 * radius, t.y);
        float depth = ambient_depth(p + 0.5 * (near + end) * dp);
        float share = (end - near) / radius; // of radii; 2 but for the last step
        if (LINEAR_TUBE) {
            // Between whole steps linear [Ament2013, Eq. 17].
            vec3 whole = exp(vacuum - 2.0 * depth * dimming(place_of(2.0 * depth)));
            dimmed -= log(max(mix(vec3(1.0), whole, 0.5 * share), 1e-30));
        } else {
            dimmed += share * depth * dimming(place_of(share * depth));
        }
        direct += share * depth;
    }
    return vec4(exp(-dimmed), exp(-direct));
}
