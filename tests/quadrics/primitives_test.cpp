// Primitives that cannot be drawn are named by their index.
// SPDX-License-Identifier: MPL-2.0
#include "quadrics/primitives.h"

#include "volume/errors.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace isocast {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

TEST(Primitives, ThatCannotBeDrawnAreNamedByTheirIndex) {
    for (const double radius : {0.0, -1.0, double(NAN), double(INFINITY)}) {
        const std::vector<Sphere> spheres{{}, {}, {.radius_world = radius}};
        EXPECT_THAT([&] { check(std::span(spheres)); },
                    ThrowsMessage<InputError>(HasSubstr("sphere 2: its radius is ")))
            << radius;
        const std::vector<Cylinder> cylinders{{}, {.radius_world = radius}};
        EXPECT_THAT([&] { check(std::span(cylinders)); },
                    ThrowsMessage<InputError>(HasSubstr("cylinder 1: its radius is ")))
            << radius;
    }
    const Vec3d nowhere(0, NAN, 0);
    EXPECT_THROW(check(std::vector<Sphere>{{.centre_world = nowhere}}), InputError);
    EXPECT_THROW(check(std::vector<Ellipsoid>{{.centre_world = nowhere}}), InputError);
    EXPECT_THROW(check(std::vector<Cylinder>{{.b_world = Vec3d::Zero()}}), InputError);
    EXPECT_THROW(check(std::vector<Cone>{{.radius_a_world = 0, .radius_b_world = 0}}), InputError);
    EXPECT_THROW(check(std::vector<Ellipsoid>{{.axes_world = Vec3d(1, 1, 0).asDiagonal()}}),
                 InputError);
    EXPECT_THROW(check(std::vector<ClippedQuadric>{{.a = Mat3d::Zero()}}), InputError);
}

TEST(Primitives, ThatAreThinHugeOrPointedCanBeDrawn) {
    EXPECT_NO_THROW(check(std::vector<Sphere>{{.radius_world = 1e-30}, {.radius_world = 1e30}}));
    EXPECT_NO_THROW(check(std::vector<Ellipsoid>{{.axes_world = Vec3d(1, 1, 1e-6).asDiagonal()}}));
    EXPECT_NO_THROW(check(std::vector<Cone>{{}, {.radius_a_world = 0, .radius_b_world = 1}}));
    EXPECT_NO_THROW(check(std::vector<ClippedQuadric>{{.a = Mat3d::Zero(), .b = Vec3d::UnitX()}}));
    EXPECT_NO_THROW(check(std::vector<Cylinder>{}));
}

} // namespace
} // namespace isocast
