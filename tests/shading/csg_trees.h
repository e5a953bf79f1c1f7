// Trees of CSG for tests.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "../volume/random_fields.h"
#include "raycaster/csg.h"

namespace isocast::test {

inline constexpr auto Object = CsgOperation::Object;
inline constexpr auto Union = CsgOperation::Union;
inline constexpr auto Intersection = CsgOperation::Intersection;
inline constexpr auto Difference = CsgOperation::Difference;

/// A random tree that names every object, and some of them twice.
inline CsgTree random_tree(Random& random, int object_count) {
    CsgTree tree;
    int operands = 0;
    std::vector<int> objects;
    for (int i = 0; i < object_count; ++i) objects.push_back(i);
    objects.push_back(random_int(random, 0, object_count - 1));
    std::shuffle(objects.begin(), objects.end(), random);
    const auto combine = [&] {
        tree.push_back({static_cast<CsgOperation>(random_int(random, 1, 3))});
        --operands;
    };
    for (const int object : objects) {
        tree.push_back({Object, object});
        ++operands;
        while (operands > 1 && random_int(random, 0, 1) == 0) combine();
    }
    while (operands > 1) combine();
    return tree;
}

} // namespace isocast::test
