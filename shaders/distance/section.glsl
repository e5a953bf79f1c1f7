// What a section hands to its fragments: up to four linear functions of the sample.
// SPDX-License-Identifier: MPL-2.0
// twin  distance_transform/gl/site_sections.cpp
//
// SITE_KIND 0, a face: height over its plane, and outwards over its three sides.
// SITE_KIND 1, an edge: two offsets across it, and outwards over its two ends.
// SITE_KIND 2, a vertex: three offsets.

struct Reach {
    float distance; // to the plane, line or point
    float outside;  // how far outside the tower or wedge; < 0 within
};

Reach reach_of(vec4 functions) {
#if SITE_KIND == 0
    return Reach(abs(functions.x), max(max(functions.y, functions.z), functions.w));
#elif SITE_KIND == 1
    return Reach(length(functions.xy), max(functions.z, functions.w));
#elif SITE_KIND == 2
    return Reach(length(functions.xyz), -1e30); // 1e30: a vertex has no sides
#else
#error unknown SITE_KIND
#endif
}
