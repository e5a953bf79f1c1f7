// Nodes that hang on edges and faces of coarser cells.
// SPDX-License-Identifier: MPL-2.0
#include "volume/hanging_nodes.h"

#include <algorithm>

namespace isocast {

void HangingNodes::add(const HashedOctree& tree, const OctreeCell& divided) {
    const std::span<const HashedOctree::NodeNumber> nodes = tree.nodes_within(divided);
    const auto node_at = [&](const Index3& place) {
        return nodes[static_cast<std::size_t>(place.x() + 3 * place.y() + 9 * place.z())];
    };
    Index3 place;
    for (place.z() = 0; place.z() <= 2; ++place.z())
        for (place.y() = 0; place.y() <= 2; ++place.y())
            for (place.x() = 0; place.x() <= 2; ++place.x()) {
                const int inside = (place.x() & 1) + (place.y() & 1) + (place.z() & 1);
                if (inside == 0 || inside == 3) continue; // corners, and the middle of the cell
                const HashedOctree::NodeNumber node = node_at(place);
                if (node >= divided_.size())
                    divided_.resize(std::max<std::size_t>(node + 1, tree.node_count()));
                if (divided_[node]++ > 0) continue;
                Middle middle{.node = node,
                              .position = divided.position + place * (divided.size() / 2),
                              .axis = place.x() == 1   ? 0
                                      : place.y() == 1 ? 1
                                                       : 2,
                              .cells = 1};
                for (int axis = 0; axis < 3; ++axis)
                    if (place[axis] != 1 && middle.position[axis] != 0 &&
                        middle.position[axis] != tree.root().size())
                        middle.cells *= 2;
                middle.below = node_at(place - Index3::Unit(middle.axis));
                middle.above = node_at(place + Index3::Unit(middle.axis));
                middles_[static_cast<std::size_t>(divided.level)]
                        [static_cast<std::size_t>(inside - 1)]
                            .push_back(middle);
            }
}

void HangingNodes::constrain(HashedOctree& tree, const HashedOctree::NodeSampler& sampler,
                             const std::function<void(const Index3& position)>& changed) {
    for (int level = tree.depth(); level > 0; --level)
        for (std::vector<Middle>& middles : middles_[static_cast<std::size_t>(level)])
            std::erase_if(middles, [&](const Middle& middle) {
                const std::span<float> data = tree.data_of(middle.node);
                std::array<float, 8> before;
                std::ranges::copy(data, before.begin());
                const bool hangs = divided_[middle.node] < middle.cells;
                if (hangs)
                    midpoint(tree.filter(), tree.data_of(middle.below), tree.data_of(middle.above),
                             middle.axis, 1 << level, data);
                else if (tree.is_constrained(middle.node))
                    sampler(middle.position, data);
                tree.set_constrained(middle.node, hangs);
                if (!std::ranges::equal(data, std::span(before).first(data.size())))
                    changed(middle.position);
                return !hangs;
            });
}

} // namespace isocast
