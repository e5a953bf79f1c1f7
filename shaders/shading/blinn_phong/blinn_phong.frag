// Blinn-Phong shading of the hits [Blinn 1977] (thesis section 6.4.2).
// SPDX-License-Identifier: MPL-2.0
#version 450 core

layout(binding = 0) uniform sampler2D t_hit;
layout(binding = 1) uniform sampler2D t_gradient;
uniform mat3 u_ray_vector;       // world axes, affine in the pixel: towards the scene
uniform vec3 u_light_direction;  // towards the light, unit length, world axes
uniform vec3 u_light_colour;
uniform vec3 u_colour;
uniform vec4 u_material;         // ambient, diffuse, specular, shininess
uniform vec3 u_background;

out vec4 o_beauty; // linear RGB, coverage

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec4 hit = texelFetch(t_hit, pixel, 0);
    if (hit.w == 0.0) {
        o_beauty = vec4(u_background, 0.0);
        return;
    }
    vec3 to_viewer = -normalize(u_ray_vector * vec3(1.0, gl_FragCoord.xy));
    vec3 gradient = texelFetch(t_gradient, pixel, 0).xyz;
    float length_g = length(gradient);
    // Where the gradient vanishes there is no normal: the surface then faces the viewer.
    vec3 normal = length_g > 0.0 ? gradient / length_g : to_viewer;
    // Seen from inside, the surface shows its back.
    if (dot(normal, to_viewer) < 0.0) normal = -normal;

    float lambert = max(dot(normal, u_light_direction), 0.0);
    vec3 half_way = normalize(u_light_direction + to_viewer);
    float highlight = lambert > 0.0 ? pow(max(dot(normal, half_way), 0.0), u_material.w) : 0.0;
    vec3 colour = u_colour * (u_material.x + u_material.y * lambert) +
                  vec3(u_material.z * highlight);
    o_beauty = vec4(colour * u_light_colour, 1.0);
}
