// SPDX-License-Identifier: MPL-2.0
#include "quadrics/quadratic_spline.h"
#include "volume/analytic_fields.h"
#include "volume/dense_field.h"

#include <gmock/gmock.h>
#include <tbb/global_control.h>

#include <set>

namespace isocast::test {
namespace {

TetrahedralMesh gyroid_by(std::size_t threads) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    return quadratic_spline(*sampled(builtin_field("gyroid"), 40), 0);
}

TEST(QuadraticSpline, IsTheSameByAnyNumberOfThreads) {
    const TetrahedralMesh by_one = gyroid_by(1);
    ASSERT_GT(by_one.tetrahedra.size(), 10000U);
    for (const std::size_t threads : {2, 3}) {
        const TetrahedralMesh mesh = gyroid_by(threads);
        EXPECT_EQ(mesh.vertices_world, by_one.vertices_world);
        EXPECT_EQ(mesh.tetrahedra, by_one.tetrahedra);
        EXPECT_EQ(mesh.coefficients, by_one.coefficients);
        EXPECT_EQ(mesh.is_closed, by_one.is_closed);
    }
}

TEST(QuadraticSpline, LayersShareTheirVertices) {
    const TetrahedralMesh mesh = gyroid_by(2);
    std::set<std::array<double, 3>> places;
    for (const Vec3d& v : mesh.vertices_world) places.insert({v.x(), v.y(), v.z()});
    EXPECT_EQ(places.size(), mesh.vertices_world.size());
}

} // namespace
} // namespace isocast::test
