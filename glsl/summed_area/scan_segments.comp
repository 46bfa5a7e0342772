// Running sums along y or z, in place, lines cut into segments that are summed side by side; after those along x the
// table is summed over areas [Crow1984]. Sums wrap around at 2^32, which differences do not notice.
// Domain: lines along x, one row of segments, lines along the third axis. Dispatched by
// technique/summed_area/scan.rs.
#version 460
layout(local_size_x = 16, local_size_y = 8) in;

layout(set = 0, binding = 0, r32ui) uniform uimage3D sums;

layout(push_constant) uniform Push {
    uint axis; // 1, 2
} push;

const uint LINES = gl_WorkGroupSize.x;    // neighbours along x, so that a row of lanes reads a row of texels
const uint SEGMENTS = gl_WorkGroupSize.y; // of a line
const uint CELLS = 8;                     // of a segment, loaded before any is stored

shared uint totals[SEGMENTS][LINES];

void main() {
    uvec3 size = uvec3(imageSize(sums));
    uint x = gl_GlobalInvocationID.x, third = gl_WorkGroupID.z;
    uint line = gl_LocalInvocationID.x, segment = gl_LocalInvocationID.y;
    uint count = push.axis == 1 ? size.y : size.z;
    ivec3 along = push.axis == 1 ? ivec3(0, 1, 0) : ivec3(0, 0, 1);
    ivec3 line_start = push.axis == 1 ? ivec3(x, 0, third) : ivec3(x, third, 0);
    // Lanes beyond the last line stay for the barriers, without cells.
    uint end = x < size.x ? count : 0;
    uint before = 0; // sum of all cells below this round's
    for (uint first = 0; first < count; first += SEGMENTS * CELLS) {
        uint start = first + segment * CELLS;
        uint sum[CELLS]; // running, from the segment's start
        for (uint i = 0; i < CELLS; ++i)
            sum[i] = start + i < end ? imageLoad(sums, line_start + int(start + i) * along).r : 0;
        for (uint i = 1; i < CELLS; ++i) sum[i] += sum[i - 1];
        totals[segment][line] = sum[CELLS - 1];
        barrier(); // RAW: every segment adds what those before it hold
        uint below = before;
        for (uint i = 0; i < SEGMENTS; ++i) {
            uint total = totals[i][line];
            below += i < segment ? total : 0;
            before += total;
        }
        barrier(); // WAR: the next round's totals take their place
        for (uint i = 0; i < CELLS; ++i)
            if (start + i < end) imageStore(sums, line_start + int(start + i) * along, uvec4(below + sum[i]));
    }
}
