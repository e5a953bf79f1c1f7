// Seeded random boxes and fields, and how fields are compared sample by sample.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "volume/dense_field.h"
#include "volume/sparse_field.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <random>

namespace isocast::test {

using Random = std::mt19937;

inline int random_int(Random& random, int lo, int hi) {
    return std::uniform_int_distribution(lo, hi)(random);
}

/// A turned grid with three spacings, and numbers that need all their digits.
inline GridSpace turned_space() {
    GridSpace space;
    const Mat3d turn = Eigen::AngleAxisd(0.4, Vec3d(1, 2, 3).normalized()).toRotationMatrix();
    space.world_from_index.linear() = turn * Vec3d(0.1, 1.0 / 3, 2.7e-5).asDiagonal();
    space.world_from_index.translation() = Vec3d(1e6 / 3, -0.1, 7e-9);
    return space;
}

inline double random_real(Random& random, double lo, double hi) {
    return std::uniform_real_distribution(lo, hi)(random);
}

inline Vec3d random_point(Random& random, double lo, double hi) {
    const double x = random_real(random, lo, hi);
    const double y = random_real(random, lo, hi);
    return {x, y, random_real(random, lo, hi)};
}

/// A box with lo in from … to and 1 … most samples an axis.
inline IndexBox random_box(Random& random, int from, int to, int most) {
    IndexBox box;
    for (int axis = 0; axis < 3; ++axis) {
        box.lo[axis] = random_int(random, from, to);
        box.hi[axis] = box.lo[axis] + random_int(random, 1, most);
    }
    return box;
}

inline DenseField random_dense(Random& random, const IndexBox& extent) {
    std::vector<float> values(static_cast<std::size_t>(extent.sample_count()));
    for (float& value : values) value = static_cast<float>(random_real(random, -1, 1));
    return {GridSpace::uniform(1), extent, values};
}

/// Blocks with coordinates in [-reach, reach]^3, each there with `probability`. Half of them hold
/// noise, a quarter one constant ± background, a quarter ± background at random.
inline FieldBlocks random_blocks(Random& random, int reach, double probability, float background) {
    FieldBlocks blocks;
    const auto sign = [&] { return random_int(random, 0, 1) == 0 ? -background : background; };
    for (int z = -reach; z <= reach; ++z) {
        for (int y = -reach; y <= reach; ++y) {
            for (int x = -reach; x <= reach; ++x) {
                if (random_real(random, 0, 1) >= probability) continue;
                FieldBlock block;
                block.coordinate = {x, y, z};
                const int kind = random_int(random, 0, 3);
                const float constant = sign();
                for (std::size_t i = 0; i < block.values.size(); ++i) {
                    block.active[i] = kind < 2 && random_int(random, 0, 2) > 0;
                    block.values[i] = kind == 2 ? constant : sign();
                    if (block.active[i]) {
                        block.values[i] *= static_cast<float>(random_real(random, 0, 1));
                    }
                }
                blocks.push_back(block);
            }
        }
    }
    std::shuffle(blocks.begin(), blocks.end(), random);
    return blocks;
}

/// Of blocks in [-2, 2]^3.
inline std::shared_ptr<const FieldSource> random_sparse(Random& random) {
    return std::make_shared<SparseField>(GridSpace::uniform(0.5), 1.5, Outside::SignedBackground,
                                         random_blocks(random, 2, 0.4, 1.5F));
}

inline std::vector<float> copied(const FieldSource& field, const IndexBox& box, int level = 0) {
    std::vector<float> values(static_cast<std::size_t>(box.sample_count()));
    field.copy_box(box, level, values);
    return values;
}

/// Calls visit(index) for every sample of `box`, x fastest.
template<class Visit>
void for_each_sample(const IndexBox& box, Visit visit) {
    for (int z = box.lo.z(); z < box.hi.z(); ++z) {
        for (int y = box.lo.y(); y < box.hi.y(); ++y) {
            for (int x = box.lo.x(); x < box.hi.x(); ++x) visit(Index3(x, y, z));
        }
    }
}

} // namespace isocast::test
