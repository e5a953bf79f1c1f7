// Which blocks the band can reach: an octree of blocks is descended, triangles are culled.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/band_blocks.h"

#include "distance_transform/point_triangle.h"
#include "distance_transform/progress_meter.h"
#include "volume/errors.h"
#include "volume/sparse_field.h"

#include <fmt/format.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <numbers>
#include <numeric>
#include <optional>

namespace isocast {

namespace {

[[noreturn]] void refuse(double bytes, double memory_bytes) {
    constexpr double gibibyte = 0x1p30;
    throw ResourceError(fmt::format(
        "the field would take at least {:.3g} GiB, and {:.3g} GiB of memory are available; use a "
        "larger voxel size or a narrower band",
        bytes / gibibyte, memory_bytes / gibibyte));
}

/// A number of blocks that the field surely has, from areas and lengths alone.
double least_block_count(const Mesh& mesh, double half_width) {
    constexpr double edge = block_size;
    // No plane cuts a larger area out of a cube than through two opposite edges.
    const double largest_section = edge * edge * std::numbers::sqrt2;
    const double longest_chord = edge * std::numbers::sqrt3;
    double area = 0;
    double longest_edge = 0;
    for (const auto& [ia, ib, ic] : mesh.triangles) {
        const Vec3d u = mesh.vertices_world[ib] - mesh.vertices_world[ia];
        const Vec3d v = mesh.vertices_world[ic] - mesh.vertices_world[ia];
        area += u.cross(v).norm() / 2;
        longest_edge = std::max({longest_edge, u.norm(), v.norm()});
    }
    // A block may hold several sheets of the surface: four full sections are more than most do.
    constexpr double sheets = 4;
    const double ball = 4 * std::numbers::pi / 3 * std::pow(half_width, 3);
    return std::max({area / (sheets * largest_section), longest_edge / longest_chord,
                     ball / samples_per_block});
}

class BandBlockFinder {
public:
    BandBlockFinder(const LatticeMesh& lattice, double half_width, double memory_bytes,
                    const Progress& progress)
        : mesh_(lattice.mesh), half_width_(half_width), memory_bytes_(memory_bytes),
          boxes_(mesh_.triangles.size()) {
        for (std::size_t i = 0; i < boxes_.size(); ++i) {
            const std::array<Vec3d, 3> corners = corners_of(static_cast<int>(i));
            boxes_[i] = {corners[0].cwiseMin(corners[1]).cwiseMin(corners[2]),
                         corners[0].cwiseMax(corners[1]).cwiseMax(corners[2])};
        }
        const Vec3d reach = Vec3d::Constant(half_width + culling_slack);
        first_ = ((lattice.box.min - reach) / block_size).array().floor().cast<int>();
        const Index3 last = ((lattice.box.max + reach) / block_size).array().floor().cast<int>();
        size_ =
            static_cast<int>(std::bit_ceil(static_cast<unsigned>((last - first_).maxCoeff()) + 1));
        meter_.emplace(progress, "prepare", std::pow(size_, 3), 256);
    }

    BandBlocks run() {
        std::vector<int> all(mesh_.triangles.size());
        std::iota(all.begin(), all.end(), 0);
        visit(first_, size_, all);

        BandBlocks result;
        for (Found& found : found_) {
            for (BandBlock& block : found.blocks)
                block.list = static_cast<std::uint32_t>(result.lists.size());
            result.blocks.insert(result.blocks.end(), found.blocks.begin(), found.blocks.end());
            result.lists.push_back(std::move(found.list));
        }
        std::ranges::sort(result.blocks, zyx_less, &BandBlock::coordinate);
        result.distance_evaluations = evaluations_;
        return result;
    }

private:
    struct Found {
        std::vector<BandBlock> blocks;
        std::vector<int> list;
    };

    std::array<Vec3d, 3> corners_of(int triangle) const {
        const auto [a, b, c] = mesh_.triangles[triangle];
        return {mesh_.vertices_world[a], mesh_.vertices_world[b], mesh_.vertices_world[c]};
    }

    /// The cube of size^3 blocks from block `first` on.
    void visit(const Index3& first, int size, std::span<const int> candidates) {
        const Vec3d least = block_size * first.cast<double>();
        const Vec3d greatest = least + Vec3d::Constant(block_size * double(size) - 1);
        std::vector<int> kept = near_box(candidates, least, greatest);
        // Where a node is large against the band, or holds many triangles, boxes cull as well as
        // distances and cost less.
        const double radius = (greatest - least).norm() / 2;
        if (size == 1 || kept.size() <= 64 || radius <= 2 * half_width_)
            cull_by_distance(kept, (least + greatest) / 2, radius);
        if (kept.empty() || size == 1) {
            if (!kept.empty()) emit(first, kept);
            meter_->add(std::pow(size, 3));
            return;
        }
        const int half = size / 2;
        const auto visit_child = [&](int child) {
            visit(first + half * Index3(child & 1, child >> 1 & 1, child >> 2), half, kept);
        };
        // Below so many pairs of triangles and children a task costs more than it does.
        if (kept.size() * half > 64) {
            tbb::parallel_for(0, 8, visit_child);
        } else {
            for (int child = 0; child < 8; ++child) visit_child(child);
        }
    }

    std::vector<int> near_box(std::span<const int> candidates, const Vec3d& least,
                              const Vec3d& greatest) const {
        const double reach = half_width_ + culling_slack;
        std::vector<int> kept;
        for (const int i : candidates) {
            const Vec3d gap =
                (boxes_[i].min - greatest).cwiseMax(least - boxes_[i].max).cwiseMax(Vec3d::Zero());
            if (gap.squaredNorm() <= reach * reach) kept.push_back(i);
        }
        return kept;
    }

    void cull_by_distance(std::vector<int>& kept, const Vec3d& centre, double radius) {
        std::vector<double> distances;
        distances.reserve(kept.size());
        for (const int i : kept)
            distances.push_back(std::sqrt(closest_point(centre, corners_of(i)).squared_distance));
        evaluations_ += std::ssize(kept);
        double bound = half_width_ + radius;
        for (const double d : distances) bound = std::min(bound, d + 2 * radius);
        std::size_t next = 0;
        for (std::size_t k = 0; k < kept.size(); ++k)
            if (distances[k] <= bound + culling_slack) kept[next++] = kept[k];
        kept.resize(next);
    }

    void emit(const Index3& coordinate, const std::vector<int>& triangles) {
        const double bytes = bytes_.fetch_add(sizeof(FieldBlock) + sizeof(BandBlock) +
                                              triangles.size() * sizeof(int));
        if (bytes > memory_bytes_) refuse(bytes, memory_bytes_);
        Found& found = found_.local();
        found.blocks.push_back({.coordinate = coordinate,
                                .list = 0,
                                .count = static_cast<std::uint32_t>(triangles.size()),
                                .first = found.list.size()});
        found.list.insert(found.list.end(), triangles.begin(), triangles.end());
    }

    const Mesh& mesh_;
    double half_width_;
    double memory_bytes_;
    std::vector<WorldBox> boxes_; // of the triangles
    Index3 first_;
    int size_;
    std::optional<ProgressMeter> meter_;
    tbb::enumerable_thread_specific<Found> found_;
    std::atomic<std::int64_t> evaluations_ = 0;
    std::atomic<double> bytes_ = 0;
};

} // namespace

BandBlocks find_band_blocks(const LatticeMesh& lattice, double half_width_voxels,
                            double memory_bytes, const Progress& progress) {
    const double least = least_block_count(lattice.mesh, half_width_voxels) * sizeof(FieldBlock);
    if (least > memory_bytes) refuse(least, memory_bytes);
    return BandBlockFinder(lattice, half_width_voxels, memory_bytes, progress).run();
}

} // namespace isocast
