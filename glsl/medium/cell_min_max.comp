// Smallest and largest texel that trilinear sampling inside a cell can read; the largest first where a height field's
// medium is not met.
// Domain: one invocation a cell.
// Dispatched by technique/medium/record.rs.
#version 460
layout(local_size_x = 8, local_size_y = 4, local_size_z = 2) in;

layout(constant_id = 0) const uint CELL_SIZE = 4;
layout(constant_id = 1) const bool HEIGHT_FIELD = false;

layout(set = 0, binding = 0) uniform sampler3D volume;
layout(set = 0, binding = 1) writeonly uniform image3D cell_min_max;
layout(set = 0, binding = 2) uniform sampler2D surface_heights;

layout(push_constant) uniform Push {
    vec2 faces; // of a height field's medium, lower and upper, voxels above its surface
} push;

// Whether the medium about the columns between lo and hi reaches heights between theirs.
bool is_met(ivec3 lo, ivec3 hi) {
    vec2 range = vec2(texelFetch(surface_heights, lo.xy, 0).r);
    for (int y = lo.y; y <= hi.y; ++y)
        for (int x = lo.x; x <= hi.x; ++x) {
            float height = texelFetch(surface_heights, ivec2(x, y), 0).r;
            range = vec2(min(range.x, height), max(range.y, height));
        }
    range += push.faces;
    // Samples lie up to half a voxel beyond the outermost centres.
    return float(hi.z) + 0.5 >= range.x && float(lo.z) - 0.5 <= range.y;
}

void main() {
    ivec3 cell = ivec3(gl_GlobalInvocationID);
    if (any(greaterThanEqual(cell, imageSize(cell_min_max)))) return;
    ivec3 last = textureSize(volume, 0) - 1;
    // A sample at the cell's face blends with the next texel outside, on either side.
    ivec3 lo = max(cell * int(CELL_SIZE) - 1, ivec3(0));
    ivec3 hi = (cell + 1) * int(CELL_SIZE);
    hi.xy = min(hi.xy, last.xy);
    bool met = true;
    if (HEIGHT_FIELD) met = is_met(lo, hi);
    lo.z = min(lo.z, last.z);
    hi.z = min(hi.z, last.z);
    float first = texelFetch(volume, lo, 0).r;
    vec2 range = vec2(first);
    for (int z = lo.z; z <= hi.z; ++z)
        for (int y = lo.y; y <= hi.y; ++y)
            for (int x = lo.x; x <= hi.x; ++x) {
                float value = texelFetch(volume, ivec3(x, y, z), 0).r;
                range = vec2(min(range.x, value), max(range.y, value));
            }
    imageStore(cell_min_max, cell, vec4(met ? range : vec2(1.0, 0.0), 0.0, 0.0));
}
