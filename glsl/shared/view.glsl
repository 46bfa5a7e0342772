// The camera, the image and what is clipped away. Positions are in world units relative to the
// volume's centre, so that an origin of 1e6 costs no precision. Layout: `technique/view.rs`.
layout(std140, set = 0, binding = 0) uniform View {
    vec4 pivot;                // where the image's centre ray passes the volume; w unused
    vec4 pivot_right;          // change of the pivot from the image's centre to its right edge
    vec4 pivot_up;             // change of the pivot from the image's centre to its top edge
    vec4 forward;              // viewing direction; w: distance from the eye to the pivot
    vec4 ray_right;            // change of the direction to the right edge; 0 for parallel rays
    vec4 ray_up;               // change of the direction to the top edge; 0 for parallel rays
    vec4 texture_from_world[3];// rows of the affine map to texture coordinates
    vec4 clip_min;             // kept box
    vec4 clip_max;
    vec4 clip_plane;           // kept where dot(xyz, x) + w >= 0
    vec4 background;           // radiance behind the volume
    uvec4 image;               // width, height, samples per axis, unused
} view;

struct Ray {
    vec3 origin;    // a point on the ray near the volume
    vec3 direction; // unit length
    float t_min;    // the eye, as seen from `origin`
};

// All rays of the image, so that the block is read once.
struct CameraRays {
    vec3 origin;
    vec3 origin_right;
    vec3 origin_up;
    vec3 forward;
    vec3 right;
    vec3 up;
    float eye;
    vec2 pixels;
    uint samples; // along each axis of a pixel
};

CameraRays camera_rays() {
    return CameraRays(view.pivot.xyz, view.pivot_right.xyz, view.pivot_up.xyz, view.forward.xyz,
                      view.ray_right.xyz, view.ray_up.xyz, view.forward.w, vec2(view.image.xy), view.image.z);
}

// The ray through a place in the image, in pixels from its top left corner.
Ray ray_at(CameraRays rays, vec2 place) {
    vec2 ndc = 2.0 * place / rays.pixels - 1.0;
    ndc.y = -ndc.y;
    vec3 d = rays.forward + ndc.x * rays.right + ndc.y * rays.up;
    float length_d = length(d);
    Ray ray;
    ray.origin = rays.origin + ndc.x * rays.origin_right + ndc.y * rays.origin_up;
    ray.direction = d / length_d;
    ray.t_min = -rays.eye * length_d;
    return ray;
}

// The ray through sub-sample `sub` of a pixel; row 0 is the top.
Ray camera_ray(uvec2 pixel, uint sub) {
    CameraRays rays = camera_rays();
    uint n = rays.samples;
    return ray_at(rays, vec2(pixel) + (vec2(sub % n, sub / n) + 0.5) / float(n));
}

// Direction of the view's ray through x.
vec3 direction_to(vec3 x) {
    vec3 from_eye = x - view.pivot.xyz + view.forward.w * view.forward.xyz;
    bool parallel = dot(view.ray_up.xyz, view.ray_up.xyz) == 0.0;
    return parallel ? view.forward.xyz : from_eye / max(length(from_eye), 1e-30);
}

vec3 texture_point(vec3 x) {
    vec4 h = vec4(x, 1.0);
    return vec3(dot(view.texture_from_world[0], h), dot(view.texture_from_world[1], h),
                dot(view.texture_from_world[2], h));
}

vec3 texture_direction(vec3 d) {
    return vec3(dot(view.texture_from_world[0].xyz, d), dot(view.texture_from_world[1].xyz, d),
                dot(view.texture_from_world[2].xyz, d));
}
