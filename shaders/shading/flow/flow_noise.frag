// A noise in space at the hits, as grainy in the picture wherever they are: what flow is drawn with.
// It is a function of the place in the field and of a pixel's size there alone, so that it sticks to
// the surface when the camera moves.
// SPDX-License-Identifier: MPL-2.0
// twin  tests/shading/flow_test.cpp: noise_at()
#version 450 core

layout(binding = 0) uniform sampler2D t_hit;
uniform vec4 u_grain;     // size of a grain [world]: its dot product with (eye-relative position, 1)
uniform int u_finest;     // octave of the finest lattice: cells of 2^octave [world]
uniform ivec3 u_eye_cell; // of that lattice, from the field's sample 0
uniform vec3 u_eye_place; // in that cell, in [0, 1)

out float o_noise; // mean 0, variance 1

// source  pcg3d of Jarzynski and Olano 2020, "Hash functions for GPU rendering"
uvec3 hash(uvec3 v) {
    v = v * 1664525u + 1013904223u;
    v.x += v.y * v.z;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v ^= v >> 16u;
    v.x += v.y * v.z;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    return v;
}

// Random numbers at the corners of a lattice's cells, linear between, scaled to variance 1 at any
// point.
float lattice_noise(vec3 position, int octave) {
    int up = octave - u_finest;
    vec3 p = position * exp2(float(-octave)) +
             (vec3(u_eye_cell & ((1 << up) - 1)) + u_eye_place) * exp2(float(-up));
    vec3 below = floor(p);
    ivec3 cell = (u_eye_cell >> up) + ivec3(below);
    vec3 a = p - below;
    float sum = 0.0;
    for (int i = 0; i < 8; ++i) {
        ivec3 corner = ivec3(i & 1, i >> 1 & 1, i >> 2);
        vec3 w = mix(1.0 - a, a, vec3(corner));
        uint bits = hash(uvec3(cell + corner) + uint(octave)).x >> 8u;
        sum += w.x * w.y * w.z * (float(bits) * exp2(-23.0) - 1.0);
    }
    vec3 squares = a * a + (1.0 - a) * (1.0 - a);
    return sum * sqrt(3.0 / (squares.x * squares.y * squares.z));
}

void main() {
    vec4 hit = texelFetch(t_hit, ivec2(gl_FragCoord.xy), 0);
    o_noise = 0.0;
    bool is_waiting = hit.w != 0.0; // a loop, since software rasterisers run both sides of an if
    while (is_waiting) {
        float level = max(log2(dot(u_grain, vec4(hit.xyz, 1.0))), float(u_finest));
        int octave = int(floor(level));
        float a = level - float(octave);
        o_noise = ((1.0 - a) * lattice_noise(hit.xyz, octave) +
                   a * lattice_noise(hit.xyz, octave + 1)) *
                  inversesqrt(a * a + (1.0 - a) * (1.0 - a));
        is_waiting = o_noise > 1e3; // never
    }
}
