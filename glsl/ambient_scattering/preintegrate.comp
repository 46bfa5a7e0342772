// The collided part of L_o, over what collides [Ament2013, Sec. 4.1]: every vertex of a path scores the
// expected radiance of the boundary [Ament2013, Eq. 11] for all angles to the light at once. Jobs that do
// not end within a dispatch are kept, and go on in the next.
// Domain: one workgroup a job, 64 paths side by side, then 256 angles over the same 64 invocations.
// Dispatched by technique/ambient_scattering/table/record.rs.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "ambient_scattering/sphere.glsl"

layout(local_size_x = 64) in;
layout(constant_id = 0) const uint ALBEDOS = 1u;

const uint LANES = 64u;
// Of so many paths one goes by each of two stretched strategies, which find the dark side, the others by the
// plain one, which is best for the rest.
const uint CYCLE = 6u;
// At most, of a round.
const uint MAX_STEPS = 24u;
// Scores and paths below these shares of what is usual at their place play roulette.
const float SCORE_SHARE = 1.0;
const float PATH_SHARE = 0.2;

// Where a score leaves and whereto, both in the plane of the light: x, z, v_x, v_z.
shared vec4 exits[LANES];
shared float weights[MAX_ALBEDOS * LANES];
shared uint busy[2];

// A path in the frame where it starts at (0, 0, 1) towards the centre.
struct Path {
    vec3 x;
    float survival;
    vec3 v;
    uint order;
    // How much likelier the two stretched strategies make it than the plain one.
    vec2 likelier;
};

// Where an invocation is: its path, and paths begun and random numbers drawn so far.
struct Lane {
    Path path;
    uint strategy;
    uint alive;
    uint begun;
    uint draws;
};

// By job, invocation.
layout(std430, set = 0, binding = 3) buffer Lanes { Lane lanes[]; };

// Radiance that is usual at x, over that at the start.
float usual(vec3 x, float decay) {
    return exp(-decay * min(distance(x, vec3(0.0, 0.0, 1.0)), 1.41421356));
}

// By the balance heuristic over the three strategies [Veach1995]; without the albedo.
float weight(Path path) {
    return float(CYCLE) * path.survival / (float(CYCLE - 2u) + path.likelier.x + path.likelier.y);
}

vec2 stretches(Job job) {
    return vec2(job.stretch[0], job.stretch[1]);
}

float stretch_of(Job job, uint strategy) {
    return strategy == 0u ? 0.0 : job.stretch[strategy - 1u];
}

Path start(Job job, uint strategy, float u) {
    Path path;
    float t = flight_within(job.sigma_t * (1.0 - stretch_of(job, strategy)), 2.0, u);
    path.x = vec3(0.0, 0.0, 1.0 - t);
    path.v = vec3(0.0, 0.0, -1.0);
    path.order = 0u;
    vec2 tau = 2.0 * job.sigma_t * (1.0 - stretches(job));
    vec2 mean = vec2(mean_transmittance(tau.x), mean_transmittance(tau.y));
    path.likelier = exp(job.sigma_t * t * stretches(job)) * mean_transmittance(2.0 * job.sigma_t) / mean;
    path.survival = 1.0;
    return path;
}

// Flies on from a collision; false where the path leaves or ends.
bool fly(Job job, inout Path path, uint strategy, vec2 u) {
    vec3 away = path.x - vec3(0.0, 0.0, 1.0);
    float mu = dot(path.v, away) / max(sqrt(dot(away, away)), 1e-6);
    vec2 slower = 1.0 - stretches(job) * mu;
    float sigma = job.sigma_t * (1.0 - stretch_of(job, strategy) * mu);
    float t = -log(1.0 - u.x) / max(sigma, 1e-20);
    if (t >= distance_out(path.x, path.v)) return false;
    path.x += t * path.v;
    path.likelier = min(path.likelier * slower * exp(job.sigma_t * t * mu * stretches(job)), 1e30);
    float share = weight(path) * exp2(float(path.order) * log2_albedo[0]) / (PATH_SHARE * usual(path.x, job.decay));
    if (share >= 1.0) return true;
    path.survival /= share;
    return u.y < share;
}

// Where to look for the boundary's light: mostly where the path goes on, job.even of the times anywhere,
// so that neither a strong phase function nor a strong light is missed. Returns phase over density.
float look(Job job, vec3 v, vec3 next_v, vec3 u, out vec3 out_v) {
    out_v = u.z < job.even ? turn(v, 1.0 - 2.0 * u.x, u.y) : next_v;
    float phase = phase_hg(dot(v, out_v), job.g);
    return phase / mix(phase, 0.0795774715, job.even);
}

void write_score(uint lane, uint order, vec3 at, vec3 v, float value) {
    exits[lane] = vec4(at.x, at.z, v.x, v.z);
    for (uint k = 0u; k < ALBEDOS; ++k)
        weights[k * LANES + lane] = value * exp2(float(order - 1u) * log2_albedo[k]);
}

// Adds the scores of all lanes to the sums of four angles.
void add_scores(Job job, vec4 sin_theta, vec4 cos_theta, inout vec4 sums[MAX_ALBEDOS]) {
    float per_height = -2.885390082 * job.sigma_t;
    float near = (1.0 - abs(job.g)) * (1.0 - abs(job.g));
    for (uint i = 0u; i < LANES; ++i) {
        if (weights[i] == 0.0) continue;
        vec4 e = exits[i];
        vec4 height = sin_theta * e.x + cos_theta * e.y;
        vec4 turned = sin_theta * e.z + cos_theta * e.w;
        // As phase_hg, of -turned and without its norm.
        vec4 d = near + 2.0 * max(abs(job.g) + job.g * turned, 0.0);
        vec4 radiance = exp2(per_height * max(height, 0.0)) / (d * sqrt(d));
        for (uint k = 0u; k < ALBEDOS; ++k) sums[k] += weights[k * LANES + i] * radiance;
    }
}

// Sums of a lane's angle j.
uint place(uint index, uint k, uint lane, uint j) {
    return (index * ALBEDOS + k) * 4u * LANES + 4u * lane + j;
}

// Steps until there is a score worth adding, at most MAX_STEPS.
void follow(Job job, uint lane, inout Lane state) {
    for (uint steps = 0u; steps < MAX_STEPS && (state.alive != 0u || state.begun < job.paths); ++steps) {
        uvec4 counter = uvec4(job.key, job.batch * LANES + lane, state.draws++, seed);
        if (state.alive == 0u) {
            state.strategy = uint(max(int(state.begun++ % CYCLE) - int(CYCLE - 3u), 0));
            state.path = start(job, state.strategy, uniform_numbers(counter).x);
            counter.z = state.draws++;
        }
        vec4 u = uniform_numbers(counter), more = uniform_numbers(counter ^ uvec4(0u, 0u, 0x80000000u, 0u));
        Path path = state.path;
        path.order += 1u;
        vec3 next_v = turn(path.v, sample_hg(u.x, job.g), u.y), scored_v;
        float value = weight(path) * look(job, path.v, next_v, more.xyz, scored_v);
        vec3 at = path.x + distance_out(path.x, scored_v) * scored_v;
        value *= exp(-job.sigma_t * distance(at, path.x));
        float share = value * exp2(float(path.order - 1u) * log2_albedo[0]) / (SCORE_SHARE * usual(at, job.decay));
        uint order = path.order;
        path.v = next_v;
        state.alive = fly(job, path, state.strategy, u.zw) ? 1u : 0u;
        state.path = path;
        if (more.w < share) {
            write_score(lane, order, at, scored_v, value / min(share, 1.0));
            break;
        }
    }
}

void main() {
    uint lane = gl_LocalInvocationID.x, index = gl_WorkGroupID.x;
    if (index >= job_count) return;
    if (resumed != 0u && unfinished[index] == 0u) return;
    Job job = jobs[index];
    vec4 theta = job.theta_first + job.theta_step * (4.0 * float(lane) + vec4(0.0, 1.0, 2.0, 3.0));
    vec4 sin_theta = sin(theta), cos_theta = cos(theta);
    vec4 sums[MAX_ALBEDOS];
    for (uint k = 0u; k < MAX_ALBEDOS; ++k) sums[k] = vec4(0.0);
    Lane state;
    state.alive = state.begun = state.draws = state.strategy = 0u;
    if (resumed != 0u) {
        state = lanes[index * LANES + lane];
        for (uint k = 0u; k < ALBEDOS; ++k)
            for (uint j = 0u; j < 4u; ++j) sums[k][j] = means[place(index, k, lane, j)];
    }
    if (lane < 2u) busy[lane] = 0u;
    barrier();
    bool going_on = true;
    for (uint round = 0u; going_on && round < rounds; ++round) {
        weights[lane] = 0.0;
        follow(job, lane, state);
        uint flag = round & 1u;
        if (state.alive != 0u || state.begun < job.paths) atomicOr(busy[flag], 1u);
        barrier();
        add_scores(job, sin_theta, cos_theta, sums);
        going_on = busy[flag] != 0u;
        if (lane == 0u) busy[flag ^ 1u] = 0u;
        barrier();
    }
    float norm = going_on ? 1.0 : (1.0 - job.g * job.g) / (12.566370614 * float(LANES * job.paths));
    for (uint k = 0u; k < ALBEDOS; ++k)
        for (uint j = 0u; j < 4u; ++j) means[place(index, k, lane, j)] = norm * sums[k][j];
    lanes[index * LANES + lane] = state;
    if (lane == 0u) unfinished[index] = going_on ? 1u : 0u;
}
