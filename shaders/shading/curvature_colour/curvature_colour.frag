// One curvature measure through a map of colours (thesis section 6.4.2, "Curvature color mapping").
// SPDX-License-Identifier: MPL-2.0
// twin  raycaster/effects/curvature_measure.cpp
#version 450 core
// MEASURE: raycaster/look.h, CurvatureMeasure.

layout(binding = 0) uniform sampler2D t_curvature;
layout(binding = 1) uniform sampler2D t_map; // first texel: least, last: greatest
uniform vec2 u_range;                        // of the measure

float measure(float k1, float k2) {
#if MEASURE == 0
    return k1;
#elif MEASURE == 1
    return k2;
#elif MEASURE == 2
    return 0.5 * (k1 + k2);
#elif MEASURE == 3
    return k1 * k2;
#elif MEASURE == 4
    const float pi = 3.14159265358979;
    // atan(0, 0) is undefined.
    return k1 == 0.0 && k2 == 0.0 ? 0.0 : 2.0 / pi * atan(k1 + k2, k1 - k2);
#elif MEASURE == 5
    return sqrt(0.5) * length(vec2(k1, k2));
#else
#error unknown MEASURE
#endif
}

out vec4 o_curvature_colour; // linear RGB; coverage 0 where the gradient vanishes

void main() {
    vec4 curvature = texelFetch(t_curvature, ivec2(gl_FragCoord.xy), 0);
    float t = clamp((measure(curvature.x, curvature.y) - u_range.x) / (u_range.y - u_range.x), 0.0,
                    1.0);
    float texels = float(textureSize(t_map, 0).x);
    vec3 colour = textureLod(t_map, vec2((0.5 + t * (texels - 1.0)) / texels, 0.5), 0.0).rgb;
    o_curvature_colour = curvature.w != 0.0 && curvature.w != 2.0 ? vec4(colour, 1.0) : vec4(0.0);
}
