// Principal curvatures of the isosurface through a point, from the derivatives there.
// SPDX-License-Identifier: MPL-2.0
// source  thesis eqs 6.5 - 6.7
// twin    filtering/curvature.cpp

// k1 >= k2 [1/length]; a sphere of radius r whose inside is negative has 1/r twice. Zero where the
// gradient vanishes. Both in a space with orthonormal axes.
vec2 principal_curvatures(vec3 gradient, mat3 hessian) {
    float length_g = length(gradient);
    vec3 n = gradient / max(length_g, 1e-30); // 1e-30: no division by zero
    // Tangents without cancellation whatever the normal: Duff et al., JCGT 2017.
    float s = n.z < 0.0 ? -1.0 : 1.0;
    float a = -1.0 / (s + n.z);
    float b = n.x * n.y * a;
    vec3 u = vec3(1.0 + s * n.x * n.x * a, s * b, -s * n.x);
    vec3 v = vec3(b, s + n.y * n.y * a, -n.y);
    vec3 hu = hessian * u;
    float uu = dot(u, hu);
    float uv = dot(v, hu);
    float vv = dot(v, hessian * v);
    float root = length(vec2(uu - vv, 2.0 * uv));
    vec2 k = 0.5 * vec2(uu + vv + root, uu + vv - root) / max(length_g, 1e-30);
    return length_g > 0.0 ? k : vec2(0.0);
}
