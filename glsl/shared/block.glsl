// Samples in a row along a camera ray, each with its share of the light that reaches the eye. The includer declares
// MASKED, BLOCK and tau_end, the optical depth that ends a ray, and includes shared/material.glsl and
// shared/transmittance.glsl before.

// A ray in some unit: where its first sample lies, and the step to the next.
struct SteppedRay {
    vec3 first;
    vec3 per_step;
};

// What is before a place on a ray.
struct Before {
    float tau;           // optical depth
    float transmittance; // exp(-tau)
};

// Samples in a row: the share of the ray's light that each sends out, and its colour.
struct Block {
    float weight[MAX_BLOCK];
    vec3 color[MAX_BLOCK];
};

// Samples i to i + BLOCK - 1 of a ray in voxels; those past the ray's end, or its last that can be seen, have no
// weight.
Block sample_block(SteppedRay ray, int i, int count, float dt, inout Before before) {
    Block block;
    float values[MAX_BLOCK];
    values_of(ray.first, ray.per_step, i, BLOCK, values);
    for (int k = 0; k < BLOCK; ++k) {
        vec4 material = material_of(values[k], ray.first + float(i + k) * ray.per_step);
        float dtau = i + k < count && before.tau < tau_end ? material.a * dt : 0.0;
        if (MASKED) dtau *= finite_weight(ray.first + float(i + k) * ray.per_step);
        before.tau += dtau;
        float transmittance_after = exp(-before.tau);
        block.weight[k] = absorbed(before.transmittance, transmittance_after, dtau);
        block.color[k] = material.rgb;
        before.transmittance = transmittance_after;
    }
    return block;
}
