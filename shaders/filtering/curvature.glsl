// Curvatures at a point of a field, from the derivatives there.
// SPDX-License-Identifier: MPL-2.0
// source  thesis eqs 6.5 - 6.7
// twin    filtering/curvature.cpp

// The shape operator (eq. 6.6) in an orthonormal basis of the tangent plane.
struct ShapeOperator {
    vec3 u, v;
    float uu, uv, vv; // [1/length]
};

// Both in a space with orthonormal axes. gradient: not zero
ShapeOperator shape_operator(vec3 gradient, mat3 hessian) {
    float length_g = length(gradient);
    vec3 n = gradient / length_g;
    // Tangents without cancellation whatever the normal: Duff et al., JCGT 2017.
    float s = n.z < 0.0 ? -1.0 : 1.0;
    float a = -1.0 / (s + n.z);
    float b = n.x * n.y * a;
    vec3 u = vec3(1.0 + s * n.x * n.x * a, s * b, -s * n.x);
    vec3 v = vec3(b, s + n.y * n.y * a, -n.y);
    vec3 hu = hessian * u;
    return ShapeOperator(u, v, dot(u, hu) / length_g, dot(v, hu) / length_g,
                         dot(v, hessian * v) / length_g);
}

// k1 >= k2 [1/length]; a sphere of radius r whose inside is negative has 1/r twice.
vec2 principal_curvatures(ShapeOperator s) {
    float root = length(vec2(s.uu - s.vv, 2.0 * s.uv));
    return 0.5 * vec2(s.uu + s.vv + root, s.uu + s.vv - root);
}

// Of the isosurface, in the direction of the tangential part of `direction`; 0 where that or the
// gradient vanishes.
float normal_curvature(vec3 gradient, mat3 hessian, vec3 direction) {
    float length_g = length(gradient);
    vec3 n = gradient / max(length_g, 1e-30);
    vec3 t = direction - dot(direction, n) * n;
    float tt = dot(t, t);
    return length_g > 0.0 && tt > 0.0 ? dot(t, hessian * t) / (tt * length_g) : 0.0;
}

// Curvature of the line that runs along the gradient: |P H n| / |g|, P the projection to the
// tangent plane; 0 where the gradient vanishes.
float flow_line_curvature(vec3 gradient, mat3 hessian) {
    float length_g = length(gradient);
    vec3 n = gradient / max(length_g, 1e-30);
    vec3 along = hessian * n;
    return length(along - dot(along, n) * n) / max(length_g, 1e-30);
}
