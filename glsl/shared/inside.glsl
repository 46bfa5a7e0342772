// Where rays are inside the volume and what the clips keep of it. The includer declares CLIP_BOX and CLIP_PLANE
// and includes shared/view.glsl and shared/intersect.glsl before.

// Of a position, as a share of the box that it lies in.
const float ROUNDING = 1e-5;

// The stretch of a ray inside the volume and the clips; empty (t.x >= t.y) if it misses.
vec2 inside(vec2 t, vec3 o, vec3 d) {
    t = clip_to_box(t, texture_point(o), texture_direction(d), vec3(0.0), vec3(1.0));
    if (CLIP_BOX) t = clip_to_box(t, o, d, view.clip_min.xyz, view.clip_max.xyz);
    if (CLIP_PLANE) t = clip_to_half_space(t, o, d, view.clip_plane);
    return t;
}

// `o` on the box's face where it lies beyond it by rounding only.
vec3 snapped(vec3 o, vec3 box_min, vec3 box_max) {
    vec3 on = clamp(o, box_min, box_max);
    return mix(o, on, lessThan(abs(o - on), ROUNDING * (box_max - box_min)));
}

// The same for a ray that starts at x in the medium or on its surface: rounding does not move it off, where
// nothing would shade it, nor into, where a dense medium would.
vec2 inside_from(vec2 t, vec3 x, vec3 d) {
    vec3 p = snapped(texture_point(x), vec3(0.0), vec3(1.0));
    t = clip_to_box(t, p, texture_direction(d), vec3(0.0), vec3(1.0));
    if (CLIP_BOX) {
        vec3 o = snapped(x, view.clip_min.xyz, view.clip_max.xyz);
        t = clip_to_box(t, o, d, view.clip_min.xyz, view.clip_max.xyz);
    }
    if (CLIP_PLANE) {
        vec4 plane = view.clip_plane;
        float height = dot(plane.xyz, x) + plane.w;
        // ROUNDING of the volume's extent along the normal.
        if (abs(height) * length(texture_direction(plane.xyz)) < ROUNDING) plane.w -= height;
        t = clip_to_half_space(t, x, d, plane);
    }
    return t;
}

// Equal steps, none longer than `largest`. A length of a whole number of them must not become one more
// by rounding.
int steps_along(float length_t, float largest) {
    return max(1, int(ceil(length_t / largest - 1e-3)));
}
