// Boxes in float miss no item, however close to the reach it lies.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/box_tree.h"

#include "../../volume/random_fields.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace isocast::test {

TEST(BoxTree, VisitsEachItemExactlyAtTheReach) {
    Random random(72);
    for (const std::int32_t leaf_items : {1, 4, 8})
        for (const double away : {0.0, 1e6}) {
            std::vector<WorldBox> boxes;
            for (int i = 0; i < 301; ++i) {
                const Vec3d p = Vec3d::Constant(away) + random_point(random, -100, 100);
                boxes.push_back({p, p});
            }
            const BoxTree tree(boxes, leaf_items);
            for (int i = 0; i < 20000; ++i) {
                const auto item = random_int(random, 0, 300);
                const Vec3d& q = boxes[static_cast<std::size_t>(item)].min;
                const Vec3d p =
                    q + std::exp(random_real(random, -25, 3)) * random_point(random, -1, 1);
                bool is_near = false;
                const auto note = [&](bool& is_found) {
                    return [&](std::int32_t first, std::int32_t end) {
                        const auto items = tree.order().subspan(
                            static_cast<std::size_t>(first), static_cast<std::size_t>(end - first));
                        is_found = is_found || std::ranges::find(items, item) != items.end();
                        EXPECT_EQ(first % leaf_items, 0);
                        EXPECT_LE(end - first, leaf_items);
                    };
                };
                const double squared = (p - q).squaredNorm();
                tree.visit_near(
                    p, [&] { return squared; }, note(is_near));
                bool is_touching = false;
                tree.visit_touching(
                    p, (p - q).cwiseAbs().maxCoeff(), [] { return true; }, note(is_touching));
                ASSERT_TRUE(is_near) << std::sqrt(squared) << " away";
                ASSERT_TRUE(is_touching) << std::sqrt(squared) << " away";
            }
        }
}

TEST(BoxTree, OfNothingVisitsNothing) {
    const BoxTree tree({}, 4);
    tree.visit_near(
        Vec3d::Zero(), [] { return 1.0; }, [](std::int32_t, std::int32_t) { ADD_FAILURE(); });
    EXPECT_TRUE(tree.order().empty());
}

} // namespace isocast::test
