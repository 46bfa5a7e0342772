// What all stages know of the scene, and the mean extinction about every point.
#include "shared/view.glsl"
#include "shared/lights.glsl"

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

// Entries of both tables along optical depth, as in lookup.rs.
const float DEPTHS = 192.0;

// The block's values in registers: lavapipe reads a uniform anew at each use, lane by lane.
vec3 extinction_scale;
float per_octave;
float vacuum;
float radius;

void load_ambient() {
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
