// Half spaces as fields.
// SPDX-License-Identifier: MPL-2.0
#include "volume/half_space.h"

#include <gtest/gtest.h>

namespace isocast::test {
namespace {

TEST(HalfSpace, SamplesAreDistancesToThePlaneAndCoverTheBox) {
    const Eigen::AlignedBox3d box(Vec3d(-1, 2, 0.5), Vec3d(3, 3, 0.75));
    const HalfSpaces half = half_spaces({0, -3, 4}, box);
    const GridSpace& space = half.field->space();
    const IndexBox extent = half.field->extent();
    EXPECT_EQ(extent.size().x(), 64 + 2 * 3 + 1);
    for (int i = 0; i < 8; ++i) {
        // The filter reaches one sample below and two above, and those must be there, too.
        const Vec3d p = space.to_index(box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(i)));
        EXPECT_TRUE((p.array() >= extent.lo.cast<double>().array() + 1).all()) << p.transpose();
        EXPECT_TRUE((p.array() <= extent.hi.cast<double>().array() - 3).all()) << p.transpose();
    }
    const double iso = half.iso_of(-0.25);
    for (const Index3& at :
         {extent.lo, Index3(3, -4, 2), Index3((extent.hi.array() - 1).matrix())}) {
        const Vec3d p = space.to_world(at.cast<double>());
        const double in_front = (-0.6 * p.y() + 0.8 * p.z()) + 0.25;
        // A rounding of the sample, which is less than 4.
        EXPECT_NEAR(sample(*half.field, at) - iso, -in_front, 4 * 0x1p-24);
    }
}

} // namespace
} // namespace isocast::test
