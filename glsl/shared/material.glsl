// The medium's material at a place. The includer defines MATERIAL, the first of the bindings below, and the
// constant MASKED, includes shared/medium_filtered.glsl or shared/medium_loaded.glsl before, sets `table` and
// `last_voxel`, and calls load_material().
layout(constant_id = 32) const bool GRADIENTS = false; // gradients decide beside values

layout(set = 0, binding = 5) uniform sampler3D finite_mask;

layout(std140, set = 0, binding = MATERIAL) uniform Material {
    vec4 gradient[3]; // data units a world unit, along the world's axes, of a difference of a texture value a voxel;
                      // w of the first: entries along gradients; of the second: their square a unit of gradient
} material;
// Colour and extinction over values and gradients.
layout(set = 0, binding = MATERIAL + 1) uniform sampler2D gradient_table;

// In registers: lavapipe reads a uniform anew at each use, lane by lane.
vec4 table;      // texture value of the first entry, entries a unit of it, entries; w is the includer's
vec3 last_voxel; // largest grid coordinates
mat3 gradient_from_difference;
vec2 gradient_entries;

void load_material() {
    if (GRADIENTS) {
        gradient_from_difference =
            mat3(material.gradient[0].xyz, material.gradient[1].xyz, material.gradient[2].xyz);
        gradient_entries = vec2(material.gradient[0].w, material.gradient[1].w);
    }
}

// Where the transfer function's table has a texture value.
float entry_of(float value) {
    return clamp((value - table.x) * table.y, 0.0, table.z - 1.0);
}

// Differences between one voxel ahead and one behind q along x, y, z, both clamped at the faces.
vec3 differences_at(vec3 q) {
    return value_differences(q, last_voxel);
}

// Magnitude of the gradient, data units a world unit; at the faces to one side.
float gradient_at(vec3 q) {
    vec3 at = clamp(q, vec3(0.0), last_voxel);
    vec3 across = min(at + 1.0, last_voxel) - max(at - 1.0, vec3(0.0));
    return length(gradient_from_difference * (value_differences(q, last_voxel) / max(across, 1e-6)));
}

// Between the entries of the table over values and gradients.
vec4 gradient_table_at(float entry, vec3 q) {
    float row = min(sqrt(gradient_at(q) * gradient_entries.y), gradient_entries.x - 1.0);
    return textureLod(gradient_table, (vec2(entry, row) + 0.5) / vec2(table.z, gradient_entries.x), 0.0);
}

// Colour (rgb) and extinction (a) at q, where the volume has this texture value.
vec4 material_of(float value, vec3 q) {
    float entry = entry_of(value);
    vec4 found = table_at(entry, table.z);
    // This was the most that any gradient makes of the value. A branch, though software drivers go through those that
    // no lane takes: the rounds of a loop count, and rays have few to spare.
    if (GRADIENTS && found.a > 0.0) found = gradient_table_at(entry, q);
    return found;
}

// Extinction alone.
float extinction_of(float value, vec3 q) {
    float entry = entry_of(value);
    float found = extinction_at(entry, table.z);
    if (GRADIENTS && found > 0.0) found = gradient_table_at(entry, q).a;
    return found;
}

bool has_holes(vec3 q) {
    return textureLod(finite_mask, (q + 0.5) / (last_voxel + 1.0), 0.0).r < 0.999;
}

// 1 only where no voxel that the sample is made of is NaN or infinite.
float finite_weight(vec3 q) {
    bool holes = has_holes(q);
    if (GRADIENTS) {
        vec3 behind = max(q - 1.0, vec3(0.0)), ahead = min(q + 1.0, last_voxel);
        for (int axis = 0; axis < 3; ++axis) {
            vec3 to = q;
            to[axis] = behind[axis];
            holes = holes || has_holes(to);
            to[axis] = ahead[axis];
            holes = holes || has_holes(to);
        }
    }
    return holes ? 0.0 : 1.0;
}
