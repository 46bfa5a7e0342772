// What both stages know of the scene, and tubes: the light that reaches a point along wide steps.
#include "shared/view.glsl"
#include "shared/intersect.glsl"
#include "shared/inside.glsl"
#include "shared/lights.glsl"

// Light dimmed by this optical depth is as good as gone: a ten-millionth is left.
const float DARK = 16.0;

layout(std140, set = 0, binding = 1) uniform Ambient {
    vec4 table;              // texture value of the first entry, entries a unit of it, entries; w: factor of
                             // the albedo
    vec4 dims;               // voxels along x, y, z; w: largest step, world units
    vec4 cell_scale;         // cells a unit of texture coordinate; w: optical depth that ends a ray
    vec4 node_first;         // grid coordinates of the cache's first node; w: radius, world units
    vec4 node_spacing;       // voxels from node to node; w: g of the phase function
    vec4 node_last;          // nodes - 1; w: factor on the colour that gives the emission
    vec4 extinction_scale;   // texture coordinates of the ambient extinction a unit of the volume's; w: g of
                             // light that comes from about the light's direction
    vec4 occlusion_scale;    // the same of the occlusion; w: logarithm of a step's transmission in vacuum
    vec4 environment;        // radiance; w: one over the last place of the tables along optical depth
    vec4 specular;           // x: factor, y: exponent
    vec4 dimming_ratio;      // rgb: of a channel's dimming to their mean
    vec4 gradient[3];        // world direction of a difference along x, y, z
    vec4 world_from_grid[3]; // rows of the affine map to world units about the volume's centre
    Light lights[MAX_LIGHTS];
} ambient;

// Optical depth of a radius at the mean extinction about a point.
layout(set = 0, binding = 2 + AMBIENT_BINDING) uniform sampler3D ambient_extinction;
// rgb: -log of the transmission over an optical depth, as a share of that depth.
layout(set = 0, binding = 3 + AMBIENT_BINDING) uniform sampler1D tube;

// Entries of both tables along optical depth, as in lookup.rs.
const float DEPTHS = 192.0;

// The block's values in registers: lavapipe reads a uniform anew at each use, lane by lane.
vec3 extinction_scale;
float per_octave;
float vacuum;
float radius;

void load_tube() {
    extinction_scale = ambient.extinction_scale.xyz;
    per_octave = ambient.environment.w;
    vacuum = ambient.occlusion_scale.w;
    radius = ambient.node_first.w;
}

// Where an optical depth lies in a table: evenly by log2(1 + depth).
float place_of(float depth) {
    float at = min(log2(1.0 + depth) * per_octave, 1.0);
    return (at * (DEPTHS - 1.0) + 0.5) / DEPTHS;
}

// p: texture coordinates of the volume.
float ambient_depth(vec3 p) {
    return textureLod(ambient_extinction, p * extinction_scale, 0.0).r;
}

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
