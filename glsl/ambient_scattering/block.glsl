// Samples in a row along a camera ray.

// A ray in voxels: where its first sample lies, and the step to the next.
struct GridRay {
    vec3 first;
    vec3 per_step;
};

// Along the camera ray: place of the first sample and direction in the world, the same in the grid.
struct ViewRay {
    vec3 x_first;
    vec3 direction;
    GridRay grid;
    float dt;
    float delay; // steps across a radius
};

// Optical depths from the eye: to a sample, and to where the light gathered at it sets out.
struct Depths {
    float at;
    float from;
};

// Optical depth from the eye to each sample's beginning, its own; from where its light sets out, as a share of
// that light; its colour, and its albedo over the medium's factor.
struct Block {
    float tau[BLOCK + 1];
    float dtau[BLOCK];
    float literal[BLOCK];
    vec3 color[BLOCK];
    vec3 albedo[BLOCK];
    bool is_lit;
};

ViewRay view_ray(Ray camera, vec2 t, int count) {
    float dt = (t.y - t.x) / float(count);
    vec3 x_first = camera.origin + (t.x + 0.5 * dt) * camera.direction;
    vec3 dims = last_voxel + 1.0;
    GridRay grid = GridRay(texture_point(x_first) * dims - 0.5, texture_direction(camera.direction) * dt * dims);
    return ViewRay(x_first, camera.direction, grid, dt, radius / dt);
}

// Depths of the samples a radius nearer to the eye than i to i + BLOCK - 1 [Ament2013, Algorithm 1].
void delayed_depths(ViewRay ray, int i, int count, out float dtau[BLOCK]) {
    vec3 q = ray.grid.first - ray.delay * ray.grid.per_step;
    float values[MAX_BLOCK];
    values_of(q, ray.grid.per_step, i, BLOCK, values);
    for (int k = 0; k < BLOCK; ++k) {
        // Before the volume there is nothing.
        float at = float(i + k) - ray.delay;
        vec3 place = q + float(i + k) * ray.grid.per_step;
        dtau[k] = i + k < count && at > -0.5 ? extinction_of(values[k], place) * ray.dt : 0.0;
        if (MASKED) dtau[k] *= finite_weight(place);
    }
}

// Samples i to i + BLOCK - 1; those past the ray's end, or its last that can be seen, are empty.
Block sample_block(ViewRay ray, int i, int count, float tau_end, inout Depths depths) {
    Block block;
    float values[MAX_BLOCK], delayed[BLOCK];
    values_of(ray.grid.first, ray.grid.per_step, i, BLOCK, values);
    if (LITERAL_GATHER) delayed_depths(ray, i, count, delayed);
    block.tau[0] = depths.at;
    for (int k = 0; k < BLOCK; ++k) {
        vec3 q = ray.grid.first + float(i + k) * ray.grid.per_step;
        vec4 material = material_of(values[k], q);
        float dtau = i + k < count && depths.from < tau_end ? material.a * ray.dt : 0.0;
        if (MASKED) dtau *= finite_weight(q);
        depths.at += dtau;
        block.dtau[k] = dtau;
        block.tau[k + 1] = depths.at;
        block.literal[k] = LITERAL_GATHER ? exp(-depths.from) * dtau : 0.0;
        depths.from = LITERAL_GATHER ? depths.from + delayed[k] : depths.at;
        block.color[k] = material.rgb;
        block.albedo[k] = material.rgb;
        if (ALBEDO_VOLUME) block.albedo[k] = textureLod(albedo_volume, texture_of(q), 0.0).rgb;
    }
    block.is_lit = depths.at > block.tau[0];
    return block;
}

// Share of what a sample sends out that reaches the eye: exact for one even in the sample.
float seen(Block block, int k) {
    return absorbed(exp(-block.tau[k]), exp(-block.tau[k + 1]), block.dtau[k]);
}
