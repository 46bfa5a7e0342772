// Directional and point lights, as technique/lights.rs writes them.
const uint MAX_LIGHTS = 32;

struct Light {
    vec4 place;      // xyz: unit vector towards a directional light (w = 0), or position (w > 0)
    vec4 irradiance; // rgb: of a directional light, or intensity; w: 1 weakens with distance squared
};

// Mean of 1 / d^2 to `p` over a step of length dt about x, along `direction`: a light that a ray nearly
// meets is not missed by the samples.
float mean_falloff(vec3 p, vec3 x, vec3 direction, float dt) {
    float s = dot(x - p, direction);
    vec3 beside = x - p - s * direction;
    float h2 = max(dot(beside, beside), 1e-12 * dt * dt);
    float a = s - 0.5 * dt, b = s + 0.5 * dt;
    // The integral is (atan(b / h) - atan(a / h)) / h.
    float h = sqrt(h2);
    float tangent = h * dt / (h2 + a * b);
    float t2 = tangent * tangent;
    bool distant = h2 + a * b > 0.0 && abs(tangent) < 0.1;
    float near = atan(h * dt, h2 + a * b) / (h * dt);
    return distant ? (1.0 - t2 * (1.0 / 3.0 - t2 * 0.2)) / (h2 + a * b) : near;
}
