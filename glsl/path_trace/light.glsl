// Light that a path looks for, and how it weighs against light that it meets by chance.

layout(set = 0, binding = 11) uniform sampler2D environment_map; // radiance, unscaled
// One texel a cell of the map. x: chance to keep the cell, y: the cell taken instead, z: density, per
// steradian, of directions drawn from it, times the sine of the angle from the pole
layout(set = 0, binding = 12) uniform sampler2D environment_alias;

vec3 to_map(vec3 d) {
    return vec3(dot(map_x, d), dot(map_y, d), dot(map_z, d));
}

// Place on the map, in [0, 1), of a direction in map space: the top is +y, u grows from -z towards +x.
vec2 map_place(vec3 d) {
    float u = atan(d.x, -d.z) * 0.15915494;
    float v = atan(length(d.xz), d.y) * 0.31830989;
    return vec2(u < 0.0 ? u + 1.0 : u, v);
}

vec3 map_texel(ivec2 at) {
    at.x += at.x < 0 ? map_size.x : (at.x >= map_size.x ? -map_size.x : 0);
    return texelFetch(environment_map, ivec2(at.x, clamp(at.y, 0, map_size.y - 1)), 0).rgb;
}

vec3 map_radiance(vec2 place) {
    vec2 at = place * vec2(map_size) - 0.5;
    ivec2 lo = ivec2(floor(at));
    vec2 f = at - vec2(lo);
    return map_scale * mix(mix(map_texel(lo), map_texel(lo + ivec2(1, 0)), f.x),
                           mix(map_texel(lo + ivec2(0, 1)), map_texel(lo + ivec2(1, 1)), f.x), f.y);
}

// Density, per steradian, with which look_at_map draws a direction.
float map_density(vec3 d, vec2 place) {
    ivec2 cells = textureSize(environment_alias, 0);
    ivec2 cell = min(ivec2(place * vec2(cells)), cells - 1);
    return texelFetch(environment_alias, cell, 0).z / max(length(d.xz), 1e-6);
}

// Radiance of the environments that a path meets after scattering. Where it may have been looked for
// too, both ways share it by the balance heuristic [Veach1995].
vec3 met_environment(Walker p) {
    vec3 met = environment;
    if (ENVIRONMENT_MAP) {
        vec3 d = to_map(p.d);
        vec2 place = map_place(d);
        float looked_for = map_density(d, place) / float(SOURCES);
        met += map_radiance(place) * p.density / (p.density + looked_for);
    }
    return met;
}

// A direction towards the map's light; its radiance into p.light, shared with met_environment.
void look_at_map(inout Walker p) {
    vec4 u = uniforms(p);
    ivec2 cells = textureSize(environment_alias, 0);
    int count = cells.x * cells.y;
    int cell = min(int(u.x * float(count)), count - 1);
    vec2 alias = texelFetch(environment_alias, ivec2(cell % cells.x, cell / cells.x), 0).xy;
    if (u.y >= alias.x) cell = int(alias.y);
    vec2 place = (vec2(cell % cells.x, cell / cells.x) + u.zw) / vec2(cells);
    vec2 angle = place * vec2(6.283185307, 3.141592654);
    vec3 d = vec3(sin(angle.y) * sin(angle.x), cos(angle.y), -sin(angle.y) * cos(angle.x));
    vec3 w_i = normalize(d.x * map_x + d.y * map_y + d.z * map_z);
    float looked_for = map_density(d, place) / float(SOURCES);
    float phase = phase_hg(dot(p.d, w_i), bounds.z);
    p.light = p.throughput * map_radiance(place) * phase / (looked_for + phase);
    p.d = w_i;
    p.t_end = FAR;
}

void look_at_lamp(inout Walker p, uint index) {
    Light light = lights[index];
    vec3 w_i = light.place.xyz;
    vec3 irradiance = light.irradiance.rgb;
    p.t_end = FAR;
    if (POINT_LIGHTS && light.place.w > 0.0) {
        w_i -= p.x;
        float far = max(length(w_i), 1e-30);
        w_i /= far;
        p.t_end = far;
        if (light.irradiance.w > 0.0) irradiance = irradiance / far / far;
    }
    p.light = float(SOURCES) * p.throughput * irradiance * phase_hg(dot(p.d, w_i), bounds.z);
    p.d = w_i;
}

// Sends a shadow ray to one of the sources that can be looked for, all being equally likely.
void look_at_light(inout Walker p, float u) {
    uint index = min(uint(u * float(SOURCES)), SOURCES - 1);
    if (ENVIRONMENT_MAP && index == LIGHT_COUNT) look_at_map(p);
    else look_at_lamp(p, index);
    p.state = (p.state & ~3u) | SHADOW;
}
