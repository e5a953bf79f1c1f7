// Tone shading: warm towards the light, cool away from it [Gooch et al. 1998, eqs 2, 3]. As printed,
// eq. 2 gives the cool tone to what faces the light, against the paper's text and figures.
// SPDX-License-Identifier: MPL-2.0
#include "shading/lights.glsl"

uniform vec3 u_cool;
uniform vec3 u_warm;
uniform vec2 u_shares; // of the surface colour in the cool and in the warm tone

vec3 lit(vec3 colour, vec3 normal, vec3 to_viewer, float ambient_share, ShadowOfLight shadow) {
    vec3 cool = u_cool + u_shares.x * colour;
    vec3 warm = u_warm + u_shares.y * colour;
    vec3 sum = vec3(0.0);
#if LIGHTS
    for (int i = 0; i < LIGHTS; ++i) {
        vec3 to_light = u_light_directions[i];
        float share = share_of_light(shadow, i);
        // In shadow, what faces the light has the tone of what it just grazes, so that there is no
        // edge where a surface turns away from the light and shadows itself.
        float lambert = dot(normal, to_light);
        float towards = 0.5 + 0.5 * (lambert > 0.0 ? share * lambert : lambert);
        vec3 half_way = normalize(to_light + to_viewer);
        float highlight = pow(max(dot(normal, half_way), 0.0), u_material.w);
        sum += (mix(cool, warm, towards) * ambient_share + vec3(u_material.z * highlight * share)) *
               u_light_colours[i];
    }
#endif
    return sum;
}
