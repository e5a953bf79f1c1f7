// The table of what is inside, against minima and maxima, and trees that are wrong.
// SPDX-License-Identifier: MPL-2.0
#include "csg_trees.h"
#include "volume/errors.h"

namespace isocast::test {
namespace {

TEST(CsgTree, TableHasTheSignsOfMinimaAndMaxima) {
    Random random(1);
    for (int run = 0; run < 300; ++run) {
        const int count = random_int(random, 1, max_object_count);
        const CsgTree tree = random_tree(random, count);
        check_tree(tree, count);
        const InsideTable table = inside_table(tree, count);
        std::vector<double> values;
        unsigned set = 0;
        for (int i = 0; i < count; ++i) {
            values.push_back(random_real(random, -1, 1));
            set |= (values.back() < 0 ? 1U : 0U) << i;
        }
        EXPECT_EQ(table.is_inside(set), composed_value(tree, values) < 0);
    }
}

TEST(CsgTree, ObeysDeMorgan) {
    const auto words = [](const CsgTree& tree) { return inside_table(tree, 3).words; };
    const CsgStep a{Object, 0};
    const CsgStep b{Object, 1};
    const CsgStep c{Object, 2};
    EXPECT_EQ(words({a, b, c, {Union}, {Difference}}),
              words({a, b, {Difference}, a, c, {Difference}, {Intersection}}));
    EXPECT_EQ(words({a, b, c, {Intersection}, {Difference}}),
              words({a, b, {Difference}, a, c, {Difference}, {Union}}));
    EXPECT_EQ(words({a, b, c, {Union}, {Intersection}}),
              words({a, b, {Intersection}, a, c, {Intersection}, {Union}}));
    EXPECT_NE(words({a, b, c, {Union}, {Intersection}}), words({a, b, {Union}, c, {Intersection}}));
}

TEST(CsgTree, SaysAllThatIsWrong) {
    try {
        check_tree({{Object, 0}, {Union}, {Object, 3}}, 2);
        FAIL() << "no error";
    } catch (const InputError& error) {
        EXPECT_STREQ(error.what(),
                     "CSG tree: step 1 has less than two operands; step 2 names object "
                     "3, and there are 2; 2 operands are left, not one; object 1 is "
                     "not named");
    }
    EXPECT_THROW(check_tree({}, 1), InputError);
}

} // namespace
} // namespace isocast::test
