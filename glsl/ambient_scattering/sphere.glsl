// What both estimators of L_o share: their jobs, and flights through the unit sphere.
#include "shared/random.glsl"
#include "shared/phase.glsl"

const uint MAX_ALBEDOS = 8u;

// sigma_t: per radius. g: of the phase function. key: of the column's random numbers. batch: which of
// the column's batches. stretch: how much longer flights are that lead away from the start, for the
// middle and the strongest of three strategies. decay: how fast radiance falls off from the start, per
// radius. theta_first, theta_step: angles to the light. even: share of looks in any direction.
// paths: of an invocation, a multiple of 6.
struct Job {
    float sigma_t;
    float g;
    uint key;
    uint batch;
    float stretch[2];
    float decay;
    float theta_first;
    float theta_step;
    float even;
    uint paths;
};

layout(std430, set = 0, binding = 0) readonly buffer Jobs { Job jobs[]; };
// By job, albedo, angle; sums until the job has ended.
layout(std430, set = 0, binding = 1) buffer Means { float means[]; };
// By job: 0 once all its paths have ended.
layout(std430, set = 0, binding = 2) buffer Unfinished { uint unfinished[]; };

// seed: of all random numbers. job_count: how many. rounds: of a dispatch, at most. resumed: 1 where the
// jobs go on from where the dispatch before left them. log2_albedo: of the albedos, the largest first.
layout(push_constant) uniform Push {
    uint seed;
    uint job_count;
    uint rounds;
    uint resumed;
    float log2_albedo[MAX_ALBEDOS];
};

// In [0, 1).
vec4 uniform_numbers(uvec4 counter) {
    return vec4(pcg4d(counter) >> 8u) * 5.9604645e-8;
}

// From x inside the unit sphere along v to its surface; without cancellation outwards, too.
float distance_out(vec3 x, vec3 v) {
    float along = dot(x, v);
    float inside = max(1.0 - dot(x, x), 0.0);
    float root = sqrt(along * along + inside);
    return along > 0.0 ? inside / (along + root) : root - along;
}

// (1 - exp(-tau)) / tau.
float mean_transmittance(float tau) {
    return tau < 1e-3 ? 1.0 - 0.5 * tau : (1.0 - exp(-tau)) / tau;
}

// A flight, u in [0, 1), that collides within length: the collision is where 1 - exp(-sigma t) is
// u (1 - exp(-sigma length)).
float flight_within(float sigma, float length, float u) {
    float tau = sigma * length;
    if (tau < 1e-3) return length * u * (1.0 - 0.5 * tau * (1.0 - u));
    return min(-log(1.0 - u * (1.0 - exp(-tau))) / sigma, length);
}
