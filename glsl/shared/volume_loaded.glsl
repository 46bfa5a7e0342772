// The volume by loads and our own filter: on a software driver eight loads cost less than one filtered
// fetch, and the 32 of a gradient far less than six. TEXEL_FORMAT is the volume's format.
layout(set = 0, binding = 2, TEXEL_FORMAT) readonly uniform image3D volume;

// The voxels around a point: the lower corner of its cell, the upper one, and the place between.
struct Corner {
    ivec3 lo;
    ivec3 hi;
    vec3 f;
};

Corner corner_of(vec3 p, vec3 dims) {
    vec3 at = clamp(p * dims - 0.5, vec3(0.0), dims - 1.0);
    Corner c;
    c.lo = ivec3(at);
    c.hi = min(c.lo + 1, ivec3(dims) - 1);
    c.f = at - vec3(c.lo);
    return c;
}

float texel(int x, int y, int z) {
    return imageLoad(volume, ivec3(x, y, z)).r;
}

// Trilinear value at texture coordinate p, clamped in the outer half voxel.
float volume_at(vec3 p, vec3 dims) {
    Corner c = corner_of(p, dims);
    float x00 = mix(texel(c.lo.x, c.lo.y, c.lo.z), texel(c.hi.x, c.lo.y, c.lo.z), c.f.x);
    float x10 = mix(texel(c.lo.x, c.hi.y, c.lo.z), texel(c.hi.x, c.hi.y, c.lo.z), c.f.x);
    float x01 = mix(texel(c.lo.x, c.lo.y, c.hi.z), texel(c.hi.x, c.lo.y, c.hi.z), c.f.x);
    float x11 = mix(texel(c.lo.x, c.hi.y, c.hi.z), texel(c.hi.x, c.hi.y, c.hi.z), c.f.x);
    return mix(mix(x00, x10, c.f.y), mix(x01, x11, c.f.y), c.f.z);
}

// Value one voxel ahead minus value one voxel behind, along one axis: of four texels in a row, `lo` and
// `hi` around the point. Exactly 0 where they are equal; clamped rows repeat their last texel.
float row_difference(float behind, float lo, float hi, float ahead, float f) {
    return mix(hi - behind, ahead - lo, f);
}

// Differences between one voxel ahead and one behind p along x, y, z, both clamped at the faces.
vec3 volume_differences(vec3 p, vec3 dims) {
    Corner c = corner_of(p, dims);
    ivec3 a = c.lo, b = c.hi;
    ivec3 behind = max(a - 1, ivec3(0));
    ivec3 ahead = min(b + 1, ivec3(dims) - 1);
    // The eight corners serve all three axes; digits are x, y, z, 0 for lo and 1 for hi.
    float c000 = texel(a.x, a.y, a.z), c100 = texel(b.x, a.y, a.z);
    float c010 = texel(a.x, b.y, a.z), c110 = texel(b.x, b.y, a.z);
    float c001 = texel(a.x, a.y, b.z), c101 = texel(b.x, a.y, b.z);
    float c011 = texel(a.x, b.y, b.z), c111 = texel(b.x, b.y, b.z);
#define ROW_X(y, z, lo, hi) row_difference(texel(behind.x, y, z), lo, hi, texel(ahead.x, y, z), c.f.x)
#define ROW_Y(x, z, lo, hi) row_difference(texel(x, behind.y, z), lo, hi, texel(x, ahead.y, z), c.f.y)
#define ROW_Z(x, y, lo, hi) row_difference(texel(x, y, behind.z), lo, hi, texel(x, y, ahead.z), c.f.z)
    float dx = mix(mix(ROW_X(a.y, a.z, c000, c100), ROW_X(b.y, a.z, c010, c110), c.f.y),
                   mix(ROW_X(a.y, b.z, c001, c101), ROW_X(b.y, b.z, c011, c111), c.f.y), c.f.z);
    float dy = mix(mix(ROW_Y(a.x, a.z, c000, c010), ROW_Y(b.x, a.z, c100, c110), c.f.x),
                   mix(ROW_Y(a.x, b.z, c001, c011), ROW_Y(b.x, b.z, c101, c111), c.f.x), c.f.z);
    float dz = mix(mix(ROW_Z(a.x, a.y, c000, c001), ROW_Z(b.x, a.y, c100, c101), c.f.x),
                   mix(ROW_Z(a.x, b.y, c010, c011), ROW_Z(b.x, b.y, c110, c111), c.f.x), c.f.y);
    return vec3(dx, dy, dz);
}
