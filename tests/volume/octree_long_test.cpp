// Octrees against maps of cells by the million changes, and many more damaged files: minutes.
// SPDX-License-Identifier: MPL-2.0
#include "octree_files.h"

namespace isocast::test {
namespace {

TEST(HashedOctree, IsAsMapsOfCellsAndNodesAreUnderMillionsOfRandomChanges) {
    for (int depth = 2; depth <= greatest_octree_depth; depth += 2)
        expect_as_oracle(static_cast<std::uint32_t>(100 + depth), depth, 300'000, 3);
}

TEST(OctreeFileErrors, DamagedByTheHundredThousandIsATreeOrRefused) {
    EXPECT_GT(read_damaged_octrees(5, 300'000), 0);
}

} // namespace
} // namespace isocast::test
