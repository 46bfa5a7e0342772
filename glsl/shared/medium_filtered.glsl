// The medium through the device's filters. q: grid coordinates, voxel centres at whole
// numbers; last: the largest, voxels - 1. Outside the outermost centres the outermost value continues.
// Most samples taken in a row.
const int MAX_BLOCK = 8;

layout(set = 0, binding = 2) uniform sampler3D volume;
layout(set = 0, binding = 3) uniform sampler1D transfer_function;
#ifndef NO_CELLS
layout(set = 0, binding = 4) uniform usampler3D cell_distance;
#endif

float texel(int x, int y, int z) {
    return texelFetch(volume, ivec3(x, y, z), 0).r;
}

float value_at(vec3 q, vec3 last) {
    return textureLod(volume, (q + 0.5) / (last + 1.0), 0.0).r;
}

// Values of `count` samples from q_0 + i dq on, dq apart; the same to the bit wherever they begin.
void block_values(vec3 q_0, vec3 dq, int i, int count, vec3 last, out float values[MAX_BLOCK]) {
    for (int k = 0; k < count; ++k) values[k] = value_at(q_0 + float(i + k) * dq, last);
}

// Differences between one voxel ahead and one behind q along x, y, z, both clamped at the faces.
vec3 value_differences(vec3 q, vec3 last) {
    q = clamp(q, vec3(0.0), last);
    vec3 behind = max(q - 1.0, vec3(0.0));
    vec3 ahead = min(q + 1.0, last);
    return vec3(value_at(vec3(ahead.x, q.yz), last) - value_at(vec3(behind.x, q.yz), last),
                value_at(vec3(q.x, ahead.y, q.z), last) - value_at(vec3(q.x, behind.y, q.z), last),
                value_at(vec3(q.xy, ahead.z), last) - value_at(vec3(q.xy, behind.z), last));
}

// Colour (rgb) and extinction (a) between the table's entries; entry in [0, entries - 1].
vec4 table_at(float entry, float entries) {
    return textureLod(transfer_function, (entry + 0.5) / entries, 0.0);
}

// Extinction alone.
float extinction_at(float entry, float entries) {
    return table_at(entry, entries).a;
}

#ifndef NO_CELLS
// Cells to the nearest occupied one, 0 in it.
uint distance_at(ivec3 cell) {
    return texelFetch(cell_distance, cell, 0).r;
}

ivec3 cells_along() {
    return textureSize(cell_distance, 0);
}
#endif
