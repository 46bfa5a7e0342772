// Smallest and largest texel that trilinear sampling inside a cell can read.
// Domain: one invocation a cell.
// Dispatched by technique/medium/record.rs.
#version 460
layout(local_size_x = 8, local_size_y = 4, local_size_z = 2) in;

layout(constant_id = 0) const uint CELL_SIZE = 4;

layout(set = 0, binding = 0) uniform sampler3D volume;
layout(set = 0, binding = 1) writeonly uniform image3D cell_min_max;

void main() {
    ivec3 cell = ivec3(gl_GlobalInvocationID);
    if (any(greaterThanEqual(cell, imageSize(cell_min_max)))) return;
    ivec3 last = textureSize(volume, 0) - 1;
    // A sample at the cell's face blends with the next texel outside, on either side.
    ivec3 lo = max(cell * int(CELL_SIZE) - 1, ivec3(0));
    ivec3 hi = min((cell + 1) * int(CELL_SIZE), last);
    float first = texelFetch(volume, lo, 0).r;
    vec2 range = vec2(first);
    for (int z = lo.z; z <= hi.z; ++z)
        for (int y = lo.y; y <= hi.y; ++y)
            for (int x = lo.x; x <= hi.x; ++x) {
                float value = texelFetch(volume, ivec3(x, y, z), 0).r;
                range = vec2(min(range.x, value), max(range.y, value));
            }
    imageStore(cell_min_max, cell, vec4(range, 0.0, 0.0));
}
