// The active blocks hold every root of the reconstructed function.
// SPDX-License-Identifier: MPL-2.0
#include "filtering/reconstruct.h"
#include "volume/blocks.h"
#include "volume/sparsify.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <tuple>

namespace isocast {
namespace {

/// Samples the spline `rate` times per voxel along lines of every direction through the extent, and
/// expects each sign change in an active block. Returns how many there were.
int expect_roots_in_active_blocks(const FieldSource& field, float iso, int rate) {
    const ActiveBlocks active = find_active_blocks(field, iso);
    std::set<std::tuple<int, int, int>> blocks;
    for (const Index3& b : active.coordinates) blocks.emplace(b.x(), b.y(), b.z());
    const auto is_active = [&](const Vec3d& p_index) {
        const Index3 b = floor_div(p_index.array().floor().cast<int>().matrix(), block_size);
        return blocks.contains({b.x(), b.y(), b.z()});
    };
    const Vec3d lo = field.extent().lo.cast<double>();
    const Vec3d size = (field.extent().size().array() - 1).matrix().cast<double>();
    int roots = 0;
    for (int axis = 0; axis < 3; ++axis) {
        for (double u = 0.37; u < size[(axis + 1) % 3]; u += 2.3) {
            for (double v = 0.71; v < size[(axis + 2) % 3]; v += 2.9) {
                Vec3d before = lo;
                before[(axis + 1) % 3] += u;
                before[(axis + 2) % 3] += v;
                double value_before = tricubic_value(field, before) - iso;
                const int steps = static_cast<int>(size[axis]) * rate;
                for (int step = 1; step <= steps; ++step) {
                    Vec3d p = before;
                    p[axis] = lo[axis] + static_cast<double>(step) / rate;
                    const double value = tricubic_value(field, p) - iso;
                    if ((value < 0) != (value_before < 0)) {
                        ++roots;
                        Vec3d a = before;
                        Vec3d b = p;
                        for (int i = 0; i < 45; ++i) { // to an ulp or so
                            const Vec3d middle = (a + b) / 2;
                            const bool same =
                                (tricubic_value(field, middle) - iso < 0) == (value_before < 0);
                            (same ? a : b) = middle;
                        }
                        EXPECT_TRUE(is_active(a) || is_active(b)) << a.transpose();
                    }
                    before = p;
                    value_before = value;
                }
            }
        }
    }
    return roots;
}

TEST(ActiveBlocks, HoldEveryRootOfTheSplineInABand) {
    const SparseField torus = to_sparse(*sampled(builtin_field("torus"), 61, 3));
    EXPECT_GT(expect_roots_in_active_blocks(torus, 0, 3), 500);
    EXPECT_GT(expect_roots_in_active_blocks(torus,
                                            0.9f * static_cast<float>(torus.background_world()), 3),
              500);
}

TEST(ActiveBlocks, HoldEveryRootOfTheSplineOfAFieldThatCrossesItsBorder) {
    for (const std::string name : {"gyroid", "saddle", "marschner-lobb"}) {
        EXPECT_GT(expect_roots_in_active_blocks(*sampled(builtin_field(name), 41), 0, 3), 100)
            << name;
    }
}

} // namespace
} // namespace isocast
