// 0 for a cell in which the transfer function gives extinction somewhere, else REACH (far from any).
// Domain: one invocation a cell.
// Dispatched by technique/medium/record.rs.
#version 460
layout(local_size_x = 8, local_size_y = 4, local_size_z = 2) in;

layout(constant_id = 0) const uint REACH = 15;

layout(set = 0, binding = 0) uniform sampler3D cell_min_max;
// occupied_before[i] counts the table's entries below i with extinction > 0.
layout(set = 0, binding = 1) uniform usampler1D occupied_before;
layout(set = 0, binding = 2) writeonly uniform uimage3D cell_distance;

layout(push_constant) uniform Push {
    float table_min;   // texture value at the table's first entry
    float table_scale; // entries a unit of texture value; negative if data values fall
} push;

void main() {
    ivec3 cell = ivec3(gl_GlobalInvocationID);
    if (any(greaterThanEqual(cell, imageSize(cell_distance)))) return;
    vec2 range = texelFetch(cell_min_max, cell, 0).rg;
    vec2 at = (range - push.table_min) * push.table_scale;
    int entries = textureSize(occupied_before, 0) - 1;
    // Rounded outwards by a little more than the sampler's rounding of coordinates.
    int first = clamp(int(floor(min(at.x, at.y) - 0.01)), 0, entries - 1);
    int last = clamp(int(ceil(max(at.x, at.y) + 0.01)), 0, entries - 1);
    uint before = texelFetch(occupied_before, first, 0).r;
    uint through = texelFetch(occupied_before, last + 1, 0).r;
    bool occupied = range.x <= range.y && through > before;
    imageStore(cell_distance, cell, uvec4(occupied ? 0u : REACH));
}
