// Which blocks the band can reach: an octree of blocks is descended, triangles are culled.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/band_blocks.h"

#include "distance_transform/block_descent.h"
#include "distance_transform/progress_meter.h"
#include "volume/errors.h"
#include "volume/sparse_field.h"

#include <fmt/format.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

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

/// A node of the octree: size^3 blocks from block `first` on.
struct Node {
    Index3 first;
    int size;

    Node child(int k) const {
        const int half = size / 2;
        return {first + half * Index3(k & 1, k >> 1 & 1, k >> 2), half};
    }
    Vec3d first_sample() const { return block_size * first.cast<double>(); }
    double extent() const { return block_size * double(size) - 1; }
};

class BandBlockFinder {
public:
    BandBlockFinder(const LatticeMesh& lattice, std::span<const TriangleFrame> frames,
                    double half_width, double memory_bytes, const Progress& progress)
        : frames_(frames), half_width_(half_width), memory_bytes_(memory_bytes),
          boxes_(frames.size()) {
        const Vec3d reach = Vec3d::Constant(half_width + culling_slack);
        const Mesh& mesh = lattice.mesh;
        tbb::parallel_for(tbb::blocked_range<std::size_t>(0, boxes_.size(), 4096), [&](auto&
                                                                                           range) {
            for (std::size_t i = range.begin(); i < range.end(); ++i) {
                const auto [ia, ib, ic] = mesh.triangles[i];
                const Vec3d& a = mesh.vertices_world[ia];
                const Vec3d& b = mesh.vertices_world[ib];
                const Vec3d& c = mesh.vertices_world[ic];
                boxes_[i] = {a.cwiseMin(b).cwiseMin(c) - reach, a.cwiseMax(b).cwiseMax(c) + reach};
            }
        });
        root_.first = ((lattice.box.min - reach) / block_size).array().floor().cast<int>();
        const Index3 last = ((lattice.box.max + reach) / block_size).array().floor().cast<int>();
        root_.size = static_cast<int>(
            std::bit_ceil(static_cast<unsigned>((last - root_.first).maxCoeff()) + 1));
        meter_.emplace(progress, "prepare", std::pow(root_.size, 3), 256);
    }

    BandBlocks run() {
        std::vector<int> all(frames_.size());
        std::iota(all.begin(), all.end(), 0);
        visit(root_, all);

        BandBlocks result;
        for (Found& found : found_) {
            for (BandBlock& block : found.blocks)
                block.list = static_cast<std::uint32_t>(result.lists.size());
            result.blocks.insert(result.blocks.end(), found.blocks.begin(), found.blocks.end());
            result.lists.push_back(std::move(found.list));
        }
        tbb::parallel_sort(result.blocks.begin(), result.blocks.end(),
                           [](const BandBlock& a, const BandBlock& b) {
                               return zyx_less(a.coordinate, b.coordinate);
                           });
        result.distance_evaluations = evaluations_;
        return result;
    }

private:
    struct Found {
        std::vector<BandBlock> blocks;
        std::vector<int> list;
        DescentWorkspace workspace;
    };
    using Lists = std::array<std::vector<int>, 8>;

    void visit(const Node& node, std::span<const int> triangles) {
        if (node.size == 1) {
            emit(node.first, triangles);
            meter_->add(1);
            return;
        }
        const double child_extent = node.child(0).extent();
        // Distances cull where the children are small against the band.
        Lists lists = std::sqrt(3.0) / 2 * child_extent < half_width_
                          ? split_by_distance(node, triangles)
                          : split_by_boxes(node, triangles);
        const auto visit_child = [&](int k) {
            if (lists[k].empty())
                meter_->add(std::pow(node.size / 2, 3));
            else
                visit(node.child(k), lists[k]);
        };
        // Below so many pairs of triangles and children a task costs more than it does.
        if (triangles.size() * static_cast<std::size_t>(node.size) > 512)
            tbb::parallel_for(0, 8, visit_child);
        else
            for (int k = 0; k < 8; ++k) visit_child(k);
    }

    /// Boxes by halves of each axis, then the planes of the few that are left.
    Lists split_by_boxes(const Node& node, std::span<const int> triangles) const {
        const double child_radius = node.child(0).extent() / 2;
        const Vec3d middle = node.first_sample() + Vec3d::Constant(node.extent() / 2);
        Lists lists;
        for (std::vector<int>& list : lists) list.reserve(triangles.size() / 4 + 8);
        for (const int i : triangles) {
            unsigned children = 0xff;
            for (int k = 0; k < 3; ++k) {
                constexpr std::array<unsigned, 3> low = {0x55, 0x33, 0x0f};
                // The last sample of the lower half and the first of the upper one.
                const bool is_low = boxes_[i].min[k] <= middle[k] - 0.5;
                const bool is_high = boxes_[i].max[k] >= middle[k] + 0.5;
                children &= (is_low ? low[k] : 0) | (is_high ? ~low[k] : 0);
            }
            const Eigen::Map<const Vec3d> normal(frames_[i].t);
            const double reach =
                half_width_ + culling_slack + child_radius * normal.cwiseAbs().sum();
            const double height = normal.dot(middle - Eigen::Map<const Vec3d>(frames_[i].origin));
            const Vec3d step = (child_radius + 0.5) * normal;
            for (; children != 0; children &= children - 1) {
                const int k = std::countr_zero(children);
                const double child_height = height + (k & 1 ? step.x() : -step.x()) +
                                            (k & 2 ? step.y() : -step.y()) +
                                            (k & 4 ? step.z() : -step.z());
                if (std::abs(child_height) <= reach) lists[k].push_back(i);
            }
        }
        return lists;
    }

    Lists split_by_distance(const Node& node, std::span<const int> triangles) {
        const Vec3d first = node.first_sample();
        const DescentInput input{.frames = frames_.data(),
                                 .candidates = triangles.data(),
                                 .candidate_count = static_cast<int>(triangles.size()),
                                 .first_sample = {first.x(), first.y(), first.z()},
                                 .half_width = half_width_ + culling_slack};
        SplitOutput children;
        evaluations_ +=
            kernels_.split(input, block_size * node.size / 2, found_.local().workspace, children);
        Lists lists;
        for (int k = 0; k < 8; ++k)
            lists[k].assign(children.list[k], children.list[k] + children.count[k]);
        return lists;
    }

    void emit(const Index3& coordinate, std::span<const int> triangles) {
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

    std::span<const TriangleFrame> frames_;
    double half_width_;
    double memory_bytes_;
    std::vector<WorldBox> boxes_; // of the triangles, grown by the half width
    Node root_;
    std::optional<ProgressMeter> meter_;
    const DescentKernels& kernels_ = descent_kernels(best_instruction_set());
    tbb::enumerable_thread_specific<Found> found_;
    std::atomic<std::int64_t> evaluations_ = 0;
    std::atomic<double> bytes_ = 0;
};

} // namespace

BandBlocks find_band_blocks(const LatticeMesh& lattice, std::span<const TriangleFrame> frames,
                            double half_width_voxels, double memory_bytes,
                            const Progress& progress) {
    const double least = least_block_count(lattice.mesh, half_width_voxels) * sizeof(FieldBlock);
    if (least > memory_bytes) refuse(least, memory_bytes);
    return BandBlockFinder(lattice, frames, half_width_voxels, memory_bytes, progress).run();
}

} // namespace isocast
