// Light from a direction.
// SPDX-License-Identifier: MPL-2.0
// twin  raycaster/environment.cpp
layout(binding = 15) uniform sampler2D t_environment; // equirectangular, +y up, with all its levels

// angle  between neighbouring pixels' directions: finer detail is averaged
vec3 environment(vec3 direction_world, float angle) {
    vec3 d = direction_world;
    const float pi = 3.14159265358979;
    // atan(0, 0) at the poles is undefined: there any column will do.
    float longitude = d.x == 0.0 && d.z == 0.0 ? 0.0 : atan(d.x, -d.z);
    // Not asin, which loses half of the digits at the poles.
    float latitude = atan(d.y, length(d.xz));
    float texels = angle * float(textureSize(t_environment, 0).y) / pi;
    return textureLod(t_environment, vec2(0.5 + longitude / (2.0 * pi), 0.5 + latitude / pi),
                      log2(max(texels, 1.0))).rgb;
}
