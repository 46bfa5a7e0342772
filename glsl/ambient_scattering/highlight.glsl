// Highlights where the gradient mirrors a light [Levoy1988]: specular E / pi max(0, n.h)^shininess, as those of
// ray_march, in the light that arrives straight from the source.

// Shares of light below this are not looked at for highlights.
const float FAINT = 2e-3;

// Of a block, at the sample that weighs most.
vec3 highlight(Block block, ViewRay ray, int i) {
    float sum = 0.0, most = -1.0, at = 0.0;
    for (int k = 0; k < BLOCK; ++k) {
        float weight = seen(block, k);
        sum += weight;
        if (weight > most) at = float(i + k);
        most = max(most, weight);
    }
    vec3 radiance = vec3(0.0);
    // A loop, not a branch: software drivers go through branches that no lane takes.
    uint count = sum > FAINT ? LIGHT_COUNT : 0;
    vec3 n = vec3(0.0);
    vec3 x = ray.x_first + at * ray.dt * ray.direction;
    vec3 q = ray.grid.first + at * ray.grid.per_step;
    for (uint l = 0; l < count; ++l) {
        if (l == 0) {
            vec3 d = differences_at(q);
            n = vec3(dot(ambient.gradient[0].xyz, d), dot(ambient.gradient[1].xyz, d),
                     dot(ambient.gradient[2].xyz, d));
            // No direction can be told below 1e-15 of the data range a voxel.
            n *= inversesqrt(max(dot(n, n), 1e-30));
            // The side that faces the viewer is lit.
            n = dot(n, ray.direction) > 0.0 ? -n : n;
        }
        Light light = lights[l];
        vec3 w_i = light.place.xyz;
        vec3 irradiance = light.irradiance.rgb;
        if (POINT_LIGHTS && light.place.w > 0.0) {
            w_i -= x;
            float d = max(length(w_i), 1e-30);
            w_i /= d;
            if (light.irradiance.w > 0.0) irradiance = irradiance / d / d;
        }
        float cos_h = max(dot(n, normalize(w_i - ray.direction)), 0.0);
        float shine = dot(n, w_i) > 0.0 ? ambient.specular.x * pow(cos_h, ambient.specular.y) : 0.0;
        radiance += light_at(x, q, l).a * INV_PI * shine * irradiance;
    }
    return sum * radiance;
}
