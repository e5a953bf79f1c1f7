// An octree that was built, as a field source on the lattices of all levels.
// SPDX-License-Identifier: MPL-2.0
#include "volume/octree_field.h"

#include "adaptive_fields.h"
#include "volume/cell_bounds.h"

namespace isocast::test {
namespace {

constexpr int depth = 6;

std::shared_ptr<const HashedOctree> tree_of(const std::string& name, OctreeFilter filter,
                                            std::optional<double> max_error) {
    const MeshInCells input(mesh_in_cells(sample_mesh(name), depth));
    return std::make_shared<const HashedOctree>(build_adaptive(
        input.distance(), {.depth = depth, .filter = filter, .max_error_cells = max_error}));
}

/// Calls at_tree for trees of both filters, coarse ones and one down to the finest.
template<class AtTree>
void for_each_tree(const AtTree& at_tree) {
    for (const OctreeFilter filter : octree_filters)
        for (const std::optional<double> max_error : {std::optional(0.3), std::optional(2.0), {}})
            at_tree(tree_of("seashell", filter, max_error));
}

TEST(OctreeField, CopiesOfBoxesAreTheTreesValues) {
    Random random(1);
    for_each_tree([&](const auto& tree) {
        for (int lattice = 0; lattice <= depth; ++lattice) {
            const OctreeField field(tree, GridSpace::uniform(0.5), 0, lattice);
            for (int level = 0; lattice + level <= depth; ++level) {
                const int across = 1 << (depth - lattice - level);
                // Some reach beyond the extent, where the border continues.
                const IndexBox box = random_box(random, -3, across, 12);
                const std::vector<float> values = copied(field, box, level);
                std::size_t i = 0;
                for_each_sample(box, [&](const Index3& at) {
                    const Vec3d p = std::exp2(lattice + level) * at.cast<double>();
                    ASSERT_EQ(values[i++], tree->value_at(p)) << p.transpose();
                });
            }
        }
    });
}

TEST(OctreeField, RangesHoldAllSamples) {
    Random random(2);
    for_each_tree([&](const auto& tree) {
        for (int lattice = 0; lattice <= 2; ++lattice) {
            const OctreeField field(tree, GridSpace::uniform(0.5), 0, lattice);
            for (int i = 0; i < 30; ++i) {
                const IndexBox box = random_box(random, -4, (1 << (depth - lattice)) + 3, 9);
                const ValueRange range = field.value_range(box);
                for (const float value : copied(field, box)) {
                    ASSERT_LE(range.min, value);
                    ASSERT_GE(range.max, value);
                }
            }
        }
    });
}

// A crossing between two samples lies in the four cells around their edge; the cell above them
// belongs to the lower sample's box.
TEST(OctreeField, ActiveBoxesHoldEveryChangeOfSign) {
    for_each_tree([](const auto& tree) {
        for (int lattice = 0; lattice <= 3; ++lattice) {
            const OctreeField field(tree, GridSpace::uniform(1), 0, lattice);
            const IndexBox all = field.extent();
            const int across = all.size().x();
            const std::vector<float> values = copied(field, all);
            std::vector<int> boxes_at(values.size());
            const auto place_of = [&](const Index3& at) {
                return static_cast<std::size_t>(at.x() + across * (at.y() + across * at.z()));
            };
            for (const IndexBox& box : field.active_boxes())
                for_each_sample(box, [&](const Index3& at) { ++boxes_at[place_of(at)]; });
            EXPECT_LE(std::ranges::max(boxes_at), 1); // they do not overlap
            int changes = 0;
            for_each_sample(all, [&](const Index3& at) {
                for (int axis = 0; axis < 3; ++axis) {
                    const Index3 next = at + Index3::Unit(axis);
                    if (next[axis] == across ||
                        (values[place_of(at)] < 0) == (values[place_of(next)] < 0))
                        continue;
                    ++changes;
                    ASSERT_EQ(boxes_at[place_of(at)], 1) << at.transpose();
                }
            });
            EXPECT_GT(changes, 50);
        }
    });
}

/// A big sphere in cells of 2^5, a speck on it and one beside it in cells of 1.
std::shared_ptr<const HashedOctree> tree_of_many_levels() {
    const auto sphere = [](const Vec3d& p) {
        return (p - Vec3d(480.2, 490.1, 500.3)).norm() - 400;
    };
    const auto specks = [](const Vec3d& p) {
        return std::min((p - Vec3d(880.3, 490.2, 500.1)).norm(),
                        (p - Vec3d(951.3, 945.2, 950.9)).norm()) -
               4.3;
    };
    const HashedOctree::NodeSampler sampler = [&](const Index3& at, std::span<float> out) {
        const Vec3d p = at.cast<double>();
        out[0] = static_cast<float>(std::min(sphere(p), specks(p)));
    };
    HashedOctree tree(10, OctreeFilter::Linear, sampler);
    const auto divide = [&](const auto& self, const OctreeCell& cell) -> void {
        const Vec3d centre = (cell.position.cast<double>().array() + cell.size() / 2.0).matrix();
        const double radius = std::numbers::sqrt3 / 2 * cell.size();
        const bool has_speck = std::abs(specks(centre)) <= radius && cell.level > 0;
        const bool has_sphere = std::abs(sphere(centre)) <= radius && cell.level > 5;
        if (!has_speck && !has_sphere) return;
        tree.divide(cell, sampler);
        for (int i = 0; i < 8; ++i) self(self, child_of(cell, i));
    };
    divide(divide, tree.root());
    tree.constrain_hanging_nodes(sampler);
    return std::make_shared<const HashedOctree>(std::move(tree));
}

// Each leaf that holds a piece of the surface is shown by one field, which has all of its detail.
TEST(OctreeField, FieldsOfManyLevelsShareTheSurfaceOut) {
    const auto tree = tree_of_many_levels();
    std::size_t most_fields = 0;
    for (const std::size_t greatest_block_count : {1u << 18, 1u}) {
        const auto fields = fields_of_octree(tree, GridSpace::uniform(1), 0, greatest_block_count);
        most_fields = std::max(most_fields, fields.size());
        std::vector<CellSet> shown_by; // samples of each field
        for (const auto& field : fields) {
            shown_by.emplace_back(tree->depth() - field->lattice());
            for (const IndexBox& box : field->active_boxes())
                for_each_sample(
                    intersection(box, {Index3::Zero(), Index3::Constant(shown_by.back().across())}),
                    [&](const Index3& at) { shown_by.back().insert(at); });
        }
        int shown = 0;
        tree->visit_cells([&](const OctreeCell& leaf, bool is_leaf) {
            if (!is_leaf) return;
            CornerData corners;
            const auto nodes = tree->nodes_of(tree->find(leaf).value());
            for (std::size_t i = 0; i < 8; ++i) corners[i] = tree->data_of(nodes[i]).data();
            const CellBounds bounds = bounds_of(tree->filter(), corners, leaf.size());
            if (bounds.min > 0 || bounds.max < 0) return;
            ++shown;
            int count = 0;
            for (std::size_t i = 0; i < fields.size(); ++i) {
                const OctreeField& field = *fields[i];
                const Index3 at = floor_div(leaf.position, 1 << field.lattice());
                const bool is_in = shown_by[i].contains(at);
                if (fields.size() > 1) {
                    EXPECT_EQ(field.finest_level({at, (at.array() + 1).matrix()}) >= 0, is_in);
                }
                if (!is_in) continue;
                ++count;
                EXPECT_GE(leaf.level, field.lattice());
            }
            ASSERT_EQ(count, 1) << leaf.position.transpose() << " level " << leaf.level;
        });
        EXPECT_GT(shown, 500);
    }
    EXPECT_GT(most_fields, 1u);
}

} // namespace
} // namespace isocast::test
