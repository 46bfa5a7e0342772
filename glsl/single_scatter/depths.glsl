// Optical depths from the ends of samples to a light, by the cache: light_depth holds one block of nodes a
// light, stacked along z.

// Cells of nodes that the march crosses on a shadow ray itself, its samples of them, and the optical depth of
// that way from which on it does.
const float NEAR_CELLS = 2.0;
const int NEAR = 4;
const float DENSE = 0.2;
// A shadow ray that is taken beside the cache has at most this many samples.
const float CLOSE_SAMPLES = 64.0;

// Along the camera ray: origin and direction in the world, its grid coordinates at mid-samples.
struct ViewRay {
    vec3 x_first;
    vec3 direction;
    GridRay grid;
    float dt;
};

// Samples in a row: optical depth from the eye to each one's beginning, its own, its colour, and its albedo
// over the medium's factor.
struct Block {
    float tau[BLOCK + 1];
    float dtau[BLOCK];
    vec3 color[BLOCK];
    vec3 albedo[BLOCK];
};

vec3 node_first;
vec3 per_node;
vec3 node_last;

void load_nodes() {
    node_first = scatter.node_first.xyz;
    per_node = 1.0 / scatter.node_spacing.xyz;
    node_last = scatter.node_last.xyz;
}

#ifdef TEXEL_FORMAT
layout(set = 0, binding = 7, r32f) readonly uniform image3D light_depth;

float node_depth(int x, int y, int z) {
    return imageLoad(light_depth, ivec3(x, y, z)).r;
}

// At `BLOCK + 1` places dq apart, from q on, in grid coordinates.
void block_depths(vec3 q, vec3 dq, int light, out float depths[BLOCK + 1]) {
    int slices = light * (int(node_last.z) + 1);
    ivec3 corner[BLOCK + 1], beyond[BLOCK + 1];
    vec3 between[BLOCK + 1];
    float near[BLOCK + 1], far[BLOCK + 1];
    // One texel of every slice first: the processor waits for all of them at once, and finds their
    // neighbours in its cache.
    for (int k = 0; k <= BLOCK; ++k) {
        vec3 at = clamp((q + float(k) * dq - node_first) * per_node, vec3(0.0), node_last);
        ivec3 lo = ivec3(at), hi = min(lo + 1, ivec3(node_last));
        between[k] = at - vec3(lo);
        lo.z += slices;
        hi.z += slices;
        near[k] = node_depth(lo.x, lo.y, lo.z);
        far[k] = node_depth(lo.x, lo.y, hi.z);
        corner[k] = lo;
        beyond[k] = hi;
    }
    for (int k = 0; k <= BLOCK; ++k) {
        ivec3 lo = corner[k], hi = beyond[k];
        vec3 f = between[k];
        float x00 = mix(near[k], node_depth(hi.x, lo.y, lo.z), f.x);
        float x10 = mix(node_depth(lo.x, hi.y, lo.z), node_depth(hi.x, hi.y, lo.z), f.x);
        float x01 = mix(far[k], node_depth(hi.x, lo.y, hi.z), f.x);
        float x11 = mix(node_depth(lo.x, hi.y, hi.z), node_depth(hi.x, hi.y, hi.z), f.x);
        depths[k] = mix(mix(x00, x10, f.y), mix(x01, x11, f.y), f.z);
    }
}
#else
layout(set = 0, binding = 7) uniform sampler3D light_depth;

// At `BLOCK + 1` places dq apart, from q on, in grid coordinates.
void block_depths(vec3 q, vec3 dq, int light, out float depths[BLOCK + 1]) {
    vec3 per_texture = 1.0 / vec3(textureSize(light_depth, 0));
    vec3 first = vec3(0.5, 0.5, 0.5 + float(light) * (node_last.z + 1.0));
    for (int k = 0; k <= BLOCK; ++k) {
        vec3 at = clamp((q + float(k) * dq - node_first) * per_node, vec3(0.0), node_last);
        depths[k] = textureLod(light_depth, (first + at) * per_texture, 0.0).r;
    }
}
#endif

// Where sample i begins, of the last where the ray ends.
vec3 end_of(ViewRay ray, int i, int count) {
    return ray.x_first + (float(min(i, count)) - 0.5) * ray.dt * ray.direction;
}

// The way from x to the light that leads across the near cells of nodes, or to the light.
vec3 near_way(vec3 x, Light light) {
    vec3 w_i = light.place.xyz;
    float far = 3.0e38;
    if (POINT_LIGHTS && light.place.w > 0.0) {
        w_i -= x;
        far = length(w_i);
        w_i /= max(far, 1e-30);
    }
    vec3 crossed = abs(texture_direction(w_i) * (last_voxel + 1.0) * per_node);
    return w_i * min(far, NEAR_CELLS / max(crossed.x, max(crossed.y, crossed.z)));
}

// Whether the block is so close to a point light that its ends see it in quite different directions. Shadow
// rays are short there.
bool is_close(ViewRay ray, int i, Light light) {
    float block = float(BLOCK) * ray.dt;
    vec3 x = ray.x_first + (float(i) - 0.5) * ray.dt * ray.direction + 0.5 * block * ray.direction;
    float radius = min(2.0 * block, CLOSE_SAMPLES * scatter.node_first.w);
    return light.place.w > 0.0 && distance(x, light.place.xyz) < radius;
}

// Depths to the light from the block's BLOCK + 1 ends, by the cache; where the medium is dense, by NEAR
// samples across the near cells and from there by the cache, so that a surface does not shade itself
// through nodes beneath it.
void cached_depths(Block block, ViewRay ray, int i, int count, Light light, int l, out float depths[BLOCK + 1]) {
    vec3 dims = last_voxel + 1.0;
    vec3 x = ray.x_first + (float(i) - 0.5) * ray.dt * ray.direction;
    vec3 dx = ray.dt * ray.direction;
    vec3 q = ray.grid.first + (float(i) - 0.5) * ray.grid.per_step;
    // The ways from the ends between are interpolated.
    vec3 way = near_way(x, light);
    float densest = max(max(block.dtau[0], block.dtau[1]), max(block.dtau[2], block.dtau[3]));
    // A loop later, not a branch: software drivers go through branches that no lane takes.
    int samples = densest * length(way) > DENSE * ray.dt ? NEAR : 0;
    way *= samples > 0 ? 1.0 : 0.0;
    vec3 dway = vec3(0.0);
    if (POINT_LIGHTS && samples > 0) dway = (near_way(x + float(BLOCK) * dx, light) - way) / float(BLOCK);
    vec3 off = texture_direction(way) * dims;
    vec3 doff = POINT_LIGHTS ? texture_direction(dway) * dims : vec3(0.0);
    block_depths(q + off, ray.grid.per_step + doff, l, depths);
    float room[BLOCK + 1], length_way[BLOCK + 1];
    for (int k = 0; k <= BLOCK; ++k) {
        vec3 w = way + float(k) * dway;
        vec3 at = end_of(ray, i + k, count);
        // The share of the way that is inside; nothing is beyond.
        room[k] = samples > 0 ? clamp(inside_from(vec2(0.0, 1.0), at, w).y, 0.0, 1.0) : 1.0;
        length_way[k] = length(w) / float(NEAR);
        depths[k] = room[k] < 1.0 ? 0.0 : depths[k];
        // Nor beyond the light, about which depths are a cone that nodes do not resolve.
        bool reached = POINT_LIGHTS && light.place.w > 0.0 && distance(at, light.place.xyz) < 1.001 * length(w);
        if (samples > 0 && reached) depths[k] = 0.0;
    }
    for (int n = 0; n < samples; ++n) {
        float part = (float(n) + 0.5) / float(NEAR);
        float values[MAX_BLOCK];
        vec3 q_0 = q + part * off, dq = ray.grid.per_step + part * doff;
        values_of(q_0, dq, 0, BLOCK + 1, values);
        for (int k = 0; k <= BLOCK; ++k) {
            float dtau = extinction_of(values[k], q_0 + float(k) * dq) * length_way[k];
            dtau *= clamp(room[k] * float(NEAR) - float(n), 0.0, 1.0);
            depths[k] += dtau;
        }
    }
}
