// One axis of the chessboard distance from every cell to the nearest occupied one, at most REACH:
// out(c) = min over c' on the axis of max(|c - c'|, in(c')); along the last axis less the cells by which noise moves
// what is looked up, which are as good as occupied.
// Domain: one invocation a cell, once an axis. Dispatched by technique/medium/record.rs.
#version 460
layout(local_size_x = 8, local_size_y = 4, local_size_z = 2) in;

layout(constant_id = 0) const uint REACH = 15;
layout(constant_id = 1) const uint WIDEN = 0;

layout(set = 0, binding = 0) uniform usampler3D distance_in;
layout(set = 0, binding = 1) writeonly uniform uimage3D distance_out;

layout(push_constant) uniform Push {
    uint axis; // 0, 1, 2
} push;

void main() {
    ivec3 cell = ivec3(gl_GlobalInvocationID);
    ivec3 size = imageSize(distance_out);
    if (any(greaterThanEqual(cell, size))) return;
    ivec3 along = ivec3(push.axis == 0, push.axis == 1, push.axis == 2);
    int here = cell[push.axis];
    uint nearest = texelFetch(distance_in, cell, 0).r;
    // A cell k away cannot improve a distance of k or less.
    for (int k = 1; k < int(nearest); ++k) {
        uint below = here - k >= 0 ? texelFetch(distance_in, cell - k * along, 0).r : REACH;
        uint above = here + k < size[push.axis] ? texelFetch(distance_in, cell + k * along, 0).r : REACH;
        nearest = min(nearest, max(uint(k), min(below, above)));
    }
    if (push.axis == 2) nearest -= min(nearest, WIDEN);
    imageStore(distance_out, cell, uvec4(nearest));
}
