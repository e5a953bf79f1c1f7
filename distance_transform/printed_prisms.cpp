// Prism scan conversion as printed: prisms are binned to blocks, and each block is scanned alone.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/printed_prisms.h"

#include "distance_transform/band_tiles.h"
#include "distance_transform/point_triangle.h"
#include "distance_transform/progress_meter.h"
#include "distance_transform/pseudonormals.h"
#include "volume/errors.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <atomic>
#include <cmath>

namespace isocast {

namespace {

struct BlockOfPrism {
    Index3 block;
    int triangle;
};

bool is_before(const BlockOfPrism& a, const BlockOfPrism& b) {
    if (a.block != b.block) return zyx_less(a.block, b.block);
    return a.triangle < b.triangle;
}

class PrismScan {
public:
    PrismScan(const LatticeMesh& lattice, double half_width, Gaps gaps, double memory_bytes)
        : mesh_(lattice.mesh), half_width_(half_width), memory_bytes_(memory_bytes),
          voxel_size_(lattice.space.voxel_size_world()), prisms_(mesh_, half_width, gaps),
          normals_(mesh_) {
        if (std::ranges::find(prisms_.rings().twins, -1) != prisms_.rings().twins.end())
            throw InputError("the mesh is not closed, as the thesis's prisms need");
    }

    ReferenceBand run(const Progress& progress) const {
        const std::vector<BlockOfPrism> pairs = bin(progress);
        std::vector<std::size_t> block_begin;
        for (std::size_t i = 0; i < pairs.size(); ++i)
            if (i == 0 || pairs[i].block != pairs[i - 1].block) block_begin.push_back(i);
        block_begin.push_back(pairs.size());

        require_memory(pairs.size() * sizeof(BlockOfPrism) +
                       block_begin.size() * sizeof(FieldBlock));
        FieldBlocks blocks(block_begin.size() - 1);
        ProgressMeter meter(progress, "transform", static_cast<double>(blocks.size()), 16);
        std::atomic<std::int64_t> evaluations = 0;
        tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t i) {
            const auto own =
                std::span(pairs).subspan(block_begin[i], block_begin[i + 1] - block_begin[i]);
            std::construct_at(&blocks[i]);
            evaluations += scan(blocks[i], own);
            meter.add(1);
        });
        std::erase_if(blocks, [](const FieldBlock& block) { return block.active.none(); });
        return {std::move(blocks), evaluations};
    }

private:
    void require_memory(std::size_t bytes) const {
        if (static_cast<double>(bytes) > memory_bytes_)
            refuse_memory(static_cast<double>(bytes), memory_bytes_);
    }

    std::array<Vec3d, 3> corners_of(int triangle) const {
        const auto [a, b, c] = mesh_.triangles[triangle];
        return {mesh_.vertices_world[a], mesh_.vertices_world[b], mesh_.vertices_world[c]};
    }

    /// All pairs of a prism and a block that may share samples, by block. Prisms of sharp edges are
    /// long; only what lies within the half width of the triangle's box is of use.
    std::vector<BlockOfPrism> bin(const Progress& progress) const {
        const int count = static_cast<int>(mesh_.triangles.size());
        ProgressMeter meter(progress, "prepare", count, 256);
        tbb::enumerable_thread_specific<std::vector<BlockOfPrism>> found;
        std::atomic<std::size_t> pair_count = 0;
        tbb::parallel_for(0, count, [&](int t) {
            const auto [a, b, c] = corners_of(t);
            const Vec3d reach = Vec3d::Constant(half_width_ + scan_slack);
            const WorldBox box{a.cwiseMin(b).cwiseMin(c) - reach,
                               a.cwiseMax(b).cwiseMax(c) + reach};
            const std::vector<Index3> blocks = blocks_meeting(prisms_.half_spaces(t), box);
            pair_count += blocks.size();
            require_memory(2 * pair_count * sizeof(BlockOfPrism)); // twice: per thread, and joined
            for (const Index3& block : blocks) found.local().push_back({block, t});
            meter.add(1);
        });
        std::vector<BlockOfPrism> pairs;
        for (const auto& part : found) pairs.insert(pairs.end(), part.begin(), part.end());
        tbb::parallel_sort(pairs.begin(), pairs.end(), is_before); // a total order: no threads seen
        return pairs;
    }

    std::int64_t scan(FieldBlock& block, std::span<const BlockOfPrism> own) const {
        BlockDistances distances;
        std::int64_t evaluations = 0;
        for (const BlockOfPrism& pair : own) {
            const int triangle = pair.triangle;
            const std::array<Vec3d, 3> corners = corners_of(triangle);
            scan_block(prisms_.half_spaces(triangle), pair.block, [&](const Index3& p, int i) {
                ++evaluations;
                const Vec3d point = p.cast<double>();
                const ClosestPoint closest = closest_point(point, corners);
                const Vec3d& normal = normals_.at(triangle, closest.feature);
                const double distance = std::sqrt(closest.squared_distance);
                distances.offer(i, (point - closest.p).dot(normal) < 0 ? -distance : distance);
            });
        }
        block = distances.to_block(own.front().block, half_width_, voxel_size_);
        return evaluations;
    }

    const Mesh& mesh_;
    double half_width_;
    double memory_bytes_;
    double voxel_size_;
    Prisms prisms_;
    Pseudonormals normals_;
};

} // namespace

ReferenceBand scan_convert_prisms(const LatticeMesh& lattice, double half_width_voxels, Gaps gaps,
                                  double memory_bytes, const Progress& progress) {
    return PrismScan(lattice, half_width_voxels, gaps, memory_bytes).run(progress);
}

} // namespace isocast
