// The extinction of every cell, whatever the medium is read through: shared/medium_filtered.glsl or
// shared/medium_loaded.glsl.
layout(local_size_x = 8, local_size_y = 8) in;

layout(constant_id = 0) const bool SKIP_EMPTY = false;
layout(constant_id = 1) const bool MASKED = false;
layout(constant_id = 2) const bool CLIP_BOX = false;
layout(constant_id = 3) const bool CLIP_PLANE = false;
layout(constant_id = 4) const int MEDIUM_CELL = 4; // voxels along the edge of a cell of the medium
layout(constant_id = 5) const bool SPLIT = false;  // cells are parts of voxels
layout(constant_id = 6) const bool SQUARES = false; // their squares are summed too

#include "shared/view.glsl"
#define MATERIAL 8
#include "shared/material.glsl"

layout(std140, set = 0, binding = 1) uniform Area {
    vec4 table;              // texture value of the first entry, entries a unit of it, entries; w: levels
                             // a unit of extinction and voxel
    uvec4 dims;              // voxels along x, y, z; w: most levels of a cell
    uvec4 cell;              // voxels of a cell along x, y, z; w unused
    uvec4 split;             // cells of a voxel along x, y, z; w unused
    vec4 world_from_grid[3]; // rows of the affine map to world units about the volume's centre
} area;

layout(set = 0, binding = 6, r32ui) writeonly uniform uimage3D sums;
layout(set = 0, binding = 7, r32ui) writeonly uniform uimage3D squares;

layout(push_constant) uniform Push {
    uint first_slice;
    uint slice_count;
} push;

// World units about the volume's centre of a place in grid coordinates.
vec3 world_of(vec3 place) {
    vec4 q = vec4(place, 1.0);
    return vec3(dot(area.world_from_grid[0], q), dot(area.world_from_grid[1], q), dot(area.world_from_grid[2], q));
}

// Whether a place counts, given by grid coordinates: it is finite and not clipped away.
bool is_kept(vec3 place) {
    if (MASKED && finite_weight(place) == 0.0) return false;
    if (CLIP_BOX) {
        vec3 x = world_of(place);
        if (any(lessThan(x, view.clip_min.xyz)) || any(greaterThan(x, view.clip_max.xyz))) return false;
    }
    if (CLIP_PLANE && dot(view.clip_plane.xyz, world_of(place)) + view.clip_plane.w < 0.0) return false;
    return true;
}

// Sum over the voxels of a cell.
float sum_of(ivec3 cell) {
    ivec3 first = cell * ivec3(area.cell.xyz);
    ivec3 end = min(first + ivec3(area.cell.xyz), ivec3(area.dims.xyz));
    if (SKIP_EMPTY) {
        // Cells nearer than the distance are empty. No loop then, rather than a branch: software drivers go
        // through branches that no lane takes.
        ivec3 across = (end - 1) / MEDIUM_CELL - first / MEDIUM_CELL;
        int reach = int(distance_at(first / MEDIUM_CELL));
        if (reach > max(across.x, max(across.y, across.z))) end.z = first.z;
    }
    float sum = 0.0;
    for (int z = first.z; z < end.z; ++z)
        for (int y = first.y; y < end.y; ++y)
            for (int x = first.x; x < end.x; ++x)
                sum += is_kept(vec3(x, y, z)) ? extinction_of(value_of_voxel(ivec3(x, y, z)), vec3(x, y, z)) : 0.0;
    return sum;
}

void main() {
    ivec3 cell = ivec3(gl_GlobalInvocationID.xy, gl_GlobalInvocationID.z + push.first_slice);
    if (gl_GlobalInvocationID.z >= push.slice_count || any(greaterThanEqual(cell, imageSize(sums)))) return;
    table = area.table;
    last_voxel = vec3(area.dims.xyz) - 1.0;
    load_material();
    vec3 middle = (vec3(cell) + 0.5) / vec3(area.split.xyz) - 0.5;
    float sum;
    if (SPLIT) sum = is_kept(middle) ? extinction_of(value_of(middle), middle) : 0.0;
    else sum = sum_of(cell);
    float level = sum * table.w;
    imageStore(sums, cell, uvec4(uint(level + 0.5)));
    // In levels of which the densest cell has as many.
    if (SQUARES) imageStore(squares, cell, uvec4(uint(level * level / float(area.dims.w) + 0.5)));
}
