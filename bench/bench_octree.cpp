// Thesis table 3.1 again: cells of an octree at random, hashed and linked; and OpenVDB.
// SPDX-License-Identifier: MPL-2.0
#include "octree/peers.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <openvdb/openvdb.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <random>
#include <tuple>

namespace isocast {
namespace {

constexpr double table_accesses = 50e6; // of the thesis's table

/// In [0, 1]^3; never more than the distance to the surface.
using Surface = std::function<double(const Vec3d& p)>;

// Radius and period (1) are chosen for about the thesis's numbers of cells: 1,473,373 at 9 levels
// of its second surface, 4,217,417 of its first.
double sphere(const Vec3d& p) {
    return (p - Vec3d::Constant(0.5)).norm() - 0.31;
}
double gyroid(const Vec3d& p) {
    const Vec3d s = (p * (2 * std::numbers::pi)).array().sin();
    const Vec3d c = (p * (2 * std::numbers::pi)).array().cos();
    // The gradient of the sum is at most sqrt(3) long.
    return (s.x() * c.y() + s.y() * c.z() + s.z() * c.x()) /
           (2 * std::numbers::pi * std::sqrt(3.0));
}

/// Divides all cells that may meet the surface, depth first, down to level 0.
HashedOctree refined(int depth, const Surface& surface) {
    const HashedOctree::NodeSampler sampler = [&](const Index3& p, std::span<float> out) {
        out[0] = static_cast<float>(surface(p.cast<double>() / (1 << depth)));
    };
    HashedOctree tree(depth, OctreeFilter::Linear, sampler);
    const auto refine = [&](const auto& self, const OctreeCell& cell) -> void {
        if (cell.level == 0) return;
        const double size = std::ldexp(cell.size(), -depth);
        const Vec3d centre =
            cell.position.cast<double>() / (1 << depth) + Vec3d::Constant(size / 2);
        if (std::abs(surface(centre)) > size * std::sqrt(3.0) / 2) return;
        tree.divide(cell, sampler);
        for (int i = 0; i < 8; ++i) self(self, child_of(cell, i));
    };
    refine(refine, tree.root());
    return tree;
}

CornerNodes nodes_at(const HashedOctree& tree, const OctreeCell& cell) {
    return tree.nodes_of(tree.find(cell).value());
}

template<class Peer>
Peer copy_of(const HashedOctree& tree) {
    Peer peer(tree.depth(), nodes_at(tree, tree.root()));
    tree.visit_cells([&](const OctreeCell& cell, bool is_leaf) {
        if (is_leaf) return;
        std::array<CornerNodes, 8> nodes;
        for (int i = 0; i < 8; ++i)
            nodes[static_cast<std::size_t>(i)] = nodes_at(tree, child_of(cell, i));
        peer.divide(cell, nodes);
    });
    return peer;
}

/// The least time of some rounds, and a sum of what was read, which must be the same for all.
struct Timing {
    double seconds = std::numeric_limits<double>::infinity();
    std::uint64_t sum = 0;

    /// Independent accesses; or each waits for the one before.
    template<class Queries, class Access>
    void add_round(const Queries& queries, bool is_chained, const Access& access) {
        const auto start = std::chrono::steady_clock::now();
        sum = 0;
        std::size_t wait = 0;
        if (is_chained) {
            for (std::size_t i = 0; i < queries.size(); ++i) {
                const std::uint32_t read = access(queries[i + wait]);
                sum += read;
                wait = read >> 31; // 0, but the processor does not know
            }
        } else {
            for (const auto& query : queries) sum += access(query);
        }
        const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
        seconds =
            std::min(seconds, taken.count() * table_accesses / static_cast<double>(queries.size()));
    }
};

struct Options {
    int least_depth = 5;
    int greatest_depth = 11;
    int rounds = 3;
    std::size_t queries = std::size_t{1} << 24;
    std::size_t most_cells = 30'000'000; // 9 GB with all structures
    bool is_chained = false;
    std::string only; // of the surfaces; empty takes both
};

/// A table's row for each structure: seconds for 50 M accesses, and the ratio to ours.
template<class Queries, class Access, class... Peers>
void print_row(const std::string& start, const Options& options, const Queries& queries,
               const Access& access, const Peers&... peers) {
    std::array<Timing, sizeof...(Peers)> timings;
    for (int round = 0; round < options.rounds; ++round) {
        std::size_t i = 0;
        (timings[i++].add_round(queries, options.is_chained,
                                [&](const auto& query) { return access(peers, query); }),
         ...);
    }
    fmt::print("{}", start);
    for (const Timing& timing : timings) {
        if (timing.sum != timings[0].sum) throw std::runtime_error("the structures disagree");
        fmt::print(" {:.2f} ({:.2f}) |", timing.seconds, timing.seconds / timings[0].seconds);
    }
    fmt::print("\n");
    std::fflush(stdout);
}

std::string row_start(const char* surface, const HashedOctree& tree, double average_level) {
    return fmt::format("| {} | {} | {} | {:.2f} |", surface, tree.depth(), tree.cell_count(),
                       average_level);
}

class OpenVdb {
public:
    explicit OpenVdb(const HashedOctree& tree) : grid_(openvdb::Int32Grid::create(-1)) {
        tree.visit_cells([&](const OctreeCell& cell, bool is_leaf) {
            if (!is_leaf) return;
            const openvdb::Coord lo(cell.position.x(), cell.position.y(), cell.position.z());
            grid_->fill(openvdb::CoordBBox::createCube(lo, cell.size()),
                        static_cast<int>(nodes_at(tree, cell)[0]));
        });
        accessor_.emplace(grid_->getConstAccessor());
    }
    std::uint32_t leaf_node_at(const Index3& p) const {
        return static_cast<std::uint32_t>(accessor_->getValue({p.x(), p.y(), p.z()}));
    }
    std::size_t structure_bytes() const { return grid_->memUsage(); }

private:
    openvdb::Int32Grid::Ptr grid_;
    mutable std::optional<openvdb::Int32Grid::ConstAccessor> accessor_;
};

void run(const Options& options) {
    const std::array<std::pair<const char*, Surface>, 2> surfaces = {
        {{"sphere", sphere}, {"gyroid", gyroid}}};
    std::string bytes;
    fmt::print(
        "| surface | levels | cells | average level | ours | {} | {} | {} | {} | OpenVDB |\n",
        LinkedTree::name, LinkedBlocks::name, ChainedCells::name, OpenCells::name);
    for (const auto& [name, surface] : surfaces) {
        if (!options.only.empty() && options.only != name) continue;
        for (int depth = options.least_depth; depth <= options.greatest_depth; ++depth) {
            const HashedOctree tree = refined(depth, surface);
            if (tree.cell_count() > options.most_cells) break;
            const Ours ours(tree);
            const auto linked = copy_of<LinkedTree>(tree);
            const auto blocks = copy_of<LinkedBlocks>(tree);
            const auto chained = copy_of<ChainedCells>(tree);
            const auto open = copy_of<OpenCells>(tree);
            const OpenVdb vdb(tree);

            std::vector<OctreeCell> cells;
            std::vector<OctreeCell> leaves;
            double level_sum = 0;
            tree.visit_cells([&](const OctreeCell& cell, bool is_leaf) {
                cells.push_back(cell);
                if (is_leaf) leaves.push_back(cell);
                level_sum += cell.level;
            });
            std::mt19937_64 random(1);
            std::vector<OctreeCell> queries(options.queries);
            for (OctreeCell& query : queries) query = cells[random() % cells.size()];
            const std::string start =
                row_start(name, tree, level_sum / static_cast<double>(cells.size()));
            print_row(
                "cell  " + start, options, queries,
                [](const auto& peer, const OctreeCell& cell) { return peer.node_of(cell); }, ours,
                linked, blocks, chained, open);
            std::vector<Index3> points(options.queries);
            for (Index3& point : points) {
                const OctreeCell& leaf = leaves[random() % leaves.size()];
                point = leaf.position;
                for (int axis = 0; axis < 3; ++axis)
                    point[axis] +=
                        static_cast<int>(random() & static_cast<unsigned>(leaf.size() - 1));
            }
            const auto at_point = [](const auto& peer, const Index3& p) {
                return peer.leaf_node_at(p);
            };
            print_row("point " + start, options, points, at_point, ours, linked, blocks, chained,
                      open, vdb);
            const auto per_cell = [&](const auto& peer) {
                return static_cast<double>(peer.structure_bytes()) /
                       static_cast<double>(cells.size());
            };
            fmt::print("bytes {} {:.1f} | {:.1f} | {:.1f} | {:.1f} | {:.1f} | {:.1f} in all |\n",
                       start, per_cell(ours), per_cell(linked), per_cell(blocks), per_cell(chained),
                       per_cell(open), per_cell(vdb));
        }
    }
}

} // namespace
} // namespace isocast

int main(int argc, char** argv) {
    isocast::Options options;
    CLI::App app{"Octrees, hashed and linked: seconds for 50 M accesses, and how many times ours"};
    app.add_option("--from", options.least_depth, "least number of levels");
    app.add_option("--to", options.greatest_depth, "greatest number of levels");
    app.add_option("--rounds", options.rounds, "rounds, of which the fastest counts");
    app.add_option("--queries", options.queries, "accesses a round");
    app.add_option("--most-cells", options.most_cells, "no trees of more cells");
    app.add_flag("--chained", options.is_chained, "each access waits for the one before");
    app.add_option("--only", options.only, "of the two surfaces")
        ->check(CLI::IsMember({"sphere", "gyroid"}));
    CLI11_PARSE(app, argc, argv);
    try {
        openvdb::initialize();
        isocast::run(options);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "bench_octree: %s\n", error.what());
        return 1;
    }
}
