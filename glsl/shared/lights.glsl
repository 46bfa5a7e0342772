// Directional and point lights, as technique/lights.rs writes them.
const uint MAX_LIGHTS = 32;

struct Light {
    vec4 place;      // xyz: unit vector towards a directional light (w = 0), or position (w > 0)
    vec4 irradiance; // rgb: of a directional light, or intensity; w: 1 weakens with distance squared
};
