// How far an octree's field jumps between its cells.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "random_fields.h"
#include "volume/hashed_octree.h"

#include <bit>
#include <cmath>

namespace isocast::test {

// What a float is rounded by at most, as a share of it.
inline constexpr double rounding = 0x1p-24;

/// A leaf and its corners; with `along` set, derivative d takes the place of d ^ along, so that
/// interpolate gives the slope along an axis at the cell's faces across it.
struct LeafData {
    LeafData(const HashedOctree& tree, const OctreeCell& cell, unsigned along) : leaf(cell) {
        const auto nodes = tree.nodes_of(tree.find(leaf).value());
        for (unsigned i = 0; i < 8; ++i) {
            const auto data = tree.data_of(nodes[i]);
            for (unsigned d = 0; d < data.size(); ++d) values[i][d] = data[d ^ along];
            double sum = 0;
            for (unsigned d = 0; d < data.size(); ++d)
                sum += std::abs(values[i][d]) * std::pow(leaf.size(), std::popcount(d & ~along));
            greatest = std::max(greatest, sum);
        }
    }
    float at(OctreeFilter filter, const Vec3d& p) const {
        CornerData corners;
        for (unsigned i = 0; i < 8; ++i) corners[i] = values[i].data();
        return interpolate(filter, corners, leaf.size(),
                           (p - leaf.position.cast<double>()) / leaf.size());
    }
    OctreeCell leaf;
    std::array<std::array<float, 8>, 8> values{};
    double greatest = 0; // no value of the interpolant is larger
};

/// Jumps at random points of all faces between leaves, over what one rounding of a float may be.
inline double greatest_jump(const HashedOctree& tree, Random& random, bool of_slopes) {
    double greatest = 0;
    tree.visit_cells([&](const OctreeCell& cell, bool is_leaf) {
        if (!is_leaf) return;
        for (int axis = 0; axis < 3; ++axis) {
            const unsigned along = of_slopes ? 1u << axis : 0u;
            const LeafData here(tree, cell, along);
            for (int i = 0; i < 4; ++i) {
                // Multiples of 2^-10, so that places in cells are exact; the face is the lower one.
                Vec3d p;
                for (int a = 0; a < 3; ++a)
                    p[a] = cell.position[a] +
                           random_int(random, 0, 1023) * 0x1p-10 * cell.size() * (a != axis);
                if (p[axis] == 0) continue;
                const LeafData beside(tree, tree.leaf_at(p - Vec3d::Unit(axis) / 2), along);
                const double jump =
                    std::abs(double{here.at(tree.filter(), p)} - beside.at(tree.filter(), p));
                greatest = std::max(greatest,
                                    jump / (rounding * std::max(here.greatest, beside.greatest)));
            }
        }
    });
    return greatest;
}

} // namespace isocast::test
