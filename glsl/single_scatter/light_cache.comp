// The optical depth from every node of a grid over the volume to one light [Max1995], by shadow rays.
// Domain: nodes along x and y, slices of nodes along z; slices of one light, 8 x 8 nodes a workgroup.
// Dispatched by technique/single_scatter/record.rs.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/medium_filtered.glsl"
#include "single_scatter/light_cache.glsl"
