// L_o as the paper estimates it [Ament2013, Sec. 4.1.2]: analog paths, absorbed by chance, the boundary
// [Ament2013, Eq. 11] looked up where they leave. What preintegrate is measured against.
// Domain: one workgroup a job, four angles an invocation. Dispatched by technique/ambient_scattering/table/record.rs.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "ambient_scattering/sphere.glsl"

layout(local_size_x = 64) in;

// lavapipe ends a shader after 65,535 loop rounds.
const uint MAX_COLLISIONS = 60000u;

// In the frame of the light, which travels along z.
float boundary(Job job, vec3 at, vec3 v) {
    return exp(-2.0 * job.sigma_t * max(at.z, 0.0)) * phase_hg(-v.z, job.g);
}

void main() {
    uint lane = gl_LocalInvocationID.x, index = gl_WorkGroupID.x;
    if (index >= job_count) return;
    Job job = jobs[index];
    float albedo = exp2(log2_albedo[0]);
    uint count = 0u, paths = 0u, j = 0u;
    vec3 x = vec3(0.0), v = vec3(0.0);
    bool alive = false;
    vec4 sums = vec4(0.0);
    for (; count < MAX_COLLISIONS; ++count) {
        if (!alive) {
            if (paths == 4u * job.paths) break;
            j = paths++ & 3u;
            float theta = job.theta_first + job.theta_step * float(4u * lane + j);
            x = vec3(sin(theta), 0.0, cos(theta));
            v = -x;
            alive = true;
        }
        uvec4 counter = uvec4(job.key, job.batch * gl_WorkGroupSize.x + lane, count, seed);
        vec4 u = uniform_numbers(counter);
        float length = distance_out(x, v);
        float t = -log(1.0 - u.x) / max(job.sigma_t, 1e-20);
        if (t >= length) {
            sums[j] += boundary(job, x + length * v, v);
            alive = false;
        } else if (u.y >= albedo) {
            alive = false;
        } else {
            x += t * v;
            v = turn(v, sample_hg(u.z, job.g), u.w);
        }
    }
    for (uint i = 0u; i < 4u; ++i)
        means[index * 4u * gl_WorkGroupSize.x + 4u * lane + i] = sums[i] / float(job.paths);
    if (count == MAX_COLLISIONS) unfinished[index] = 1u;
}
