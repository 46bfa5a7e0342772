// What both stages know of the scene, and shadow rays: the optical depth from a point to a light.
#include "shared/view.glsl"
#include "shared/intersect.glsl"
#include "shared/inside.glsl"
#include "shared/lights.glsl"
#include "shared/empty_space.glsl"
#include "shared/material.glsl"

// Samples in a row between two looks at the cells.
const int BLOCK = 4;
// A shadow ray ends at this optical depth: a ten-millionth of the light is left.
const float DARK = 16.0;

layout(std140, set = 0, binding = 1) uniform Scatter {
    vec4 table;              // texture value of the first entry, entries a unit of it, entries; w: factor of
                             // the albedo
    vec4 dims;               // voxels along x, y, z; w: largest step, world units
    vec4 cell_scale;         // cells a unit of texture coordinate; w: optical depth that ends a ray
    vec4 node_first;         // grid coordinates of the cache's first node; w: largest step of shadow rays
    vec4 node_spacing;       // voxels from node to node; w: g of the phase function
    vec4 node_last;          // nodes - 1; w: factor on the colour that gives the emission
    vec4 world_from_grid[3]; // rows of the affine map to world units about the volume's centre
    Light lights[MAX_LIGHTS];
} scatter;

// The block's values in registers: lavapipe reads a uniform anew at each use, lane by lane.
vec3 cells;     // a unit of texture coordinate

void load_block() {
    table = scatter.table;
    last_voxel = scatter.dims.xyz - 1.0;
    load_material();
    cells = scatter.cell_scale.xyz;
}

// A ray in voxels: where its first sample lies, and the step to the next.
struct GridRay {
    vec3 first;
    vec3 per_step;
};

GridRay grid_ray(vec3 p_first, vec3 dp) {
    vec3 dims = last_voxel + 1.0;
    return GridRay(p_first * dims - 0.5, dp * dims);
}

// From the world position x to the light, or to where the volume ends.
float shadow_depth(vec3 x, Light light) {
    vec3 w_i = light.place.xyz;
    float far = 3.0e38;
    if (POINT_LIGHTS && light.place.w > 0.0) {
        w_i -= x;
        far = length(w_i);
        w_i /= max(far, 1e-30);
    }
    vec2 t = inside_from(vec2(0.0, far), x, w_i);
    if (!(t.x < t.y)) return 0.0;
    int count = steps_along(t.y - t.x, scatter.node_first.w);
    float dt = (t.y - t.x) / float(count);
    vec3 p_first = texture_point(x + (t.x + 0.5 * dt) * w_i);
    vec3 dp = texture_direction(w_i) * dt;
    CellRay cell = cell_ray(p_first, dp, cells);
    GridRay grid = grid_ray(p_first, dp);
    float tau = 0.0;
    int i = 0;
    while (i < count && tau < DARK) {
        if (SKIP_EMPTY) {
            int skipped;
            do {
                skipped = empty_steps(cell, float(i), last_voxel);
                i += skipped;
            } while (skipped > 0 && i < count);
            if (i >= count) break;
        }
        float values[MAX_BLOCK];
        values_of(grid.first, grid.per_step, i, BLOCK, values);
        for (int k = 0; k < BLOCK; ++k) {
            vec3 q = grid.first + float(i + k) * grid.per_step;
            float dtau = i + k < count ? extinction_of(values[k], q) * dt : 0.0;
            if (MASKED) dtau *= finite_weight(q);
            tau += dtau;
        }
        i += BLOCK;
    }
    return tau;
}
