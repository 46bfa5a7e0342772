// A path on its way. It survives a dispatch, so that no dispatch runs long, however long the path.
const uint START = 0;
const uint WALK = 1;
const uint SHADOW = 2;

struct Walker {
    vec3 x;          // where it entered or last scattered
    float t;         // how far it is along d
    vec3 d;          // unit direction
    float t_end;     // where the medium, or the way to the light, ends
    vec3 next;       // direction after the shadow ray
    uint state;      // START, WALK, SHADOW; from bit 2 on: scattering events
    vec3 throughput;
    uint step;       // quadruples of random numbers drawn for this sample
    vec3 light;      // what the shadow ray brings in vacuum
    uint count;      // samples finished
    vec3 gathered;   // radiance of this sample
    float met;       // weight with which it met the medium; 0: not yet
    float tau_left;  // optical depth to the next tentative collision
    float tau;       // optical depth of the shadow ray's certain part
    float transmittance; // estimate of the rest
    float density;   // per steradian, with which d was drawn at the last event
    uint index;      // the pixel's
};

uvec4 packed(vec3 v, uint w) {
    return uvec4(floatBitsToUint(v), w);
}

void store(ivec2 pixel, Walker p) {
    imageStore(walkers, ivec3(pixel, 0), packed(p.x, floatBitsToUint(p.t)));
    imageStore(walkers, ivec3(pixel, 1), packed(p.d, floatBitsToUint(p.t_end)));
    imageStore(walkers, ivec3(pixel, 2), packed(p.next, p.state));
    imageStore(walkers, ivec3(pixel, 3), packed(p.throughput, p.step));
    imageStore(walkers, ivec3(pixel, 4), packed(p.light, p.count));
    imageStore(walkers, ivec3(pixel, 5), packed(p.gathered, floatBitsToUint(p.met)));
    imageStore(walkers, ivec3(pixel, 6), packed(vec3(p.tau_left, p.tau, p.transmittance), floatBitsToUint(p.density)));
}

Walker restore(ivec2 pixel) {
    uvec4 v[7];
    for (int i = 0; i < 7; ++i) v[i] = push.first > 0 ? uvec4(0) : imageLoad(walkers, ivec3(pixel, i));
    vec3 optical = uintBitsToFloat(v[6].xyz);
    return Walker(uintBitsToFloat(v[0].xyz), uintBitsToFloat(v[0].w), uintBitsToFloat(v[1].xyz),
                  uintBitsToFloat(v[1].w), uintBitsToFloat(v[2].xyz), v[2].w, uintBitsToFloat(v[3].xyz),
                  v[3].w, uintBitsToFloat(v[4].xyz), v[4].w, uintBitsToFloat(v[5].xyz),
                  uintBitsToFloat(v[5].w), optical.x, optical.y, optical.z, uintBitsToFloat(v[6].w), 0);
}

// Four uniform numbers in [0, 1).
vec4 uniforms(inout Walker p) {
    return vec4(pcg4d(uvec4(p.index, p.count, p.step++, push.seed)) >> 8) * 5.9604645e-8;
}
