// The thesis's ways to build an octree, beside which build_adaptive is tested and measured.
// SPDX-License-Identifier: MPL-2.0
#include "bench/adaptive/thesis_builders.h"

#include "bench/adaptive/mesh_in_cells.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <unordered_map>

namespace isocast {

namespace {

/// As build_adaptive: the root's corners are all outside, whatever it holds.
constexpr int divided_levels = 3;

/// The distance at integer positions.
class Samples {
public:
    explicit Samples(const ExactDistance& distance) : distance_(distance) {}
    float at(const Index3& p) {
        const auto bits = [&](int axis) { return static_cast<std::uint64_t>(p[axis]); };
        const auto [found, is_new] = values_.try_emplace(bits(0) | bits(1) << 21 | bits(2) << 42);
        if (is_new)
            found->second = static_cast<float>(distance_.at(p.cast<double>(), hint_).distance);
        return found->second;
    }
    HashedOctree::NodeSampler sampler() {
        return [this](const Index3& position, std::span<float> out) { out[0] = at(position); };
    }
    std::size_t evaluations() const { return values_.size(); }

private:
    const ExactDistance& distance_;
    ExactDistance::Hint hint_ = 0;
    std::unordered_map<std::uint64_t, float> values_;
};

/// Whether nodes of a cell, `step` finest cells apart, are on both sides.
bool is_cut(Samples& samples, const OctreeCell& cell, int step) {
    const bool is_inside = samples.at(cell.position) < 0;
    for (int z = 0; z <= cell.size(); z += step)
        for (int y = 0; y <= cell.size(); y += step)
            for (int x = 0; x <= cell.size(); x += step)
                if ((samples.at(cell.position + Index3(x, y, z)) < 0) != is_inside) return true;
    return false;
}

bool is_far(Samples& samples, const OctreeCell& cell) {
    for (int i = 0; i < 8; ++i) {
        const Index3 corner = cell.position + cell.size() * Index3(i & 1, i >> 1 & 1, i >> 2);
        if (std::abs(samples.at(corner)) <= std::numbers::sqrt3 / 2 * cell.size()) return false;
    }
    return true;
}

} // namespace

ThesisTree built_top_down(const ExactDistance& distance, int depth, int look_ahead) {
    Samples samples(distance);
    HashedOctree tree(depth, OctreeFilter::Linear, samples.sampler());
    const auto must_divide = [&](const OctreeCell& cell) {
        if (depth - cell.level < divided_levels) return true;
        if (is_cut(samples, cell, cell.size())) return true;
        return look_ahead > 0 && !is_far(samples, cell) &&
               is_cut(samples, cell, std::max(cell.size() >> look_ahead, 1));
    };
    const auto grow = [&](const auto& self, const OctreeCell& cell) -> void {
        if (cell.level == 0 || !must_divide(cell)) return;
        tree.divide(cell, samples.sampler());
        for (int i = 0; i < 8; ++i) self(self, child_of(cell, i));
    };
    grow(grow, tree.root());
    tree.constrain_hanging_nodes(samples.sampler());
    return {std::move(tree), samples.evaluations()};
}

ThesisTree built_bottom_up(const ExactDistance& distance, int depth) {
    const int nodes_across = (1 << depth) + 1;
    const auto place_of = [=](const Index3& p) {
        return static_cast<std::size_t>(p.x()) +
               static_cast<std::size_t>(nodes_across) *
                   (static_cast<std::size_t>(p.y()) +
                    static_cast<std::size_t>(nodes_across) * static_cast<std::size_t>(p.z()));
    };
    std::vector<float> values;
    ExactDistance::Hint hint = 0;
    for (int z = 0; z < nodes_across; ++z)
        for (int y = 0; y < nodes_across; ++y)
            for (int x = 0; x < nodes_across; ++x)
                values.push_back(static_cast<float>(distance.at(Vec3d(x, y, z), hint).distance));
    // A cell's finest cells hang together by their nodes: if none of them is cut, all of its nodes
    // are on one side.
    std::vector<CellSet> cut;
    for (int level = 0; level <= depth; ++level) cut.emplace_back(depth - level);
    for (int z = 0; z + 1 < nodes_across; ++z)
        for (int y = 0; y + 1 < nodes_across; ++y)
            for (int x = 0; x + 1 < nodes_across; ++x) {
                int inside = 0;
                for (int i = 0; i < 8; ++i)
                    inside += values[place_of({x + (i & 1), y + (i >> 1 & 1), z + (i >> 2)})] < 0;
                if (inside == 0 || inside == 8) continue;
                for (int level = 0; level <= depth; ++level)
                    cut[static_cast<std::size_t>(level)].insert(
                        {x >> level, y >> level, z >> level});
            }
    const HashedOctree::NodeSampler sampler = [&](const Index3& position, std::span<float> out) {
        out[0] = values[place_of(position)];
    };
    HashedOctree tree(depth, OctreeFilter::Linear, sampler);
    const auto grow = [&](const auto& self, const OctreeCell& cell) -> void {
        const Index3 at = floor_div(cell.position, cell.size());
        if (cell.level == 0 || !cut[static_cast<std::size_t>(cell.level)].contains(at)) return;
        tree.divide(cell, sampler);
        for (int i = 0; i < 8; ++i) self(self, child_of(cell, i));
    };
    grow(grow, tree.root());
    tree.constrain_hanging_nodes(sampler);
    return {std::move(tree), values.size()};
}

} // namespace isocast
