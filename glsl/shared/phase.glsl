// The Henyey-Greenstein phase function [Henyey1941]; cos_theta = 1 is straight on, g > 0 forward.

// Per steradian; its integral over the sphere is 1.
float phase_hg(float cos_theta, float g) {
    // 1 + g^2 - 2 g cos_theta without cancellation where g is near 1 or -1.
    float near = 1.0 - abs(g);
    float d = near * near + 2.0 * abs(g) * max(1.0 - (g < 0.0 ? -cos_theta : cos_theta), 0.0);
    return (1.0 - g * g) / (12.566370614 * d * sqrt(d));
}

// The cosine of a direction drawn from it by a uniform u in [0, 1).
float sample_hg(float u, float g) {
    if (abs(g) < 1e-3) return 1.0 - 2.0 * u;
    float s = (1.0 - g * g) / (1.0 - g + 2.0 * g * u);
    return clamp((1.0 + g * g - s * s) / (2.0 * g), -1.0, 1.0);
}

// The direction at angle acos(cos_theta) from w, turned about it by 2 pi u; without branches [Duff2017].
vec3 turn(vec3 w, float cos_theta, float u) {
    float s = w.z < 0.0 ? -1.0 : 1.0;
    float a = -1.0 / (s + w.z);
    float b = w.x * w.y * a;
    vec3 x = vec3(1.0 + s * w.x * w.x * a, s * b, -s * w.x);
    vec3 y = vec3(b, s + w.y * w.y * a, -w.y);
    float sin_theta = sqrt(max(0.0, 1.0 - cos_theta * cos_theta));
    float phi = 6.283185307 * u;
    return normalize(sin_theta * (cos(phi) * x + sin(phi) * y) + cos_theta * w);
}
