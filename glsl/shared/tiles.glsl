// Tiles of 8 x 8 pixels, one a workgroup of 64 invocations in linear order. The includer declares SPREAD and includes
// shared/view.glsl before. Dispatched by technique/tiles.rs.

// The pixel of this invocation among `count` tiles from `first` on; false where it has none.
bool pixel_of(uint first, uint count, out uvec2 pixel) {
    // Tiles are dealt out to SPREAD streams, so that drivers which give each thread one contiguous
    // run of workgroups still share the picture's busy middle evenly.
    uint streams = (count + SPREAD - 1) / SPREAD;
    uint index = (gl_WorkGroupID.x % streams) * SPREAD + gl_WorkGroupID.x / streams;
    uint tile = first + index;
    uint tiles_x = (view.image.x + 7) / 8;
    // Lanes in 4 x 2 blocks: eight neighbouring rays take similar paths.
    uint lane = gl_LocalInvocationIndex;
    uvec2 in_tile = uvec2((lane & 3) | ((lane >> 1) & 4), ((lane >> 2) & 1) | ((lane >> 3) & 6));
    pixel = uvec2(tile % tiles_x, tile / tiles_x) * 8 + in_tile;
    return index < count && all(lessThan(pixel, view.image.xy));
}
