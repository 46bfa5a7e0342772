// Straight flight through the medium: delta tracking for paths [Woodcock1965], residual ratio tracking
// for shadow rays [Novak2014], between the bounds that hold in each leaf of a partition of the volume.
const float FAR = 3.0e38;
const uint STRETCHES = 64; // most in a row, so that a round is bounded
const uint MISSES = 16;    // most samples that miss the medium in a round

const uint ON_THE_WAY = 0;
const uint COLLIDED = 1;
const uint ARRIVED = 2;

// The block's values in registers: lavapipe reads a uniform anew at each use, lane by lane.
vec3 dims;
float albedo;
float emission;
vec3 bounds;
vec3 straight;
vec2 line;
vec3 environment;
vec3 background;
vec4 grid_x;
vec4 grid_y;
vec4 grid_z;
vec3 map_x;
vec3 map_y;
vec3 map_z;
ivec2 map_size;
vec3 map_scale;
Light lights[LIGHT_COUNT + 1];

void load_block() {
    table = trace.table;
    dims = trace.dims.xyz;
    last_voxel = dims - 1.0;
    load_material();
    albedo = trace.dims.w;
    bounds = trace.bounds.xyz;
    emission = trace.bounds.w;
    straight = trace.straight.rgb;
    line = trace.line.xy;
    environment = trace.environment.rgb;
    background = view.background.rgb;
    grid_x = trace.grid_from_world[0];
    grid_y = trace.grid_from_world[1];
    grid_z = trace.grid_from_world[2];
    map_x = trace.map_from_world[0].xyz;
    map_y = trace.map_from_world[1].xyz;
    map_z = trace.map_from_world[2].xyz;
    map_size = ivec2(trace.map_from_world[0].w, trace.map_from_world[1].w);
    map_scale = trace.map_scale.rgb;
    for (uint i = 0; i < LIGHT_COUNT; ++i) lights[i] = trace.lights[i];
}

// A ray in grid coordinates, voxel centres at whole numbers.
struct Flight {
    vec3 q;
    vec3 dq;
    vec3 per_dq;  // 1 / dq, huge for 0
    ivec3 ahead;  // 1 where the coordinate rises along the ray
    ivec3 cell;   // where it is
    float value;  // of the volume, at the last collision
};

vec3 grid_point(vec3 x) {
    vec4 h = vec4(x, 1.0);
    return vec3(dot(grid_x, h), dot(grid_y, h), dot(grid_z, h));
}

vec3 grid_direction(vec3 d) {
    return vec3(dot(grid_x.xyz, d), dot(grid_y.xyz, d), dot(grid_z.xyz, d));
}

// Where the coordinate does not change it counts as rising, so slowly that no face is ever reached.
bvec3 rises(vec3 dq) {
    return greaterThan(dq, vec3(-1e-30));
}

vec3 inverse(vec3 dq) {
    return 1.0 / mix(dq, vec3(1e-30), lessThan(abs(dq), vec3(1e-30)));
}

ivec3 cell_at(vec3 q) {
    return clamp(ivec3((q + 0.5) / float(max(CELL, 1u))), ivec3(0), ivec3(dims - 1.0) / int(max(CELL, 1u)));
}

Flight flight_of(Walker p) {
    Flight f;
    f.q = grid_point(p.x);
    f.dq = grid_direction(p.d);
    f.per_dq = inverse(f.dq);
    f.ahead = ivec3(rises(f.dq));
    if (CELL != 0) f.cell = cell_at(f.q + p.t * f.dq);
    f.value = 0.0;
    return f;
}

// Where a camera ray is inside the volume and the clips, which together are convex.
vec2 inside(Ray ray) {
    vec2 t = clip_to_box(vec2(ray.t_min, FAR), grid_point(ray.origin), grid_direction(ray.direction),
                         vec3(-0.5), dims - 0.5);
    if (CLIP_BOX) t = clip_to_box(t, ray.origin, ray.direction, view.clip_min.xyz, view.clip_max.xyz);
    if (CLIP_PLANE) t = clip_to_half_space(t, ray.origin, ray.direction, view.clip_plane);
    return t;
}

// Begins the way along d from x, inside, to t_end or where the medium ends.
void set_out(inout Walker p) {
    vec3 dq = grid_direction(p.d);
    vec3 face = mix(vec3(-0.5), dims - 0.5, rises(dq));
    vec3 t = (face - grid_point(p.x)) * inverse(dq);
    p.t_end = min(p.t_end, min(t.x, min(t.y, t.z)));
    vec2 clipped = vec2(0.0, p.t_end);
    if (CLIP_BOX) clipped = clip_to_box(clipped, p.x, p.d, view.clip_min.xyz, view.clip_max.xyz);
    if (CLIP_PLANE) clipped = clip_to_half_space(clipped, p.x, p.d, view.clip_plane);
    p.t_end = max(clipped.y, 0.0);
    p.t = 0.0;
    p.tau_left = -log(1.0 - uniforms(p).x);
    p.tau = 0.0;
    p.transmittance = 1.0;
}

float sigma_t_of(float value, vec3 q) {
    if (STRAIGHT) return max(line.x + line.y * (value - table.x), 0.0);
    return extinction_of(value, q);
}

vec3 color_of(float value, vec3 q) {
    if (STRAIGHT) return straight;
    return material_of(value, q).rgb;
}

// From where the flight is to the next tentative collision, the leaf's face or the end.
uint stretch(inout Walker p, inout Flight f, bool shadow) {
    vec2 within = bounds.xy;
    float t_exit = FAR;
    ivec3 lo = ivec3(0);
    int size = 1;
    vec3 to_face = vec3(FAR);
    if (CELL != 0) {
        uvec2 leaf = imageLoad(leaves, f.cell).xy;
        within = uintBitsToFloat(leaf);
        int level = int(leaf.x & 15u);
        size = 1 << level;
        lo = (f.cell >> level) << level;
        to_face = (vec3((lo + f.ahead * size) * int(CELL)) - 0.5 - f.q) * f.per_dq;
        t_exit = min(to_face.x, min(to_face.y, to_face.z));
    }
    float rate = shadow ? within.x - within.y : within.x;
    float t_hit = p.t + p.tau_left / max(rate, 1e-30);
    float t_stop = max(min(t_exit, p.t_end), p.t);
    bool hit = t_hit < t_stop;
    float t = hit ? t_hit : t_stop;
    p.tau_left = max(p.tau_left - rate * (t - p.t), 0.0);
    if (shadow) p.tau += within.y * (t - p.t);
    p.t = t;
    uint outcome = t >= p.t_end ? ARRIVED : ON_THE_WAY;
    vec3 q = f.q + t * f.dq;
    float value = value_of(q);
    float sigma_t = sigma_t_of(value, q);
    if (MASKED) sigma_t *= finite_weight(q);
    if (hit) {
        vec4 u = uniforms(p);
        p.tau_left = -log(1.0 - u.x);
        if (shadow) p.transmittance *= clamp(1.0 - (sigma_t - within.y) / rate, 0.0, 1.0);
        else if (u.y * rate < sigma_t) outcome = COLLIDED;
        f.value = value;
    } else if (CELL != 0) {
        // The face is crossed along one axis; along the others the ray is where it is.
        ivec3 axis = ivec3(equal(to_face, vec3(t_exit)));
        ivec3 along = clamp(ivec3((q + 0.5) / float(CELL)), lo, lo + size - 1);
        f.cell = axis * (lo + f.ahead * (size + 1) - 1) + (1 - axis) * along;
        ivec3 last = ivec3(dims - 1.0) / int(max(CELL, 1u));
        if (any(lessThan(f.cell, ivec3(0))) || any(greaterThan(f.cell, last))) outcome = ARRIVED;
    }
    // Nothing worth following gets through.
    if (shadow && (p.tau > 80.0 || p.transmittance <= 0.0)) outcome = ARRIVED;
    return outcome;
}
