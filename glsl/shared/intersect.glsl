// Ray against boxes and half-spaces: intervals of t.

// Narrows [t.x, t.y] to where the ray is inside the box; empty (t.x >= t.y) if it misses.
// A ray parallel to a slab has d = 0 there: it is inside for all t or for none.
vec2 clip_to_box(vec2 t, vec3 o, vec3 d, vec3 box_min, vec3 box_max) {
    for (int axis = 0; axis < 3; ++axis) {
        if (d[axis] == 0.0) {
            if (o[axis] < box_min[axis] || o[axis] > box_max[axis]) t.y = t.x;
            continue;
        }
        float a = (box_min[axis] - o[axis]) / d[axis];
        float b = (box_max[axis] - o[axis]) / d[axis];
        t = vec2(max(t.x, min(a, b)), min(t.y, max(a, b)));
    }
    return t;
}

// Narrows [t.x, t.y] to where dot(plane.xyz, x) + plane.w >= 0.
vec2 clip_to_half_space(vec2 t, vec3 o, vec3 d, vec4 plane) {
    float height = dot(plane.xyz, o) + plane.w;
    float slope = dot(plane.xyz, d);
    if (slope == 0.0) return height >= 0.0 ? t : vec2(t.x, t.x);
    float hit = -height / slope;
    return slope > 0.0 ? vec2(max(t.x, hit), t.y) : vec2(t.x, min(t.y, hit));
}
