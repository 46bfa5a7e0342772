// Sums over boxes with fractional ends, from summed-area tables: the includer defines sum_at, which reads them,
// and the types of one sum or of a pair: WHOLE (uint, uvec2), SIGNED (int, ivec2) and REAL (float, vec2).
// Each part's own sum is below 2^31, so that differences which wrap around are exact.

// Sum of the cells below a corner between cells; 0 to the number of cells along each axis.
WHOLE corner_sum(ivec3 corner, ivec3 cells) {
    ivec3 at = clamp(corner, ivec3(0), cells) - 1;
    WHOLE sum = sum_at(max(at, ivec3(0)));
    return any(lessThan(at, ivec3(0))) ? WHOLE(0u) : sum;
}

// Whether no cell that the box touches holds anything.
bool is_empty(vec3 lo, vec3 hi, ivec3 cells) {
    ivec3 a = ivec3(floor(lo)), b = ivec3(floor(hi)) + 1;
    WHOLE near = corner_sum(b, cells) - corner_sum(ivec3(a.x, b.yz), cells)
               - corner_sum(ivec3(b.x, a.y, b.z), cells) + corner_sum(ivec3(a.xy, b.z), cells);
    WHOLE far = corner_sum(ivec3(b.xy, a.z), cells) - corner_sum(ivec3(a.x, b.y, a.z), cells)
              - corner_sum(ivec3(b.x, a.yz), cells) + corner_sum(a, cells);
    return near == far;
}

// Levels in the box from lo to hi, in cells, of which cell i covers [i, i + 1]; beyond all cells there is
// nothing. Along each axis a fraction of a cell, whole cells, and a fraction of one. No loop rounds where
// `planes` is 0 instead of 4.
REAL box_sum(vec3 lo, vec3 hi, ivec3 cells, int planes) {
    ivec3 first = ivec3(floor(lo)), last = ivec3(floor(hi));
    // lo and hi in one cell: only that part of it counts. Both parts less the whole cell would be the same, but
    // of a small box nothing but rounding would be left.
    bvec3 in_one = equal(first, last);
    mat3 weights = mat3(mix(vec3(first) + 1.0 - lo, hi - lo, in_one), mix(vec3(1.0), vec3(0.0), in_one),
                        mix(hi - vec3(last), vec3(0.0), in_one));
    ivec3 corners[4] = ivec3[4](first, first + 1, last, last + 1);
    WHOLE before[16];
    REAL sum = REAL(0.0);
    for (int i = 0; i < planes; ++i) {
        WHOLE now[16];
        for (int j = 0; j < 4; ++j)
            for (int k = 0; k < 4; ++k)
                now[4 * j + k] = corner_sum(ivec3(corners[i].x, corners[j].y, corners[k].z), cells);
        for (int j = 0; j < 3 && i > 0; ++j)
            for (int k = 0; k < 3; ++k) {
                int a = 4 * j + k, b = a + 4;
                WHOLE levels = (now[b + 1] - before[b + 1]) - (now[b] - before[b])
                             - (now[a + 1] - before[a + 1]) + (now[a] - before[a]);
                sum += weights[i - 1].x * weights[j].y * weights[k].z * REAL(SIGNED(levels));
            }
        before = now;
    }
    return sum;
}
