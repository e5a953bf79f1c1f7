// The lights of a scene, infinitely far away.
// SPDX-License-Identifier: MPL-2.0
// twin  raycaster/look.h: Light

// LIGHTS: how many.
#if LIGHTS
uniform vec3 u_light_directions[LIGHTS]; // towards each, unit length, world axes
uniform vec3 u_light_colours[LIGHTS];
#endif
uniform vec4 u_material; // ambient, diffuse, specular, shininess

// Share of one light that reaches a point.
struct ShadowOfLight {
    int light; // -1: none casts shadows
    float share;
};

float share_of_light(ShadowOfLight shadow, int light) {
    return light == shadow.light ? shadow.share : 1.0;
}
