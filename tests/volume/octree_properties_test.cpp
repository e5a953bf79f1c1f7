// Octrees against maps of cells and nodes, under changes that shrink to the fewest that fail.
// SPDX-License-Identifier: MPL-2.0
#include "octree_oracle.h"

#include <gtest/gtest-spi.h>
#include <rapidcheck.h>

namespace isocast {
namespace {

constexpr int depth = 4;

struct Change {
    std::array<int, 3> finest; // just out of the tree too
    std::optional<int> merged_level;
};

void showValue(const Change& change, std::ostream& out) {
    const auto& [x, y, z] = change.finest;
    out << (change.merged_level ? "merge at (" : "divide at (") << x << ", " << y << ", " << z
        << ')';
    if (change.merged_level) out << " of level " << *change.merged_level;
}

rc::Gen<Change> any_change() {
    return rc::gen::apply(
        [](std::array<int, 3> finest, bool merges, int level) {
            return Change{finest, merges ? std::optional(level) : std::nullopt};
        },
        rc::gen::container<std::array<int, 3>>(rc::gen::inRange(-1, (1 << depth) + 1)),
        rc::gen::arbitrary<bool>(), rc::gen::inRange(0, depth + 1));
}

/// What googletest's assertions found wrong in `body`; nothing is reported.
template<class Body>
std::string failures_of(const Body& body) {
    ::testing::TestPartResultArray results;
    {
        const ::testing::ScopedFakeTestPartResultReporter reporter(
            ::testing::ScopedFakeTestPartResultReporter::INTERCEPT_ONLY_CURRENT_THREAD, &results);
        body();
    }
    return results.size() > 0 ? results.GetTestPartResult(0).message() : "";
}

TEST(HashedOctree, IsAsMapsOfCellsAndNodesAreWhateverTheChanges) {
    EXPECT_TRUE(rc::check([] {
        const auto changes = *rc::gen::container<std::vector<Change>>(any_change());
        const std::string failures = failures_of([&] {
            test::OctreePair pair(depth);
            test::Random random(1);
            for (const Change& change : changes) {
                pair.change_at({change.finest[0], change.finest[1], change.finest[2]},
                               change.merged_level);
                pair.expect_same_look_ups(random);
            }
            pair.expect_same();
        });
        RC_ASSERT(failures == "");
    }));
}

} // namespace
} // namespace isocast
