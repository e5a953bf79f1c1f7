// Points spread evenly over the unit disc.
// SPDX-License-Identifier: MPL-2.0
// twin  tests/shading/disc.h

// A point from its radius and its angle [turns].
vec2 on_disc(float radius, float turns) {
    float angle = 6.28318530718 * fract(turns);
    return radius * vec2(cos(angle), sin(angle));
}

// Point i of n, all of the same share of the area: a sunflower's spiral, by the golden section.
vec2 disc_point(int i, int n, float turns) {
    return on_disc(sqrt((float(i) + 0.5) / float(n)), 0.61803398875 * float(i) + turns);
}

// By how much a pixel's points are turned [turns]: pixels side by side have angles far apart, those of
// any small square are spread evenly. Thesis section 7.3.2 takes them from a table, tile by tile; here
// they are a lattice of rank one, by powers of the root of x^3 = x + 1, the golden section's like in
// two dimensions.
float turns_of_pixel(vec2 pixel) { return fract(dot(pixel, vec2(0.75487766625, 0.56984029100))); }
