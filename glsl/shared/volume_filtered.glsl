// The volume through the device's linear filter.
layout(set = 0, binding = 2) uniform sampler3D volume;

// Trilinear value at texture coordinate p, clamped in the outer half voxel.
float volume_at(vec3 p, vec3 dims) {
    return textureLod(volume, p, 0.0).r;
}

// Differences between one voxel ahead and one behind p along x, y, z, both clamped at the faces.
vec3 volume_differences(vec3 p, vec3 dims) {
    vec3 h = 1.0 / dims;
    p = clamp(p, 0.5 * h, 1.0 - 0.5 * h);
    vec3 lo = max(p - h, 0.5 * h);
    vec3 hi = min(p + h, 1.0 - 0.5 * h);
    return vec3(
        textureLod(volume, vec3(hi.x, p.yz), 0.0).r - textureLod(volume, vec3(lo.x, p.yz), 0.0).r,
        textureLod(volume, vec3(p.x, hi.y, p.z), 0.0).r - textureLod(volume, vec3(p.x, lo.y, p.z), 0.0).r,
        textureLod(volume, vec3(p.xy, hi.z), 0.0).r - textureLod(volume, vec3(p.xy, lo.z), 0.0).r);
}
