// Shading of a slice, whatever the medium is read through: shared/medium_filtered.glsl or
// shared/medium_loaded.glsl.
layout(local_size_x = 8, local_size_y = 8) in;

layout(constant_id = 0) const bool SKIP_EMPTY = false;
layout(constant_id = 1) const bool MASKED = false;
layout(constant_id = 2) const bool CLIP_BOX = false;
layout(constant_id = 3) const bool CLIP_PLANE = false;
layout(constant_id = 4) const bool POINT_LIGHTS = false;
layout(constant_id = 5) const bool INDIRECT = false;
layout(constant_id = 6) const bool ISOTROPIC = false;
layout(constant_id = 7) const bool ALBEDO_VOLUME = false;
layout(constant_id = 8) const bool TRANSPORT_TABLE = false;
layout(constant_id = 9) const bool LIT = false;
layout(constant_id = 10) const bool EMISSION = false;
layout(constant_id = 11) const bool PARTS = false;
layout(constant_id = 12) const bool PHASE_TABLE = false;
layout(constant_id = 13) const bool SURFACE = false;
layout(constant_id = 14) const bool SHADE = false;
layout(constant_id = 15) const uint ROWS = 1;

#define MATERIAL 11
#include "half_angle/sweep.glsl"
#include "half_angle/light.glsl"
#include "half_angle/surface.glsl"

// Radiance of what was seen so far (rgb), and its optical depth (a).
layout(set = 0, binding = 9, rgba32f) uniform image2D eye;

// A stretch of a ray with one sample in its middle.
struct Stretch {
    SliceRay ray;
    vec2 t;
    float tau; // optical depth before it
};

// Light that it scatters towards the viewer: of the way to the viewer and that to the light, the depth rises
// evenly, which is exact in a homogeneous medium at any thickness.
vec3 scattered(Stretch s, Sample m, vec2 lit) {
    float dt = lit.y - lit.x;
    SliceRay ray = s.ray;
    vec3 near = ray.origin + lit.x * ray.direction, far = ray.origin + lit.y * ray.direction;
    vec3 x = 0.5 * (near + far);
    vec3 w_i = towards_light(x);
    Arriving arriving = arriving_at(x, far - near);
    vec2 way = vec2(way_in_slice(near, ray.p + lit.x * ray.dp, w_i), way_in_slice(far, ray.p + lit.y * ray.dp, w_i));
    way *= m.sigma_t;
    vec2 tau = s.tau + m.sigma_t * (lit - s.t.x);
    float dtau = m.sigma_t * dt;
    float before = exp(-(tau.x + arriving.light.a + way.x - arriving.rise));
    float after = exp(-(tau.y + arriving.light.a + way.y + arriving.rise));
    float direct = dtau * mean_between(before, after, dtau + way.y - way.x + 2.0 * arriving.rise);
    float cos_theta = dot(w_i, ray.direction);
    vec3 gathered = direct * reflected(ray.p + 0.5 * (lit.x + lit.y) * ray.dp, w_i, ray.direction, m, phase(cos_theta));
    if (INDIRECT) {
        // Direct and scattered light together fade as scattered light does [Kniss2003, Eq. 12].
        vec3 arrived = arriving.light.rgb + exp(-arriving.light.a);
        // At no end more than the light brings.
        vec3 most = max(-log(max(arrived, 1e-30)), 0.0);
        vec3 lift = clamp(m.dims_light * arriving.rise, -most, most);
        vec3 rise = dtau + m.dims_light * (way.y - way.x) + 2.0 * lift;
        vec3 all_before = exp(-(tau.x + m.dims_light * way.x - lift));
        vec3 all_after = exp(-(tau.y + m.dims_light * way.y + lift));
        vec3 all = vec3(mean_between(all_before.r, all_after.r, rise.r),
                        mean_between(all_before.g, all_after.g, rise.g),
                        mean_between(all_before.b, all_after.b, rise.b));
        all *= dtau * arrived;
        gathered += m.albedo * spread_phase(cos_theta) * max(all - direct, 0.0);
    }
    float falloff = 1.0;
    if (POINT_LIGHTS && lamp.place.w > 0.0 && lamp.irradiance.w > 0.0) {
        falloff = mean_falloff(lamp.place.xyz, x, ray.direction, dt);
    }
    return falloff * lamp.irradiance.rgb * gathered;
}

// Radiance of the stretch towards the viewer, dimmed by what is before it.
vec3 radiance_of(Stretch s, Sample m, vec3 p) {
    vec3 sum = vec3(0.0);
    float dtau = m.sigma_t * (s.t.y - s.t.x);
    if (EMISSION) sum += sweep.dims.w * absorbed(exp(-s.tau), exp(-(s.tau + dtau)), dtau) * m.color;
    if (SHADE) {
        float weight = absorbed(exp(-s.tau), exp(-(s.tau + dtau)), dtau);
        vec3 x = s.ray.origin + 0.5 * (s.t.x + s.t.y) * s.ray.direction;
        sum += weight * shaded(x, p, s.ray.direction, m.color);
    }
    if (LIT) {
        vec2 lit = s.t;
        if (PARTS && lamp_axis.w > 0.0) lit = in_frustum(lit, s.ray.origin, s.ray.direction);
        int is_lit = lit.x < lit.y && m.sigma_t > 0.0 ? 1 : 0;
        // A loop, not a branch: software drivers go through branches that no lane takes.
        for (int i = 0; i < is_lit; ++i) sum += scattered(s, m, lit);
    }
    return sum;
}

// Shades a pixel's part of the slice.
void shade_pixel(ivec2 pixel, CameraRays rays, vec2 in_pixel, float tau_end) {
    bool is_there = all(lessThan(pixel, push.end));
    Ray camera = ray_at(rays, vec2(pixel) + in_pixel);
    SliceRay ray = slice_ray(camera.origin, camera.direction);
    vec2 t = in_slice(ray, camera.t_min);
    vec4 seen = imageLoad(eye, min(pixel, push.end - 1));
    // Slices come nearer to the viewer or go away from him, on each ray apart.
    bool onward = ray.slope > 0.0;
    bool hidden = onward && seen.a >= tau_end;
    // Rays along the slices have long ways in each.
    int count = is_there && t.x < t.y && !hidden ? steps_along(t.y - t.x, axis.w) : 0;
    float dt = (t.y - t.x) / float(max(count, 1));
    float before = onward ? seen.a : 0.0;
    float tau = before;
    vec3 radiance = vec3(0.0);
    for (int i = 0; i < count; ++i) {
        vec2 stretch = t.x + vec2(float(i), float(i + 1)) * dt;
        vec3 p = ray.p + 0.5 * (stretch.x + stretch.y) * ray.dp;
        int occupied = is_empty(p) ? 0 : 1;
        for (int once = 0; once < occupied; ++once) {
            Sample m = sample_at(p);
            radiance += radiance_of(Stretch(ray, stretch, tau), m, p);
            tau += m.sigma_t * dt;
        }
    }
    float dtau = tau - before;
    seen.rgb = (onward ? seen.rgb : seen.rgb * exp(-dtau)) + radiance;
    seen.a = onward ? tau : seen.a + dtau;
    if (count > 0) imageStore(eye, pixel, seen);
}

void main() {
    load_block();
    if (LIT) load_light();
    CameraRays rays = camera_rays();
    uint n = rays.samples;
    vec2 in_pixel = (vec2(push.sub_sample % n, push.sub_sample / n) + 0.5) / float(n);
    float tau_end = sweep.cell_scale.w;
    for (uint row = 0; row < ROWS; ++row) shade_pixel(place_of(row), rays, in_pixel, tau_end);
}
