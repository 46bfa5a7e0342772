// Surfaces: Blinn-Phong by the data's gradient, alone or mixed with the phase function.
const float INV_PI = 0.318309886;

// Central differences one voxel to either side (clamped at the faces), turned into a world-space direction; its
// length is relative to the data range a voxel.
vec3 world_gradient(vec3 p) {
    mat3 world_from_difference = mat3(sweep.gradient[0].xyz, sweep.gradient[1].xyz, sweep.gradient[2].xyz);
    return world_from_difference * differences_at(p * (last_voxel + 1.0) - 0.5);
}

// Reflected radiance of a surface over irradiance; on the side that faces the viewer.
vec3 blinn_phong(vec3 gradient, vec3 w_i, vec3 w_o, float diffuse, vec3 color) {
    // No direction can be told below 1e-15 of the data range a voxel.
    vec3 n = gradient * inversesqrt(max(dot(gradient, gradient), 1e-30));
    n = dot(n, w_o) < 0.0 ? -n : n;
    float cos_i = max(dot(n, w_i), 0.0);
    float cos_h = max(dot(n, normalize(w_i + w_o)), 0.0);
    float highlight = cos_i > 0.0 ? sweep.surface.x * pow(cos_h, sweep.surface.y) : 0.0;
    return INV_PI * (diffuse * cos_i * color + highlight);
}

// Radiance that a sample scatters of unit irradiance: C(s) of [Kniss2003, Eq. 11] with the phase function.
vec3 reflected(vec3 p, vec3 w_i, vec3 direction, Sample m, vec3 phase) {
    vec3 scattered = m.albedo * phase;
    if (SURFACE) {
        vec3 gradient = world_gradient(p);
        float surface = min(length(gradient) * sweep.surface.z, 1.0);
        scattered = mix(scattered, blinn_phong(gradient, w_i, -direction, 1.0, m.albedo), surface);
    }
    return scattered;
}

// Gradient shading without shadows, as that of ray_march.
vec3 shaded(vec3 x, vec3 p, vec3 direction, vec3 color) {
    vec3 w_i = sweep.light.place.xyz;
    vec3 irradiance = sweep.light.irradiance.rgb;
    if (POINT_LIGHTS && sweep.light.place.w > 0.0) {
        w_i -= x;
        float d = max(length(w_i), 1e-30);
        w_i /= d;
        if (sweep.light.irradiance.w > 0.0) irradiance = irradiance / d / d;
    }
    vec3 lit = irradiance * blinn_phong(world_gradient(p), w_i, -direction, sweep.ambient.w, color);
    return sweep.ambient.rgb * color + lit;
}
