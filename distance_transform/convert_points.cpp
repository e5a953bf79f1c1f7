// From points to distance field: lattice, blocks near points, distances, signs.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/convert_points.h"

#include "distance_transform/band_tiles.h"
#include "distance_transform/block_signs.h"
#include "distance_transform/lattice.h"
#include "distance_transform/mended_signs.h"
#include "distance_transform/open_mesh_signs.h"
#include "distance_transform/point_gaps.h"
#include "distance_transform/progress_meter.h"
#include "volume/available_memory.h"
#include "volume/errors.h"
#include "volume/stopwatch.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace isocast {

namespace {

/// The points, and behind them the corners of a triangle for each, of its share of the surface.
Mesh splats(const CheckedPoints& input) {
    const std::vector<Vec3d>& points = input.cloud.points_world;
    Mesh mesh{points, {}};
    for (std::size_t i = 0; i < points.size(); ++i) {
        // An equilateral triangle of radius r has the area 3/4 sqrt(3) r^2.
        const double radius = input.spacing_world[i] * 2 / std::sqrt(3 * std::numbers::sqrt3);
        const Vec3d& normal = input.cloud.normals[i];
        const Vec3d u = radius * normal.unitOrthogonal();
        const Vec3d v = normal.cross(u) * (std::numbers::sqrt3 / 2);
        const auto first = static_cast<int>(mesh.vertices_world.size());
        mesh.triangles.push_back({first, first + 1, first + 2});
        for (const Vec3d& corner : {u, Vec3d(-u / 2 + v), Vec3d(-u / 2 - v)})
            mesh.vertices_world.push_back(points[i] + corner);
    }
    return mesh;
}

/// The points in voxels, and how far from each samples are looked at.
struct Reach {
    std::vector<double> spacing;
    double half_width;
    /// Half a width above the middle of a gap of four spacings.
    double of(std::size_t point) const {
        return std::sqrt(half_width * half_width + 4 * spacing[point] * spacing[point]);
    }
};

void append(const PointCloud& more, PointCloud& cloud) {
    cloud.points_world.insert(cloud.points_world.end(), more.points_world.begin(),
                              more.points_world.end());
    cloud.normals.insert(cloud.normals.end(), more.normals.begin(), more.normals.end());
}

/// Coordinates of the blocks with a sample within reach of a point, in order.
std::vector<Index3> blocks_in_reach(std::span<const Vec3d> points, const Reach& reach,
                                    double memory_bytes) {
    double bytes = 0;
    for (std::size_t i = 0; i < points.size(); ++i)
        bytes += std::pow(2 * reach.of(i) / block_size + 1, 3) * sizeof(Index3);
    if (bytes > memory_bytes) refuse_memory(bytes, memory_bytes);
    std::vector<Index3> blocks;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const double radius = reach.of(i);
        const auto block_at = [&](double offset) -> Index3 {
            return ((points[i].array() + offset) / block_size).floor().cast<int>();
        };
        const Index3 lo = block_at(-radius);
        const Index3 hi = block_at(radius);
        for (int z = lo.z(); z <= hi.z(); ++z) {
            for (int y = lo.y(); y <= hi.y(); ++y) {
                for (int x = lo.x(); x <= hi.x(); ++x) {
                    const Vec3d first = block_size * Vec3d(x, y, z);
                    const Vec3d last = first.array() + (block_size - 1);
                    if ((points[i] - points[i].cwiseMax(first).cwiseMin(last)).squaredNorm() <=
                        radius * radius)
                        blocks.emplace_back(x, y, z);
                }
            }
        }
    }
    tbb::parallel_sort(blocks.begin(), blocks.end(), zyx_less);
    blocks.erase(std::unique(blocks.begin(), blocks.end()), blocks.end());
    if (bytes = static_cast<double>(blocks.size() * sizeof(FieldBlock)); bytes > memory_bytes)
        refuse_memory(bytes, memory_bytes);
    return blocks;
}

/// The points that any sample of a piece of a block can see, found once for all of them.
class Candidates {
public:
    static constexpr int edge = block_size / 2;

    /// first  sample of a piece of edge^3 samples
    void gather(const Meshless& field, const Vec3d& first) {
        middle_ = first.array() + (edge - 1) / 2.0;
        const double half_diagonal = (edge - 1) / 2.0 * std::numbers::sqrt3;
        seen_points_ = field.seen_points();
        field.tree().nearest(middle_, seen_points_, found_);
        radius_ = std::sqrt(found_.back().squared_distance);
        // What the middle sees is within radius + half a diagonal of any sample, which therefore
        // sees no farther than that.
        field.tree().within(middle_, radius_ + 2 * half_diagonal + slack, found_);
        for (auto& axis : position_) axis.resize(found_.size());
        squares_.resize(found_.size());
        seen_.resize(found_.size() + 1);
        last_ = middle_;
        last_radius_ = radius_;
        for (std::size_t i = 0; i < found_.size(); ++i)
            for (int axis = 0; axis < 3; ++axis)
                position_[axis][i] = field.points()[found_[i].point][axis];
    }

    /// The point nearest to `p`.
    Neighbour nearest_to(const Vec3d& p) {
        for (std::size_t i = 0; i < squares_.size(); ++i) {
            const double x = position_[0][i] - p.x();
            const double y = position_[1][i] - p.y();
            const double z = position_[2][i] - p.z();
            squares_[i] = x * x + y * y + z * z;
        }
        const auto least = std::ranges::min_element(squares_);
        return {*least, found_[static_cast<std::size_t>(least - squares_.begin())].point};
    }

    /// The points that `p` sees, the nearest first and the farthest last; after nearest_to(p).
    std::span<const Neighbour> seen_from(const Vec3d& p) {
        // The radius changes by no more than one moves.
        const double greatest = std::pow(
            std::min(radius_ + (p - middle_).norm(), last_radius_ + (p - last_).norm()) + slack, 2);
        std::size_t count = 0;
        for (std::size_t i = 0; i < squares_.size(); ++i) { // without a branch to guess
            seen_[count] = {squares_[i], found_[i].point};
            count += squares_[i] <= greatest;
        }
        const auto end = seen_.begin() + static_cast<std::ptrdiff_t>(seen_points_);
        std::nth_element(seen_.begin(), end - 1, seen_.begin() + static_cast<std::ptrdiff_t>(count),
                         is_nearer);
        std::iter_swap(seen_.begin(), std::min_element(seen_.begin(), end, is_nearer));
        last_ = p;
        last_radius_ = std::sqrt((end - 1)->squared_distance);
        return {seen_.data(), seen_points_};
    }

private:
    /// Neighbour's order, without its care for what is no number.
    static bool is_nearer(const Neighbour& a, const Neighbour& b) {
        return a.squared_distance < b.squared_distance ||
               (a.squared_distance == b.squared_distance && a.point < b.point);
    }
    static constexpr double slack = 1e-6; // voxel: covers rounding, costs nothing

    Vec3d middle_;
    double radius_ = 0;
    std::size_t seen_points_ = 0;
    std::vector<Neighbour> found_;
    std::array<std::vector<double>, 3> position_;
    std::vector<double> squares_;
    std::vector<Neighbour> seen_;
    Vec3d last_; // asked for, and what it saw
    double last_radius_ = 0;
};

class PointBand {
public:
    PointBand(const Meshless& field, const WindingNumber& winding, const Reach& reach,
              double voxel_size_world)
        : field_(field), winding_(winding), reach_(reach), voxel_size_world_(voxel_size_world) {}

    /// returns  whether a sample is active
    bool fill(FieldBlock& block, Candidates& candidates) const {
        const Index3 first = block_size * block.coordinate;
        SampleBits known;
        SampleBits negative;
        SampleBits active;
        for (int piece = 0; piece < 8; ++piece) {
            const Index3 corner = Candidates::edge * Index3(piece & 1, piece >> 1 & 1, piece >> 2);
            candidates.gather(field_, (first + corner).cast<double>());
            for (int k = 0; k < Candidates::edge * Candidates::edge * Candidates::edge; ++k) {
                const Index3 sample =
                    corner + Index3(k % Candidates::edge, k / Candidates::edge % Candidates::edge,
                                    k / (Candidates::edge * Candidates::edge));
                const Vec3d p = (first + sample).cast<double>();
                const Neighbour nearest = candidates.nearest_to(p);
                const double far = reach_.of(static_cast<std::size_t>(nearest.point));
                if (nearest.squared_distance > far * far) continue;
                const double distance = signed_distance(p, candidates.seen_from(p));
                const int i = sample.x() + block_size * (sample.y() + block_size * sample.z());
                known.set(i);
                if (std::signbit(distance)) negative.set(i);
                if (std::abs(distance) > reach_.half_width) continue;
                active.set(i);
                block.values[i] = static_cast<float>(distance * voxel_size_world_);
            }
        }
        spread(known, negative);
        apply_signs(block, active, negative,
                    static_cast<float>(reach_.half_width * voxel_size_world_));
        return block.active.any();
    }

private:
    /// In voxels.
    double signed_distance(const Vec3d& p, std::span<const Neighbour> seen) const {
        const Meshless::Value value = field_.at(p, seen);
        const bool is_negative = value.near < 0;
        if (value.near == 0 ||
            (!value.all_agree &&
             value.far > reach_.spacing[static_cast<std::size_t>(value.nearest)])) {
            const double winding = winding_.at(p);
            const bool is_inside = winding > 0.5;
            const bool is_decided = std::abs(winding - 0.5) > 0.25;
            if (value.near_weight < 1 && is_decided && is_inside != is_negative)
                return is_inside ? -value.far : value.far;
        }
        return value.blended(is_negative);
    }

    const Meshless& field_;
    const WindingNumber& winding_;
    const Reach& reach_;
    double voxel_size_world_;
};

} // namespace

ConvertResult convert_points(const CheckedPoints& input, const ConvertOptions& options,
                             const MeshlessOptions& meshless, const Progress& progress) {
    require_usable(options);
    const Stopwatch time;
    if (progress) progress("prepare", 0);
    const double voxel = options.voxel_size_world;
    const double memory = std::min(options.memory_bytes, available_memory_bytes());
    if (std::isfinite(options.memory_bytes)) {
        const double expected = estimate(input, options).peak_bytes;
        if (expected > options.memory_bytes) refuse_memory(expected, options.memory_bytes);
    }
    const LatticeMesh lattice = on_lattice(splats(input), voxel, options.half_width_voxels);
    const std::size_t count = input.cloud.points_world.size();
    Reach reach{input.spacing_world, options.half_width_voxels};
    for (double& spacing : reach.spacing) spacing /= voxel;
    const auto& at = lattice.mesh.vertices_world;
    PointCloud cloud{{at.begin(), at.begin() + static_cast<std::ptrdiff_t>(count)},
                     input.cloud.normals};
    const WindingNumber winding(lattice.mesh, false);
    // No less than a voxel: nothing is seen of smaller gaps, and cells are counted in 32 bits.
    const double gap_cell = std::max(2 * input.median_spacing_world / voxel, 1.0);
    append(points_over_gaps(cloud.points_world, reach.spacing, gap_cell, winding), cloud);
    reach.spacing.resize(cloud.points_world.size(), gap_cell);
    const Meshless field(std::move(cloud.points_world), std::move(cloud.normals), meshless);
    const std::vector<Index3> coordinates = blocks_in_reach(field.points(), reach, memory);
    const double prepare_seconds = time.seconds();

    FieldBlocks blocks(coordinates.size());
    const PointBand band(field, winding, reach, voxel);
    std::vector<char> is_used(blocks.size());
    ProgressMeter meter(progress, "transform", static_cast<double>(blocks.size()), 16);
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, blocks.size()), [&](const auto& range) {
        Candidates candidates;
        for (std::size_t i = range.begin(); i < range.end(); ++i) {
            std::construct_at(&blocks[i])->coordinate = coordinates[i];
            is_used[i] = band.fill(blocks[i], candidates);
            meter.add(1);
        }
    });
    std::size_t used = 0;
    for (std::size_t i = 0; i < blocks.size(); ++i)
        if (is_used[i]) blocks[used++] = blocks[i];
    blocks.resize(used);
    mend_signs(blocks, static_cast<float>(voxel), [&](const Vec3d& p) { return winding.at(p); });
    const auto background = static_cast<float>(options.half_width_voxels * voxel);
    if (!blocks.empty()) store_outside_signs(blocks, winding, background, memory, progress);
    for (FieldBlock& block : blocks) block.coordinate += lattice.anchor / block_size;
    return {.field = SparseField(lattice.space, options.half_width_voxels * voxel,
                                 Outside::SignedBackground, std::move(blocks)),
            .sign_used = SignMethod::Winding,
            .sign_reason = "near the points as they face",
            .time = {.prepare_seconds = prepare_seconds,
                     .transform_seconds = time.seconds() - prepare_seconds},
            .distance_evaluations = 0};
}

ConvertEstimate estimate(const CheckedPoints& input, const ConvertOptions& options) {
    ConvertEstimate result = estimate(CheckedMesh{.mesh = splats(input)}, options);
    // Blocks that are looked at and dropped, and the equations: 20 numbers a point, thrice.
    result.peak_bytes =
        2 * result.field_bytes + 1000 * static_cast<double>(input.cloud.points_world.size());
    return result;
}

WorldBox bounding_box(const CheckedPoints& input) {
    WorldBox box{input.cloud.points_world.front(), input.cloud.points_world.front()};
    for (const Vec3d& p : input.cloud.points_world)
        box = {box.min.cwiseMin(p), box.max.cwiseMax(p)};
    return box;
}

} // namespace isocast
