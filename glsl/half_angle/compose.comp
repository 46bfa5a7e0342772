// What a sweep gathered in the eye buffer joins the image: L = sum over lights, behind it the background,
// alpha = 1 - exp(-tau); the first sweep's alone has depth and background.
// Domain: pixels, 8 x 8 a workgroup. Dispatched by technique/half_angle/record.rs.
#version 460
layout(local_size_x = 8, local_size_y = 8) in;
#extension GL_GOOGLE_include_directive : require
#include "shared/view.glsl"
#include "shared/transmittance.glsl"

layout(set = 0, binding = 1, rgba32f) readonly uniform image2D eye;
layout(set = 0, binding = 2, rgba32f) uniform image2D radiance;

layout(push_constant) uniform Push {
    uint sub_sample;
    uint sweep;
} push;

void main() {
    uvec2 pixel = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(pixel, view.image.xy))) return;
    vec4 seen = imageLoad(eye, ivec2(pixel));
    float transmittance = exp(-seen.a);
    bool first = push.sweep == 0;
    vec4 result = vec4(seen.rgb, first ? absorbed(1.0, transmittance, seen.a) : 0.0);
    result.rgb += first ? transmittance * view.background.rgb : vec3(0.0);
    result *= 1.0 / float(view.image.z * view.image.z);
    if (!first || push.sub_sample > 0) result += imageLoad(radiance, ivec2(pixel));
    imageStore(radiance, ivec2(pixel), result);
}
