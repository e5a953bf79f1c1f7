// The ray of a pixel, in a field's local index coordinates.
// SPDX-License-Identifier: MPL-2.0
// twin  raycaster/passes.cpp: set_ray_uniforms(), which computes the coefficients in double
#include "common/pixel.glsl"

// Every vector here is affine in the pixel: constant + x * d/dx + y * d/dy, with (x, y) from
// picture_pixel(). `point` lies on a plane through the object, not at the eye, so that a far eye does
// not cost digits; `vector` leads to it from the ray's start.
uniform mat3 u_ray_point;
uniform mat3 u_ray_vector;
// From the eye to `point`; equals `vector` in perspective.
uniform mat3 u_ray_from_eye;

struct Ray {
    vec3 point;     // local index coordinates
    vec3 direction; // unit length in index space
    vec3 from_eye;  // point - eye [voxels]
    float t_start;  // parameter of the ray's start; p(t) = point + t * direction [voxels]
};

Ray pixel_ray() {
    vec3 p = vec3(1.0, picture_pixel());
    vec3 v = u_ray_vector * p;
    float length_v = length(v);
    return Ray(u_ray_point * p, v / length_v, u_ray_from_eye * p, -length_v);
}
