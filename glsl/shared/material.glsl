// The medium's material at a place. The includer defines MATERIAL, the first of the bindings below, and the
// constant MASKED, includes shared/medium_filtered.glsl or shared/medium_loaded.glsl before, sets `table` and
// `last_voxel`, and calls load_material().
layout(constant_id = 32) const bool GRADIENTS = false; // gradients decide beside values
layout(constant_id = 33) const uint DISPLACED = 0;     // octaves of noise that move places
layout(constant_id = 34) const uint VARIED = 0;        // octaves that vary extinction and colour
layout(constant_id = 35) const bool HEIGHT_FIELD = false; // one layer of voxels holds for every height

const uint MAX_OCTAVES = 8;

layout(set = 0, binding = 5) uniform sampler3D finite_mask;

layout(std140, set = 0, binding = MATERIAL) uniform Material {
    vec4 gradient[3]; // data units a world unit, along the world's axes, of a difference of a texture value a voxel;
                      // w of the first: entries along gradients; of the second: their square a unit of gradient
    vec4 world_from_grid[3];        // rows of the affine map to world units about the volume's centre
    vec4 grid_from_world[3];        // rows of the linear map back; w unused
    vec4 displacing[MAX_OCTAVES];   // xyz: coordinates of the noise at the volume's centre; w: tiles a world unit
    vec4 displacement[MAX_OCTAVES]; // x: furthest along each axis, world units; yzw unused
    vec4 varying_at[MAX_OCTAVES];   // as displacing
    vec4 variation[MAX_OCTAVES];    // largest share by which colours are darker (rgb), extinction is other (a)
    vec4 layer;                     // x: lower face, y: upper face, voxels above the surface; z: ramps a voxel; w unused
} material;
// Colour and extinction over values and gradients.
layout(set = 0, binding = MATERIAL + 1) uniform sampler2D gradient_table;
// Four components in [0, 1], of one tile that repeats.
layout(set = 0, binding = MATERIAL + 2) uniform sampler3D noise;
// Of a height field's surface over every column of voxels, grid coordinates.
layout(set = 0, binding = MATERIAL + 3) uniform sampler2D surface_heights;

// In registers: lavapipe reads a uniform anew at each use, lane by lane.
vec4 table;      // texture value of the first entry, entries a unit of it, entries; w is the includer's
vec3 last_voxel; // largest grid coordinates
vec3 last_stored; // of voxels in memory
vec3 layer;
mat3 gradient_from_difference;
vec2 gradient_entries;
vec4 world_x, world_y, world_z;
mat3 grid_from_world;
vec4 displacing[DISPLACED + 1];
float displacement[DISPLACED + 1];
vec4 vary_at[VARIED + 1];
vec4 variation[VARIED + 1];

void load_material() {
    last_stored = last_voxel;
    if (HEIGHT_FIELD) {
        last_stored.z = 0.0;
        layer = material.layer.xyz;
    }
    // Not read where there is no noise.
    world_x = material.world_from_grid[0];
    world_y = material.world_from_grid[1];
    world_z = material.world_from_grid[2];
    if (DISPLACED != 0) {
        grid_from_world = transpose(mat3(material.grid_from_world[0].xyz, material.grid_from_world[1].xyz,
                                         material.grid_from_world[2].xyz));
    }
    for (uint i = 0; i < DISPLACED; ++i) {
        displacing[i] = material.displacing[i];
        displacement[i] = material.displacement[i].x;
    }
    for (uint i = 0; i < VARIED; ++i) {
        vary_at[i] = material.varying_at[i];
        variation[i] = material.variation[i];
    }
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

vec3 about_centre(vec3 q) {
    vec4 h = vec4(q, 1.0);
    return vec3(dot(world_x, h), dot(world_y, h), dot(world_z, h));
}

// Where the medium at q is looked up in the volume.
vec3 looked_up(vec3 q) {
    if (DISPLACED != 0) {
        vec3 x = about_centre(q), moved = vec3(0.0);
        for (uint i = 0; i < DISPLACED; ++i) {
            vec3 at = x * displacing[i].w + displacing[i].xyz;
            moved += displacement[i] * (2.0 * textureLod(noise, at, 0.0).rgb - 1.0);
        }
        q += grid_from_world * moved;
        // The surface is where it is, above and below the box too.
        if (HEIGHT_FIELD) q.xy = clamp(q.xy, vec2(0.0), last_voxel.xy);
        else q = clamp(q, vec3(0.0), last_voxel);
    }
    return q;
}

// Texture coordinates of the place where the medium at q is looked up.
vec3 texture_of(vec3 q) {
    return (looked_up(q) + 0.5) / (last_voxel + 1.0);
}

// Distance above a height field's surface, voxels, of a place that is looked up.
float above_surface(vec3 q) {
    return q.z - textureLod(surface_heights, (q.xy + 0.5) / (last_voxel.xy + 1.0), 0.0).r;
}

// Share of the material's extinction at q: 1 but for height fields, which taper off at their faces
// [Kniss2003, III.D].
float share_at(vec3 q) {
    float above = above_surface(looked_up(q));
    return clamp(min(above - layer.x, layer.y - above) * layer.z, 0.0, 1.0);
}

// The texture value at q.
float value_of(vec3 q) {
    return value_at(looked_up(q), last_stored);
}

// The texture value of a voxel's centre.
float value_of_voxel(ivec3 voxel) {
    float value;
    if (DISPLACED != 0) value = value_of(vec3(voxel));
    else value = texel(voxel.x, voxel.y, HEIGHT_FIELD ? 0 : voxel.z);
    return value;
}

// Texture values of `count` samples from q_0 + i dq on, dq apart.
void values_of(vec3 q_0, vec3 dq, int i, int count, out float values[MAX_BLOCK]) {
    if (DISPLACED != 0) {
        for (int k = 0; k < count; ++k) values[k] = value_of(q_0 + float(i + k) * dq);
    } else {
        block_values(q_0, dq, i, count, last_stored, values);
    }
}

// Factors on colour (rgb) and extinction (a).
vec4 variation_at(vec3 q) {
    vec3 x = about_centre(q);
    vec4 factor = vec4(1.0);
    for (uint i = 0; i < VARIED; ++i) {
        vec4 found = textureLod(noise, x * vary_at[i].w + vary_at[i].xyz, 0.0);
        factor -= variation[i] * vec4(found.rgb, 1.0 - 2.0 * found.a);
    }
    return max(factor, vec4(0.0));
}

// What normals are of: the texture value at q, or the height above a height field's surface.
float shaped(vec3 q) {
    float value;
    if (HEIGHT_FIELD) value = above_surface(looked_up(q));
    else value = value_of(q);
    return value;
}

vec3 differences_of_shape(vec3 q) {
    q = clamp(q, vec3(0.0), last_voxel);
    vec3 behind = max(q - 1.0, vec3(0.0)), ahead = min(q + 1.0, last_voxel);
    vec3 stretch = vec3(1.0);
    if (HEIGHT_FIELD) {
        // Slopes are told from heights, which do not end at the box, whole at its sides too.
        behind.z = q.z - 1.0;
        ahead.z = q.z + 1.0;
        stretch = 2.0 / max(ahead - behind, vec3(1e-6));
    }
    return stretch * vec3(shaped(vec3(ahead.x, q.yz)) - shaped(vec3(behind.x, q.yz)),
                          shaped(vec3(q.x, ahead.y, q.z)) - shaped(vec3(q.x, behind.y, q.z)),
                          shaped(vec3(q.xy, ahead.z)) - shaped(vec3(q.xy, behind.z)));
}

// Differences between one voxel ahead and one behind q along x, y, z, both clamped at the faces: of the medium as it
// is seen, whatever moved it there.
vec3 differences_at(vec3 q) {
    vec3 d;
    if (HEIGHT_FIELD) d = differences_of_shape(q);
    else if (DISPLACED != 0) d = differences_of_shape(q);
    else d = value_differences(q, last_voxel);
    return d;
}

// Magnitude of the volume's gradient where it is looked up, data units a world unit; at the faces to one side.
float gradient_at(vec3 q) {
    q = looked_up(q);
    vec3 at = clamp(q, vec3(0.0), last_stored);
    vec3 across = min(at + 1.0, last_stored) - max(at - 1.0, vec3(0.0));
    return length(gradient_from_difference * (value_differences(q, last_stored) / max(across, 1e-6)));
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
    if (VARIED != 0) found *= variation_at(q);
    if (HEIGHT_FIELD) found.a *= share_at(q);
    return found;
}

// Extinction alone.
float extinction_of(float value, vec3 q) {
    float entry = entry_of(value);
    float found = extinction_at(entry, table.z);
    if (GRADIENTS && found > 0.0) found = gradient_table_at(entry, q).a;
    if (VARIED != 0) found *= variation_at(q).a;
    if (HEIGHT_FIELD) found *= share_at(q);
    return found;
}

bool has_holes(vec3 q) {
    return textureLod(finite_mask, (q + 0.5) / (last_voxel + 1.0), 0.0).r < 0.999;
}

// 1 only where no voxel that the sample is made of is NaN or infinite.
float finite_weight(vec3 q) {
    q = looked_up(q);
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
