// The roots of a quadratic function of u that is f0 at 0 and f2 at 1, by its Bernstein coefficients.
// SPDX-License-Identifier: MPL-2.0

// As (u, 1 - u) but for a common factor: (x, y) and (z, w). One lies within [0, 1] exactly if its two
// numbers do not differ in sign, and where f0 and f2 do, just one does, however they are rounded: what f0
// and f2 have in common with their neighbours leaves no ray between them. NaN if there are none.
vec4 bernstein_roots(float f0, float f1, float f2) {
    float root = sqrt(f1 * f1 - f0 * f2);
    float q = -(f1 + (f1 < 0.0 ? -root : root)); // no sign(): that of 0 must not be 0
    return vec4(q, f2, f0, q);
}
