// Blinn-Phong shading [Blinn 1977].
// SPDX-License-Identifier: MPL-2.0
#include "shading/lights.glsl"

vec3 lit(vec3 colour, vec3 normal, vec3 to_viewer, float ambient_share, ShadowOfLight shadow) {
    vec3 sum = vec3(0.0);
#if LIGHTS
    for (int i = 0; i < LIGHTS; ++i) {
        vec3 to_light = u_light_directions[i];
        float lambert = max(dot(normal, to_light), 0.0);
        vec3 half_way = normalize(to_light + to_viewer);
        float highlight = lambert > 0.0 ? pow(max(dot(normal, half_way), 0.0), u_material.w) : 0.0;
        float share = share_of_light(shadow, i);
        sum += (colour * (u_material.x * ambient_share + u_material.y * lambert * share) +
                vec3(u_material.z * highlight * share)) *
               u_light_colours[i];
    }
#endif
    return sum;
}
