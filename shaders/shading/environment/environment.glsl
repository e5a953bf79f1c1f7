// Light from a direction.
// SPDX-License-Identifier: MPL-2.0
// twin  raycaster/environment.cpp
layout(binding = 15) uniform sampler2D t_environment; // equirectangular, +y up

vec3 environment(vec3 direction_world) {
    vec3 d = normalize(direction_world);
    const float pi = 3.14159265358979;
    // atan(0, 0) at the poles is undefined: there any column will do.
    float longitude = d.x == 0.0 && d.z == 0.0 ? 0.0 : atan(d.x, -d.z);
    return textureLod(t_environment, vec2(0.5 + longitude / (2.0 * pi), 0.5 + asin(clamp(d.y, -1.0, 1.0)) / pi),
                      0.0).rgb;
}
