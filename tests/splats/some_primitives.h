// Seeded primitives of every kind for the tests of this folder.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "../quadrics/random_primitives.h"

namespace isocast::test {

/// So many of each kind of quadric, none of which hides all others.
///
/// thinning  of cylinders
inline Primitives some_quadrics(Random& random, int count, double thinning = 0.3) {
    Primitives some;
    for (int i = 0; i < count; ++i) {
        some.spheres.push_back(random.sphere());
        some.spheres.back().radius_world *= 0.3;
        some.ellipsoids.push_back(random.ellipsoid());
        some.cylinders.push_back(random.cylinder());
        some.cylinders.back().radius_world *= thinning;
        some.cones.push_back(random.cone());
        some.quadrics.push_back(random.clipped_quadric());
    }
    return some;
}

/// And as many superquadrics, and a tetrahedron.
inline Primitives some_of_each(Random& random, int count) {
    Primitives some = some_quadrics(random, count);
    for (int i = 0; i < count; ++i)
        some.superquadrics.push_back({.centre_world = random.in_cube(1),
                                      .axes_world = 0.3 * random.rotation(),
                                      .alpha = 0.6,
                                      .beta = 0.4});
    const Vec3d a = random.in_cube(1);
    some.meshes.push_back(
        {.vertices_world = {a, a + random.unit(), a + random.unit(), a + random.unit()},
         .triangles = {{0, 1, 2}, {0, 3, 1}, {0, 2, 3}, {1, 3, 2}}});
    return some;
}

} // namespace isocast::test
