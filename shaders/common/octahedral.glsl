// Directions in 32 bits: 16 for each of two places on an octahedron that is folded open.
// SPDX-License-Identifier: MPL-2.0
// source    Cigolle et al. 2014, "A survey of efficient representations for independent unit vectors"
// accuracy  7e-5 radians

vec2 folded(vec2 p) { return (1.0 - abs(p.yx)) * mix(vec2(-1.0), vec2(1.0), greaterThanEqual(p, vec2(0.0))); }

uint packed_direction(vec3 v) {
    vec2 p = v.xy / (abs(v.x) + abs(v.y) + abs(v.z));
    return packSnorm2x16(v.z < 0.0 ? folded(p) : p);
}

vec3 unpacked_direction(uint bits) {
    vec2 p = unpackSnorm2x16(bits);
    float z = 1.0 - abs(p.x) - abs(p.y);
    return normalize(vec3(z < 0.0 ? folded(p) : p, z));
}
