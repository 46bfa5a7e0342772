// The medium by loads and our own filters: on a software driver eight loads cost less than one filtered
// fetch, and the 32 of a gradient far less than six. TEXEL_FORMAT is the volume's format.
// q: grid coordinates, voxel centres at whole numbers; last: the largest, voxels - 1. Outside the
// outermost centres the outermost value continues.
// Most samples taken in a row.
const int MAX_BLOCK = 8;

layout(set = 0, binding = 2, TEXEL_FORMAT) readonly uniform image3D volume;
layout(set = 0, binding = 3, rgba32f) readonly uniform image1D transfer_function;
#ifndef NO_CELLS
layout(set = 0, binding = 4, r8ui) readonly uniform uimage3D cell_distance;
#endif

// The voxels around a point: the lower corner of its cell, the upper one, and the place between.
struct Corner {
    ivec3 lo;
    ivec3 hi;
    vec3 f;
};

Corner corner_of(vec3 q, vec3 last) {
    vec3 at = clamp(q, vec3(0.0), last);
    Corner c;
    c.lo = ivec3(at);
    c.hi = min(c.lo + 1, ivec3(last));
    c.f = at - vec3(c.lo);
    return c;
}

float texel(int x, int y, int z) {
    return imageLoad(volume, ivec3(x, y, z)).r;
}

float value_at(vec3 q, vec3 last) {
    Corner c = corner_of(q, last);
    float x00 = mix(texel(c.lo.x, c.lo.y, c.lo.z), texel(c.hi.x, c.lo.y, c.lo.z), c.f.x);
    float x10 = mix(texel(c.lo.x, c.hi.y, c.lo.z), texel(c.hi.x, c.hi.y, c.lo.z), c.f.x);
    float x01 = mix(texel(c.lo.x, c.lo.y, c.hi.z), texel(c.hi.x, c.lo.y, c.hi.z), c.f.x);
    float x11 = mix(texel(c.lo.x, c.hi.y, c.hi.z), texel(c.hi.x, c.hi.y, c.hi.z), c.f.x);
    return mix(mix(x00, x10, c.f.y), mix(x01, x11, c.f.y), c.f.z);
}

// Values of `count` samples from q_0 + i dq on, dq apart; the same to the bit wherever they begin.
void block_values(vec3 q_0, vec3 dq, int i, int count, vec3 last, out float values[MAX_BLOCK]) {
    Corner corners[MAX_BLOCK];
    float near[MAX_BLOCK], far[MAX_BLOCK];
    // One texel of every slice first: the processor waits for all of them at once, and finds their
    // neighbours in its cache.
    for (int k = 0; k < count; ++k) {
        Corner c = corner_of(q_0 + float(i + k) * dq, last);
        near[k] = texel(c.lo.x, c.lo.y, c.lo.z);
        far[k] = texel(c.lo.x, c.lo.y, c.hi.z);
        corners[k] = c;
    }
    for (int k = 0; k < count; ++k) {
        ivec3 lo = corners[k].lo, hi = corners[k].hi;
        vec3 f = corners[k].f;
        float x00 = mix(near[k], texel(hi.x, lo.y, lo.z), f.x);
        float x10 = mix(texel(lo.x, hi.y, lo.z), texel(hi.x, hi.y, lo.z), f.x);
        float x01 = mix(far[k], texel(hi.x, lo.y, hi.z), f.x);
        float x11 = mix(texel(lo.x, hi.y, hi.z), texel(hi.x, hi.y, hi.z), f.x);
        values[k] = mix(mix(x00, x10, f.y), mix(x01, x11, f.y), f.z);
    }
}

// Value one voxel ahead minus value one voxel behind, along one axis: of four texels in a row, `lo` and
// `hi` around the point. Exactly 0 where they are equal; clamped rows repeat their last texel.
float row_difference(float behind, float lo, float hi, float ahead, float f) {
    return mix(hi - behind, ahead - lo, f);
}

// Bilinear: `v` at (0, 0), (1, 0), (0, 1), (1, 1).
float between(vec4 v, vec2 f) {
    return mix(mix(v.x, v.y, f.x), mix(v.z, v.w, f.x), f.y);
}

// Differences between one voxel ahead and one behind q along x, y, z, both clamped at the faces.
vec3 value_differences(vec3 q, vec3 last) {
    Corner c = corner_of(q, last);
    ivec3 a = c.lo, b = c.hi;
    ivec3 behind = max(a - 1, ivec3(0));
    ivec3 ahead = min(b + 1, ivec3(last));
    // Named by where they lie along x, y, z: m behind, 0 lo, 1 hi, p ahead. One of every row first, as
    // above.
    float v00m = texel(a.x, a.y, behind.z), v000 = texel(a.x, a.y, a.z);
    float v001 = texel(a.x, a.y, b.z), v00p = texel(a.x, a.y, ahead.z);
    float v0m0 = texel(a.x, behind.y, a.z), v0p0 = texel(a.x, ahead.y, a.z);
    float v0m1 = texel(a.x, behind.y, b.z), v0p1 = texel(a.x, ahead.y, b.z);
    float v01m = texel(a.x, b.y, behind.z), v010 = texel(a.x, b.y, a.z);
    float v011 = texel(a.x, b.y, b.z), v01p = texel(a.x, b.y, ahead.z);
    float v10m = texel(b.x, a.y, behind.z), v100 = texel(b.x, a.y, a.z);
    float v101 = texel(b.x, a.y, b.z), v10p = texel(b.x, a.y, ahead.z);
    float v1m0 = texel(b.x, behind.y, a.z), v1p0 = texel(b.x, ahead.y, a.z);
    float v1m1 = texel(b.x, behind.y, b.z), v1p1 = texel(b.x, ahead.y, b.z);
    float v11m = texel(b.x, b.y, behind.z), v110 = texel(b.x, b.y, a.z);
    float v111 = texel(b.x, b.y, b.z), v11p = texel(b.x, b.y, ahead.z);
    vec4 x = vec4(row_difference(texel(behind.x, a.y, a.z), v000, v100, texel(ahead.x, a.y, a.z), c.f.x),
                  row_difference(texel(behind.x, b.y, a.z), v010, v110, texel(ahead.x, b.y, a.z), c.f.x),
                  row_difference(texel(behind.x, a.y, b.z), v001, v101, texel(ahead.x, a.y, b.z), c.f.x),
                  row_difference(texel(behind.x, b.y, b.z), v011, v111, texel(ahead.x, b.y, b.z), c.f.x));
    vec4 y = vec4(row_difference(v0m0, v000, v010, v0p0, c.f.y), row_difference(v1m0, v100, v110, v1p0, c.f.y),
                  row_difference(v0m1, v001, v011, v0p1, c.f.y), row_difference(v1m1, v101, v111, v1p1, c.f.y));
    vec4 z = vec4(row_difference(v00m, v000, v001, v00p, c.f.z), row_difference(v10m, v100, v101, v10p, c.f.z),
                  row_difference(v01m, v010, v011, v01p, c.f.z), row_difference(v11m, v110, v111, v11p, c.f.z));
    return vec3(between(x, c.f.yz), between(y, c.f.xz), between(z, c.f.xy));
}

// Colour (rgb) and extinction (a) between the table's entries; entry in [0, entries - 1].
vec4 table_at(float entry, float entries) {
    int lo = int(entry);
    int hi = min(lo + 1, int(entries) - 1);
    return mix(imageLoad(transfer_function, lo), imageLoad(transfer_function, hi), entry - float(lo));
}

// Extinction alone.
float extinction_at(float entry, float entries) {
    int lo = int(entry);
    int hi = min(lo + 1, int(entries) - 1);
    return mix(imageLoad(transfer_function, lo).a, imageLoad(transfer_function, hi).a, entry - float(lo));
}

#ifndef NO_CELLS
// Cells to the nearest occupied one, 0 in it.
uint distance_at(ivec3 cell) {
    return imageLoad(cell_distance, cell).r;
}

ivec3 cells_along() {
    return imageSize(cell_distance);
}
#endif
