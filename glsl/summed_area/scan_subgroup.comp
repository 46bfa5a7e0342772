// Running sums along x, in place, by scans over subgroups; after those along y and z the table is summed over areas
// [Crow1984]. Sums wrap around at 2^32, which differences do not notice.
// Domain: 32 invocations a line along x, lines along y, then z. Dispatched by technique/summed_area/scan.rs.
#version 460
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_arithmetic : require
layout(local_size_x = 128) in;

layout(set = 0, binding = 0, r32ui) uniform uimage3D sums;

// Lines a workgroup, shared out among its subgroups, however many those are.
const uint LINES = gl_WorkGroupSize.x / 32;

// Loads of a lane that are on their way at once: stores into the same image hold up those after them.
const uint LOADS = 4;

// Neighbouring lanes take neighbouring cells. Which line it is and where its parts begin is the same for all lanes
// of a subgroup, so that they scan together.
void scan_line(uint y, uint z, uint lane, uint lanes) {
    uint count = imageSize(sums).x;
    uint before = 0; // sum of all cells below those that are scanned next
    for (uint first = 0; first < count; first += LOADS * lanes) {
        uint level[LOADS];
        for (uint i = 0; i < LOADS; ++i) {
            uint x = first + i * lanes + lane;
            level[i] = x < count ? imageLoad(sums, ivec3(x, y, z)).r : 0;
        }
        for (uint i = 0; i < LOADS; ++i) {
            uint x = first + i * lanes + lane;
            uint sum = before + subgroupInclusiveAdd(level[i]);
            before += subgroupAdd(level[i]);
            if (x < count) imageStore(sums, ivec3(x, y, z), uvec4(sum));
        }
    }
}

void main() {
    // Counted, not taken from gl_SubgroupSize: drivers may leave some of a subgroup's lanes without invocation.
    uint lane = subgroupExclusiveAdd(1u);
    uint lanes = subgroupAdd(1u);
    uint lines = imageSize(sums).y;
    for (uint i = gl_SubgroupID; i < LINES; i += gl_NumSubgroups) {
        uint y = gl_WorkGroupID.x * LINES + i;
        if (y < lines) scan_line(y, gl_WorkGroupID.y, lane, lanes);
    }
}
