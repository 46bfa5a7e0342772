// The walk, whatever the medium is read through: shared/medium_filtered.glsl or
// shared/medium_loaded.glsl.
layout(local_size_x = 64) in;

layout(constant_id = 0) const bool MASKED = false;
layout(constant_id = 1) const bool CLIP_BOX = false;
layout(constant_id = 2) const bool CLIP_PLANE = false;
layout(constant_id = 3) const uint LIGHT_COUNT = 0;
layout(constant_id = 4) const bool POINT_LIGHTS = false;
layout(constant_id = 5) const uint MAX_SCATTER = 0; // 0: no limit
layout(constant_id = 6) const uint SPREAD = 1;
layout(constant_id = 7) const uint CELL = 0; // voxels along a cell's edge; 0: the volume is one leaf
layout(constant_id = 8) const bool STRAIGHT = false; // extinction is linear in the value, one colour
layout(constant_id = 9) const uint SOURCES = 0; // lights that are looked for: LIGHT_COUNT and the map
layout(constant_id = 10) const bool ENVIRONMENT_MAP = false;
layout(constant_id = 11) const bool ALBEDO_VOLUME = false;

#include "shared/view.glsl"
#include "shared/intersect.glsl"
#include "shared/lights.glsl"
#include "shared/phase.glsl"
#include "shared/random.glsl"
#include "shared/transmittance.glsl"

layout(std140, set = 0, binding = 1) uniform Trace {
    vec4 table;       // texture value of the first entry, entries a unit of it, entries, unused
    vec4 dims;        // voxels along x, y, z; w: albedo
    vec4 bounds;      // largest and smallest extinction anywhere, g, emission
    vec4 straight;    // rgb: the one colour; w: unused
    vec4 line;        // extinction of the first entry, its change a unit of texture value
    vec4 environment; // rgb: radiance from every direction
    vec4 grid_from_world[3];
    vec4 map_from_world[3]; // w of the first two: width and height of the environment map
    vec4 map_scale;         // rgb: factor on its radiance
    Light lights[MAX_LIGHTS];
} trace;

layout(set = 0, binding = 6, rgba32f) uniform image2D radiance;  // mean of the samples
layout(set = 0, binding = 7, rgba32f) uniform image2D moments;   // rgb: their squared deviations
layout(set = 0, binding = 8, rgba32ui) uniform uimage3D walkers; // one layer a vector of Walker
layout(set = 0, binding = 9, r32ui) uniform uimage2D counters;   // unfinished pixels, samples
// Largest extinction, its four last bits replaced by the leaf's size as a power of two; smallest.
layout(set = 0, binding = 4, rg32ui) readonly uniform uimage3D leaves;

layout(set = 0, binding = 10) uniform sampler3D albedo_volume;

layout(push_constant) uniform Push {
    uint rounds;  // an invocation's scattering events, at most
    uint samples; // to reach
    uint seed;
    uint first;   // 1: walkers hold nothing yet
} push;

#define MATERIAL 13
#include "shared/material.glsl"
#include "path_trace/walker.glsl"
#include "path_trace/flight.glsl"
#include "path_trace/light.glsl"

// A collision with the medium. Returns whether the path goes on, in a new direction.
bool scatter(inout Walker p, Flight flight) {
    vec4 u = uniforms(p);
    if (p.met == 0.0) p.met = p.throughput.x;
    vec3 q = flight.q + p.t * flight.dq;
    vec3 color = color_of(flight.value, q);
    p.gathered += p.throughput * emission * color;
    p.throughput *= albedo * (ALBEDO_VOLUME ? textureLod(albedo_volume, texture_of(q), 0.0).rgb : color);
    float brightest = max(p.throughput.r, max(p.throughput.g, p.throughput.b));
    // Below a quarter of their first weight paths end by chance, the others carry on for them.
    float survival = min(4.0 * brightest / p.met, 1.0);
    uint events = p.state >> 2;
    if (u.x >= survival || (MAX_SCATTER != 0 && events >= MAX_SCATTER)) return false;
    p.throughput /= survival;
    p.state = (events + 1) << 2 | WALK;
    p.x += p.t * p.d;
    p.next = turn(p.d, sample_hg(u.y, bounds.z), u.z);
    p.density = phase_hg(dot(p.d, p.next), bounds.z);
    if (SOURCES != 0) look_at_light(p, u.w);
    else p.d = p.next;
    set_out(p);
    return true;
}

// Sends a path to a tentative collision for certain, with the weight of its chance: in a thin medium
// nearly every path would get through, and tell nothing.
void collide(inout Walker p, float u) {
    float tau = bounds.x * max(p.t_end, 0.0);
    float chance = absorbed(1.0, exp(-tau), tau);
    float x = u * chance;
    // -log(1 - x), whose difference would round a thin medium's depths.
    float drawn = x < 0.01 ? x + x * x * (0.5 + x / 3.0) : -log(1.0 - x);
    p.tau_left = min(drawn, tau);
    p.gathered = (1.0 - chance) * background;
    p.throughput = vec3(chance);
}

// A path's first ray, through a uniform place in the pixel. Returns whether it misses the medium.
bool start(inout Walker p, CameraRays rays, uvec2 pixel) {
    vec4 u = uniforms(p);
    Ray ray = ray_at(rays, vec2(pixel) + u.xy);
    vec2 t = inside(ray);
    p.x = ray.origin + t.x * ray.direction;
    p.d = ray.direction;
    p.t = 0.0;
    p.t_end = t.y - t.x;
    p.tau_left = -log(1.0 - u.z);
    p.state = WALK;
    p.throughput = vec3(1.0);
    p.gathered = vec3(0.0);
    p.met = 0.0;
    if (CELL == 0) collide(p, u.z);
    return t.x >= t.y;
}

vec4 mean;
vec4 squares;

// Running mean and squared deviations [Welford1962].
void finish(inout Walker p, vec3 beyond) {
    p.count += 1;
    vec4 value = vec4(p.gathered + p.throughput * beyond, p.met);
    vec4 change = value - mean;
    mean += change / float(p.count);
    squares += change * (value - mean);
    p.step = 0;
    p.state = START;
}

// One scattering event of the pixel's path, from its flight to the light it gathers.
void advance(inout Walker p, CameraRays rays, uvec2 pixel) {
    for (uint i = 0; i < MISSES && p.state == START && p.count < push.samples; ++i) {
        if (start(p, rays, pixel)) {
            p.gathered = background;
            finish(p, vec3(0.0));
        }
    }
    Flight flight = flight_of(p);
    uint outcome = (p.state & 3u) == WALK ? ON_THE_WAY : ARRIVED;
    for (uint i = 0; i < STRETCHES && outcome == ON_THE_WAY; ++i) outcome = stretch(p, flight, false);
    if ((p.state & 3u) == WALK && outcome != ON_THE_WAY) {
        if (outcome == ARRIVED) finish(p, p.met > 0.0 ? met_environment(p) : background);
        else if (!scatter(p, flight)) finish(p, vec3(0.0));
    }
    if (SOURCES != 0) {
        flight = flight_of(p);
        outcome = (p.state & 3u) == SHADOW ? ON_THE_WAY : COLLIDED;
        for (uint i = 0; i < STRETCHES && outcome == ON_THE_WAY; ++i) outcome = stretch(p, flight, true);
        if (outcome == ARRIVED) {
            p.gathered += exp(-p.tau) * p.transmittance * p.light;
            p.d = p.next;
            p.t_end = FAR;
            p.state = (p.state & ~3u) | WALK;
            set_out(p);
        }
    }
}

void main() {
    uint tiles_x = (view.image.x + 7) / 8;
    uint tiles = tiles_x * ((view.image.y + 7) / 8);
    // Tiles are dealt out to SPREAD streams, one for each thread of a software driver.
    uint streams = (tiles + SPREAD - 1) / SPREAD;
    uint tile = (gl_WorkGroupID.x % streams) * SPREAD + gl_WorkGroupID.x / streams;
    uvec2 in_tile = uvec2(gl_LocalInvocationIndex & 7, gl_LocalInvocationIndex >> 3);
    uvec2 pixel = uvec2(tile % tiles_x, tile / tiles_x) * 8 + in_tile;
    if (tile >= tiles || any(greaterThanEqual(pixel, view.image.xy))) return;

    load_block();
    CameraRays rays = camera_rays();
    Walker p = restore(ivec2(pixel));
    p.index = pixel.y * view.image.x + pixel.x;
    mean = push.first > 0 ? vec4(0.0) : imageLoad(radiance, ivec2(pixel));
    squares = push.first > 0 ? vec4(0.0) : imageLoad(moments, ivec2(pixel));
    uint before = p.count;
    for (uint i = 0; i < push.rounds && p.count < push.samples; ++i) advance(p, rays, pixel);
    store(ivec2(pixel), p);
    imageStore(radiance, ivec2(pixel), mean);
    imageStore(moments, ivec2(pixel), squares);
    if (p.count < push.samples) imageAtomicAdd(counters, ivec2(0, 0), 1u);
    imageAtomicAdd(counters, ivec2(1, 0), p.count - before);
}
