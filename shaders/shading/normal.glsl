// The side of the surface that is seen.
// SPDX-License-Identifier: MPL-2.0

// Unit length. Where the gradient vanishes there is no normal: the surface then faces the viewer.
// Seen from inside, it shows its back.
vec3 facing_normal(vec3 gradient, vec3 to_viewer) {
    float length_g = length(gradient);
    vec3 normal = length_g > 0.0 ? gradient / length_g : to_viewer;
    return dot(normal, to_viewer) < 0.0 ? -normal : normal;
}
