// Fields that are scaled, turned and moved, against the field at the place that goes there.
// SPDX-License-Identifier: MPL-2.0
#include "volume/placed_field.h"

#include "random_fields.h"
#include "volume/analytic_fields.h"
#include "volume/errors.h"
#include "volume/sparse_field.h"

namespace isocast::test {
namespace {

const Placement placement{
    .scale = 2.5, .rotation_degrees = {20, -35, 110}, .translation_world = {3, -1, 0.5}};

TEST(Placement, TurnsAboutXThenYThenZ) {
    const auto moved = [](const Placement& p, const Vec3d& v) -> Vec3d { return p.to_world() * v; };
    const auto is_near = [](const Vec3d& a, const Vec3d& b) { return (a - b).norm() < 1e-15; };
    const Vec3d x = Vec3d::UnitX();
    const Vec3d y = Vec3d::UnitY();
    const Vec3d z = Vec3d::UnitZ();
    EXPECT_TRUE(is_near(moved({.rotation_degrees = 90 * x}, y), z));
    EXPECT_TRUE(is_near(moved({.rotation_degrees = 90 * y}, z), x));
    EXPECT_TRUE(is_near(moved({.rotation_degrees = 90 * z}, x), y));
    EXPECT_TRUE(is_near(moved({.rotation_degrees = 90 * (x + z)}, y), z));
    EXPECT_TRUE(is_near(moved({.rotation_degrees = 90 * (x + z)}, z), x));
    EXPECT_TRUE(is_near(moved({.scale = 2, .translation_world = x}, x), 3 * x));
}

TEST(PlacedField, IsTheDistanceToThePlacedSphere) {
    AnalyticField sphere = sphere_field(Vec3d{0.2, 0.1, -0.1}, 0.6);
    const Vec3d centre = placement.to_world() * Vec3d{0.2, 0.1, -0.1};
    const PlacedField placed(sampled(std::move(sphere), 33), placement);
    const IndexBox extent = placed.extent();
    Random random(1);
    for (int i = 0; i < 1000; ++i) {
        Index3 index;
        for (int axis = 0; axis < 3; ++axis)
            index[axis] = random_int(random, extent.lo[axis], extent.hi[axis] - 1);
        const Vec3d p_world = placed.space().to_world(index.cast<double>());
        // A float's rounding of a distance below 8, twice.
        EXPECT_NEAR(sample(placed, index), (p_world - centre).norm() - 2.5 * 0.6, 2e-6);
    }
}

TEST(PlacedField, IsTheFieldScaledAtEveryLevel) {
    Random random(2);
    for (int run = 0; run < 10; ++run) {
        const auto field = random_sparse(random);
        const PlacedField placed(field, placement);
        const IndexBox box = random_box(random, -20, 20, 12);
        const int level = random_int(random, 0, 2);
        const auto of_field = copied(*field, box, level);
        const auto of_placed = copied(placed, box, level);
        const auto half_width = static_cast<float>(*placed.half_width_world());
        for (std::size_t i = 0; i < of_field.size(); ++i) {
            EXPECT_EQ(of_placed[i], 2.5F * of_field[i]);
            EXPECT_EQ(std::abs(of_placed[i]) >= half_width, std::abs(of_field[i]) >= 1.5F);
        }
        const ValueRange range = placed.value_range(box);
        for (const float value : copied(placed, box)) {
            EXPECT_GE(value, range.min);
            EXPECT_LE(value, range.max);
        }
    }
}

TEST(PlacedField, IsTheFieldItselfWhereNothingIsAsked) {
    Random random(3);
    const auto field = random_sparse(random);
    const PlacedField placed(field, {});
    const IndexBox box{Index3::Constant(-30), Index3::Constant(30)};
    EXPECT_EQ(copied(placed, box), copied(*field, box));
    EXPECT_EQ(placed.space().world_from_index.matrix(), field->space().world_from_index.matrix());
}

TEST(PlacedField, RefusesWhatIsNoPlacement) {
    Random random(4);
    const auto field = random_sparse(random);
    for (const double scale : {0.0, -1.0, std::nan("")})
        EXPECT_THROW(PlacedField(field, {.scale = scale}), InputError) << scale;
    EXPECT_THROW(PlacedField(field, {.translation_world = Vec3d::Constant(INFINITY)}), InputError);
}

} // namespace
} // namespace isocast::test
