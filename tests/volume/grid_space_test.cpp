// Tests of index boxes and of the maps between index and world space.
// SPDX-License-Identifier: MPL-2.0
#include "volume/grid_space.h"

#include "random_fields.h"

#include <gtest/gtest.h>

namespace isocast {
namespace {

using test::Random;

TEST(IndexBox, IntersectionHoldsExactlyTheCommonSamples) {
    Random random(1);
    for (int i = 0; i < 200; ++i) {
        const IndexBox a = test::random_box(random, -6, 3, 6);
        const IndexBox b = test::random_box(random, -6, 3, 6);
        const IndexBox both = intersection(a, b);
        test::for_each_sample({Index3::Constant(-7), Index3::Constant(10)}, [&](const Index3& at) {
            ASSERT_EQ(both.contains(at), a.contains(at) && b.contains(at));
        });
    }
}

TEST(IndexBox, BoundingBoxIsTheSmallestThatHoldsBoth) {
    Random random(2);
    for (int i = 0; i < 200; ++i) {
        const IndexBox a = test::random_box(random, -6, 3, 6);
        const IndexBox b = test::random_box(random, -6, 3, 6);
        const IndexBox box = bounding_box(a, b);
        EXPECT_EQ(intersection(box, a), a);
        EXPECT_EQ(intersection(box, b), b);
        for (int axis = 0; axis < 3; ++axis) {
            EXPECT_EQ(box.lo[axis], std::min(a.lo[axis], b.lo[axis]));
            EXPECT_EQ(box.hi[axis], std::max(a.hi[axis], b.hi[axis]));
        }
    }
}

TEST(IndexBox, EmptyOperandDoesNotCountInABoundingBox) {
    const IndexBox box{{1, 2, 3}, {4, 5, 6}};
    const IndexBox empty{{9, 9, 9}, {10, 9, 10}};
    EXPECT_EQ(bounding_box(box, empty), box);
    EXPECT_EQ(bounding_box(empty, box), box);
    EXPECT_TRUE(bounding_box(empty, {}).is_empty());
}

TEST(IndexBox, EmptyBoxHasNoSamples) {
    const IndexBox box{{0, 5, 0}, {4, 2, 4}};
    EXPECT_TRUE(box.is_empty());
    EXPECT_EQ(box.sample_count(), 0);
}

TEST(IndexBox, CountsSamplesBeyond32Bits) {
    const IndexBox box{Index3::Zero(), Index3::Constant(4096)};
    EXPECT_EQ(box.sample_count(), std::int64_t{1} << 36);
}

TEST(IndexBox, DilationAddsSamplesAtEachFace) {
    const IndexBox box = dilated({{0, 0, 0}, {8, 8, 8}}, 1, 2);
    EXPECT_EQ(box, (IndexBox{{-1, -1, -1}, {10, 10, 10}}));
}

TEST(FloorDiv, RoundsDownOnBothSidesOfZero) {
    for (int i = -40; i <= 40; ++i) {
        const int quotient = floor_div(Index3::Constant(i), 8).y();
        EXPECT_LE(8 * quotient, i);
        EXPECT_GT(8 * (quotient + 1), i);
    }
}

/// Anisotropic, rotated, sheared and moved.
GridSpace skewed_space(Random& random) {
    GridSpace space;
    space.world_from_index.linear() =
        Eigen::AngleAxisd(test::random_real(random, 0, 3), Vec3d(1, 2, 3).normalized()) *
        (Mat3d() << 0.5, 0.1, 0, 0, 1.5, -0.2, 0, 0, 0.8).finished();
    space.world_from_index.translation() = test::random_point(random, -10, 10);
    return space;
}

/// A world-space quadratic, of which the derivatives are known and finite differences exact.
struct Quadratic {
    Mat3d a;
    Vec3d b;
    double operator()(const Vec3d& p) const { return p.dot(a * p) / 2 + b.dot(p); }
};

TEST(GridSpace, DerivativesTransformAsFiniteDifferencesInIndexSpaceSay) {
    Random random(3);
    for (int i = 0; i < 50; ++i) {
        const GridSpace space = skewed_space(random);
        Quadratic f{Mat3d::Zero(), test::random_point(random, -1, 1)};
        f.a << 1, 0.3, -0.2, 0.3, -0.7, 0.5, -0.2, 0.5, 0.4;
        const Vec3d p = test::random_point(random, -2, 2);
        const auto at = [&](const Vec3d& offset) { return f(space.to_world(p + offset)); };
        // Central differences with step 1 are exact for quadratics, up to rounding.
        Vec3d gradient_index;
        Mat3d hessian_index;
        for (int k = 0; k < 3; ++k) {
            const Vec3d e = Vec3d::Unit(k);
            gradient_index[k] = (at(e) - at(-e)) / 2;
            for (int l = 0; l < 3; ++l) {
                const Vec3d d = Vec3d::Unit(l);
                hessian_index(k, l) = (at(e + d) - at(e - d) - at(d - e) + at(-e - d)) / 4;
            }
        }
        const Vec3d p_world = space.to_world(p);
        // Values reach 300, the inverse map at most triples: some hundred ulps of 300.
        EXPECT_LT((space.gradient_to_world(gradient_index) - (f.a * p_world + f.b)).norm(), 1e-11);
        EXPECT_LT((space.hessian_to_world(hessian_index) - f.a).norm(), 1e-11);
    }
}

TEST(GridSpace, ToIndexUndoesToWorld) {
    Random random(4);
    for (int i = 0; i < 50; ++i) {
        const GridSpace space = skewed_space(random);
        const Vec3d p = test::random_point(random, -100, 100);
        // Some ulps of 100 times the condition of the map, below 4.
        EXPECT_LT((space.to_index(space.to_world(p)) - p).norm(), 1e-12);
    }
}

TEST(GridSpace, VoxelSizeIsTheShortestEdgeUnderRotation) {
    GridSpace space;
    space.world_from_index =
        Eigen::AngleAxisd(0.7, Vec3d(1, 1, 0).normalized()) * Eigen::Scaling(0.5, 0.25, 2.0);
    // Rotation in double: an ulp or so.
    EXPECT_NEAR(space.voxel_size_world(), 0.25, 1e-15);
    EXPECT_EQ(GridSpace::uniform(0.125, {1, 2, 3}).voxel_size_world(), 0.125);
    EXPECT_EQ(GridSpace::uniform(0.125, {1, 2, 3}).to_world({0, 0, 0}), Vec3d(1, 2, 3));
}

} // namespace
} // namespace isocast
