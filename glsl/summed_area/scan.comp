// Running sums along one axis, in place; after all three the table is summed over areas [Crow1984]. Sums wrap
// around at 2^32, which differences do not notice.
// Domain: one invocation a line along the axis. Dispatched by technique/summed_area/record.rs.
#version 460
layout(local_size_x = 64) in;

layout(set = 0, binding = 0, r32ui) uniform uimage3D sums;

layout(push_constant) uniform Push {
    uint axis; // 0, 1, 2
} push;

void main() {
    ivec3 size = imageSize(sums);
    // Neighbouring lanes take neighbouring lines: along x where the axis is another.
    ivec2 line = ivec2(gl_GlobalInvocationID.xy);
    ivec2 lines = push.axis == 0 ? size.yz : push.axis == 1 ? size.xz : size.xy;
    if (any(greaterThanEqual(line, lines))) return;
    ivec3 at = push.axis == 0 ? ivec3(0, line) : push.axis == 1 ? ivec3(line.x, 0, line.y) : ivec3(line, 0);
    ivec3 along = ivec3(push.axis == 0, push.axis == 1, push.axis == 2);
    int count = size[push.axis];
    uint sum = 0;
    for (int i = 0; i < count; ++i) {
        sum += imageLoad(sums, at).r;
        imageStore(sums, at, uvec4(sum));
        at += along;
    }
}
