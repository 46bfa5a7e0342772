// What both stages of a sweep know: the slices, the medium, the light and its buffer. Positions are world units
// about the volume's centre. Layout: technique/half_angle/layout.rs.
#include "shared/view.glsl"
#include "shared/intersect.glsl"
#include "shared/inside.glsl"
#include "shared/lights.glsl"
#include "shared/transmittance.glsl"
#include "shared/material.glsl"

layout(std140, set = 0, binding = 1) uniform Sweep {
    vec4 table;       // texture value of the first entry, entries a unit of it, entries; w: factor of the albedo
    vec4 dims;        // voxels along x, y, z; w: factor of the emission, 0 where another sweep shows it
    vec4 cell_scale;  // cells a unit of texture coordinate; w: optical depth that ends a ray
    vec4 axis;        // unit vector across the slices, away from the light; w: longest way of one sample
    Light light;
    vec4 light_axis;  // unit vector that light travels along in the middle; w: 1 if only the frustum is lit
    vec4 light_anchor;// a point on that ray near the volume; w: its distance from a point light
    vec4 light_u;     // unit vector along the buffer's rows; w: texels a row
    vec4 light_v;     // along its columns; w: rows
    vec4 light_low;   // xy: the buffer's lower corner; z: size of a texel; w: variance of the spread a length
    vec4 phase;       // x: g; y: g of spread light; z: steps of the phase table; w: mean free path
    vec4 ambient;     // rgb: ambient factor times environment radiance; w: diffuse factor
    vec4 surface;     // x: specular factor; y: its exponent; z: samples of gradient 1 / z are all surface
    vec4 gradient[3]; // world direction of a difference along x, y, z
} sweep;

layout(set = 0, binding = 6) uniform sampler3D albedo_volume;
layout(set = 0, binding = 7, rgba32f) readonly uniform image1D transport;
// Scattered light as a share of the light's irradiance (rgb) and optical depth to the light (a), where light
// enters the slice.
layout(set = 0, binding = 8, rgba32f) readonly uniform image2D current;

layout(push_constant) uniform Push {
    ivec2 first;      // pixel or texel
    ivec2 end;        // beyond the last
    vec2 faces;       // of the slice along the axis
    uint slice;
    uint sub_sample;
} push;

// The blocks' values in registers: lavapipe reads a uniform anew at each use, lane by lane.
vec3 cells;      // a unit of texture coordinate
vec4 axis;
vec2 faces;
vec4 texture_rows[3];

void load_block() {
    table = sweep.table;
    last_voxel = sweep.dims.xyz - 1.0;
    load_material();
    cells = sweep.cell_scale.xyz;
    axis = sweep.axis;
    faces = push.faces;
    for (int i = 0; i < 3; ++i) texture_rows[i] = view.texture_from_world[i];
}

vec3 to_texture(vec3 x) {
    vec4 h = vec4(x, 1.0);
    return vec3(dot(texture_rows[0], h), dot(texture_rows[1], h), dot(texture_rows[2], h));
}

vec3 to_texture_direction(vec3 d) {
    return vec3(dot(texture_rows[0].xyz, d), dot(texture_rows[1].xyz, d), dot(texture_rows[2].xyz, d));
}

// A ray in the world, and in texture coordinates.
struct SliceRay {
    vec3 origin;
    vec3 direction;
    vec3 p;
    vec3 dp;
    float slope; // of the axis along it
};

SliceRay slice_ray(vec3 origin, vec3 direction) {
    return SliceRay(origin, direction, to_texture(origin), to_texture_direction(direction), dot(axis.xyz, direction));
}

// The place of this invocation in the row of places that it goes through, one every 8 places down.
ivec2 place_of(uint row) {
    uvec2 place = gl_WorkGroupID.xy;
    place.y *= ROWS;
    place.y += row;
    return push.first + ivec2(8 * place + gl_LocalInvocationID.xy);
}

// The medium at a place.
struct Sample {
    float sigma_t;
    vec3 color;
    vec3 albedo;
    vec3 dims_light; // share of the extinction that dims scattered light
};

// Whether the cell about a place in texture coordinates is empty.
bool is_empty(vec3 p) {
    return SKIP_EMPTY && distance_at(ivec3(clamp(p * cells, vec3(0.0), last_voxel))) > 0u;
}

// Of extinction, what dims scattered light: the decay of diffuse light far from its source, by the similarity
// of scattering; for even scattering it is that of transport theory to 2.5 % for every albedo.
vec3 decay(vec3 albedo) {
    vec3 a = clamp(albedo, vec3(0.0), vec3(1.0));
    if (ISOTROPIC) return sqrt(1.0 - a * a * a);
    float g = sweep.phase.x;
    vec3 reduced = 1.0 - a * g;
    vec3 similar = a * (1.0 - g) / reduced;
    return min(reduced * sqrt(max(1.0 - similar * similar * similar, 0.0)), 1.0);
}

Sample sample_at(vec3 p) {
    vec3 q = p * (last_voxel + 1.0) - 0.5;
    float value = value_of(q);
    vec4 material = material_of(value, q);
    Sample s;
    s.sigma_t = material.a;
    if (MASKED) s.sigma_t *= finite_weight(q);
    s.color = material.rgb;
    s.albedo = material.rgb;
    if (ALBEDO_VOLUME) s.albedo = textureLod(albedo_volume, texture_of(q), 0.0).rgb;
    s.albedo *= table.w;
    s.dims_light = vec3(1.0);
    if (INDIRECT) {
        if (TRANSPORT_TABLE) {
            float entry = entry_of(value);
            int lo = int(entry);
            int hi = min(lo + 1, int(table.z) - 1);
            s.dims_light = mix(imageLoad(transport, lo).rgb, imageLoad(transport, hi).rgb, entry - float(lo));
        } else {
            s.dims_light = decay(s.albedo);
        }
    }
    return s;
}

// The stretch of a ray from t_min on that lies inside the volume, the clips and the slice.
vec2 in_slice(SliceRay ray, float t_min) {
    vec2 t = clip_to_box(vec2(t_min, 3.0e38), ray.p, ray.dp, vec3(0.0), vec3(1.0));
    if (CLIP_BOX) t = clip_to_box(t, ray.origin, ray.direction, view.clip_min.xyz, view.clip_max.xyz);
    if (CLIP_PLANE) t = clip_to_half_space(t, ray.origin, ray.direction, view.clip_plane);
    float slope = ray.slope < 0.0 ? min(ray.slope, -1e-7) : max(ray.slope, 1e-7);
    vec2 planes = (faces - dot(axis.xyz, ray.origin)) / slope;
    return vec2(max(t.x, min(planes.x, planes.y)), min(t.y, max(planes.x, planes.y)));
}
