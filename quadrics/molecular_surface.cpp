// SPDX-License-Identifier: MPL-2.0
#include "quadrics/molecular_surface.h"

#include "quadrics/ball_union.h"
#include "quadrics/probe_cuts.h"
#include "volume/available_memory.h"
#include "volume/errors.h"

#include <fmt/format.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>
#include <numbers>

namespace isocast {

namespace {

/// Greatest |index| of a sample, as in meshes' transforms; 32-bit arithmetic cannot overflow.
constexpr int greatest_index = 1 << 28;
/// Of the probe's radius: how far a point may be within a probe and count as outside. 1e-8: floats
/// tell 6e-8.
constexpr double cusp_tolerance = 1e-8;
/// A ribosome (1xnr) takes 8 at most, 1 where there is no cusp.
constexpr std::size_t most_cuts = 64;

void require_usable(std::span<const Sphere> atoms, const MolecularSurfaceOptions& options) {
    if (atoms.empty()) throw InputError("no atoms: they have no surface");
    check(atoms);
    require_band(options.voxel_size_world, options.half_width_voxels);
    if (!(options.probe_radius_world >= 0) || !std::isfinite(options.probe_radius_world))
        throw InputError(
            fmt::format("probe radius {} is not a number from 0 on", options.probe_radius_world));
}

[[noreturn]] void refuse_memory(double blocks, double memory_bytes) {
    const auto text = [](double count) {
        return count < 0x1p30 ? fmt::format("{:.3g} MiB", count / 0x1p20)
                              : fmt::format("{:.3g} GiB", count / 0x1p30);
    };
    throw ResourceError(fmt::format(
        "the surface's field would take about {}, and {} of memory may be taken; use a larger "
        "voxel size or a narrower band",
        text(blocks * sizeof(FieldBlock)), text(memory_bytes)));
}

/// From the distance to the boundary of a union of balls to that of the surface.
struct Levels {
    double probe; // how far the surface is within the union: 0 if it is its boundary
    double half_width;

    double outer() const { return std::max(half_width - probe, 0.0); } // of the band, from balls
    double inner() const { return half_width + probe; }
};

/// The balls, and samples at multiples of the voxel size, from a lattice point near their middle:
/// no coordinate is larger than the molecule, wherever in the world it lies.
struct Lattice {
    GridSpace space;
    Index3 anchor; // a multiple of the block size
    double voxel_size;
    double extent;  // of the balls, along the longest axis
    int root_level; // the eight nodes about the anchor that hold all are as large
    std::vector<Ball> balls;
};

Lattice on_lattice(std::span<const Sphere> atoms, double growth, const Levels& levels,
                   double voxel_size) {
    Eigen::AlignedBox3d box;
    for (const Sphere& atom : atoms) {
        const Vec3d half = Vec3d::Constant(atom.radius_world + growth);
        box.extend(Vec3d(atom.centre_world - half));
        box.extend(Vec3d(atom.centre_world + half));
    }
    Lattice result{.voxel_size = voxel_size, .extent = box.sizes().maxCoeff()};
    Vec3d translation_world = Vec3d::Zero();
    double greatest_reach = 0;
    for (int k = 0; k < 3; ++k) {
        const double middle = (box.min()[k] + box.sizes()[k] / 2) / voxel_size;
        const double reach = (box.sizes()[k] / 2 + levels.outer()) / voxel_size + 2 * block_size;
        if (!(reach < greatest_index))
            throw ResourceError(
                fmt::format("voxel size {} is too small: the molecule would span {:.3g} voxels",
                            voxel_size, 2 * reach));
        // Beyond 2^53 voxels neighbouring samples are the same double.
        if (!(std::abs(middle) + reach < 0x1p53))
            throw InputError(fmt::format(
                "voxel size {} is too small for a molecule that lies {:.3g} from the origin: "
                "double precision cannot tell its voxels apart",
                voxel_size, std::abs(middle) * voxel_size));
        const bool is_far = std::abs(middle) + reach > greatest_index;
        const double shift = is_far ? std::floor(middle) : 0;
        translation_world[k] = shift * voxel_size;
        result.anchor[k] = block_size * static_cast<int>(std::floor((middle - shift) / block_size));
        greatest_reach = std::max(greatest_reach, reach);
    }
    result.space = GridSpace::uniform(voxel_size, translation_world);
    result.root_level =
        std::max(0, static_cast<int>(std::ceil(std::log2(greatest_reach / block_size))));
    const Vec3d anchor_world = result.space.to_world(result.anchor.cast<double>());
    for (const Sphere& atom : atoms)
        result.balls.push_back({atom.centre_world - anchor_world, atom.radius_world + growth});
    return result;
}

/// A cube of 2^level blocks along each axis.
struct Node {
    Index3 coordinate; // in cubes of its size, from the anchor
    int level;
};

/// From cube to cube, each with the part of the boundary that its samples need.
class Descent {
public:
    Descent(const Lattice& lattice, const UnionBoundary& boundary, const Levels& levels)
        : lattice_(lattice), boundary_(boundary), levels_(levels) {}

    /// Calls found(node, its part of the boundary, the middle of its samples) from all threads for
    /// each node of a level that may hold samples of the band.
    template<class Found>
    void run(int level, const Found& found) {
        const BoundaryPart all = whole(boundary_);
        const int root = std::max(lattice_.root_level, level);
        tbb::parallel_for(0, 8, [&](int corner) {
            visit({Index3(corner & 1, corner >> 1 & 1, corner >> 2) - Index3::Ones(), root}, level,
                  all, found);
        });
    }

private:
    template<class Found>
    void visit(const Node& node, int level, const BoundaryPart& parents, const Found& found) {
        const double samples = std::ldexp(block_size, node.level);
        const double half = (samples - 1) / 2 * lattice_.voxel_size;
        const Vec3d middle =
            samples * lattice_.voxel_size * node.coordinate.cast<double>() + Vec3d::Constant(half);
        const double radius = std::numbers::sqrt3 * half;
        const BoundaryPart part =
            near(boundary_, parents, middle, radius, levels_.outer(), levels_.inner());
        if (!part.has_boundary()) return;
        if (part.faces.size() < many || node.level == level) {
            NearBoundary& local = memory_.local();
            local.load(boundary_, part);
            if (!may_meet_band(local, middle, radius)) return;
            if (node.level == level) {
                if (any_octant_may_meet_band(local, middle, half)) found(node, part, middle);
                return;
            }
        }
        const auto visit_child = [&](int corner) {
            visit({2 * node.coordinate + Index3(corner & 1, corner >> 1 & 1, corner >> 2),
                   node.level - 1},
                  level, part, found);
        };
        if (part.faces.size() >= many) {
            tbb::parallel_for(0, 8, visit_child);
        } else {
            for (int corner = 0; corner < 8; ++corner) visit_child(corner);
        }
    }

    /// What p + dist(x, U) and p - dist(x, A) say at the middle: neither changes by more than the
    /// radius up to any sample, and the distance to the surface is no less.
    bool may_meet_band(NearBoundary& local, const Vec3d& middle, double radius) const {
        const double height = local.height(middle);
        const double limit = levels_.half_width + radius;
        if (height >= 0) return levels_.probe + height <= limit;
        const double value = levels_.probe - local.nearest(middle).distance;
        return std::abs(value) <= limit;
    }

    bool any_octant_may_meet_band(NearBoundary& local, const Vec3d& middle, double half) const {
        for (int corner = 0; corner < 8; ++corner) {
            const Vec3d side(2 * (corner & 1) - 1, (corner & 2) - 1, (corner >> 1 & 2) - 1);
            if (may_meet_band(local, middle + half / 2 * side, std::numbers::sqrt3 / 2 * half))
                return true;
        }
        return false;
    }

    static constexpr std::size_t many = 256; // faces of a node that is worth a task

    const Lattice& lattice_;
    const UnionBoundary& boundary_;
    const Levels& levels_;
    tbb::enumerable_thread_specific<NearBoundary> memory_;
};

/// The surface's distance at the samples of one block.
class BlockFiller {
public:
    BlockFiller(const Levels& levels, double tolerance) : levels_(levels), tolerance_(tolerance) {}

    /// Returns whether there are samples in the band.
    ///
    /// part    of the boundary that the block's samples need
    /// middle  of the block's samples
    bool fill(FieldBlock& block, const UnionBoundary& boundary, const BoundaryPart& part,
              const Vec3d& middle, double voxel_size) {
        // Pieces of 4^3 samples need less of the boundary than all of it.
        for (int piece = 0; piece < 8; ++piece) {
            const Index3 first = piece_size * Index3(piece & 1, piece >> 1 & 1, piece >> 2);
            const Vec3d offset = first.cast<double>() - Vec3d::Constant(2);
            fill_piece(block, first, boundary, part, middle + voxel_size * offset, voxel_size);
        }
        return block.active.any();
    }

private:
    static constexpr int piece_size = 4;

    void fill_piece(FieldBlock& block, const Index3& first, const UnionBoundary& boundary,
                    const BoundaryPart& blocks_part, const Vec3d& middle, double voxel_size) {
        const double half = (piece_size - 1) / 2.0;
        const double radius = std::numbers::sqrt3 * half * voxel_size;
        local_.load(boundary,
                    near(boundary, blocks_part, middle, radius, levels_.outer(), levels_.inner()));
        for (int z = 0; z < piece_size; ++z)
            for (int y = 0; y < piece_size; ++y)
                for (int x = 0; x < piece_size;) {
                    const Vec3d offset = voxel_size * (Vec3d(x, y, z) - Vec3d::Constant(half));
                    // Balls that were not loaded are farther than this.
                    const double known = levels_.outer() + radius - offset.norm();
                    const Value value = value_at(middle + offset, known);
                    const bool is_active = std::abs(value.distance) <= levels_.half_width;
                    const auto background = static_cast<float>(levels_.half_width);
                    const float stored = is_active            ? static_cast<float>(value.distance)
                                         : value.distance < 0 ? -background
                                                              : background;
                    // The next ones that are beyond the band, too.
                    const double more = std::ceil(value.beyond / voxel_size) - 1;
                    const int end = x + 1 + static_cast<int>(std::clamp(more, 0.0, 3.0));
                    auto i = static_cast<std::size_t>(first.x() + x + 8 * (first.y() + y) +
                                                      64 * (first.z() + z));
                    for (; x < std::min(end, piece_size); ++x, ++i) {
                        block.values[i] = stored;
                        block.active[i] = is_active;
                    }
                }
    }

private:
    struct Value {
        double distance; // beyond the band a value of the same sign that is beyond it, too
        double beyond;   // a length within which all is beyond the band; 0 or less if unknown
    };

    Value value_at(const Vec3d& p, double known) {
        const double height = local_.height(p);
        if (height >= 0) {
            const double distance = levels_.probe + height;
            return {distance, levels_.probe + std::min(height, known) - levels_.half_width};
        }
        if (-height > levels_.inner()) return {levels_.probe + height, -height - levels_.inner()};
        const NearBoundary::Nearest nearest = local_.nearest(p);
        const double distance = levels_.probe - nearest.distance;
        // Only arcs and their ends have cusps beyond; see the header.
        const bool may_have_cusps =
            distance > 0 && distance <= levels_.half_width && !nearest.is_on_face;
        return {may_have_cusps ? distance_to_excluded(p, nearest.point) : distance, 0};
    }

    /// For a point that probes reach: cuts away the probe about the nearest centre, then the one
    /// that reaches farthest over the nearest point that is left, and so on. What is left always
    /// holds E: its distance never passes E's.
    double distance_to_excluded(const Vec3d& p, const Vec3d& first_centre) {
        ProbeCuts cuts(levels_.probe, tolerance_);
        Vec3d centre = first_centre;
        for (;;) {
            cuts.add(centre - p);
            const auto [offset, distance] = cuts.nearest();
            if (!(distance <= levels_.half_width) || cuts.count() == most_cuts) return distance;
            const Vec3d q = p + offset;
            if (local_.height(q) >= 0) {
                centre = q;
                continue;
            }
            const NearBoundary::Nearest nearest = local_.nearest(q);
            if (nearest.distance >= levels_.probe * (1 - cusp_tolerance)) return distance;
            centre = nearest.point;
        }
    }

    Levels levels_;
    double tolerance_;
    NearBoundary local_;
};

/// The smallest level whose nodes are not much smaller than atoms: below it nodes become four times
/// as many from level to level.
int counting_level(const Lattice& lattice) {
    double smallest = std::numeric_limits<double>::infinity();
    for (const Ball& ball : lattice.balls) smallest = std::min(smallest, ball.radius);
    int level = 0;
    while (level < lattice.root_level &&
           std::ldexp(block_size * lattice.voxel_size, level) < smallest / 2)
        ++level;
    return level;
}

/// How many blocks may hold samples of the band.
/// throws  ResourceError if they would take too much memory
std::size_t count_blocks(const Lattice& lattice, const Levels& levels, Descent& descent,
                         double memory_bytes, const Progress& progress) {
    const double most = memory_bytes / sizeof(FieldBlock);
    const int level = counting_level(lattice);
    std::atomic<std::size_t> count = 0;
    const auto tell = [&](std::size_t number) { // how many there are to be, nobody knows yet
        if (progress && number % 4096 == 0) progress("blocks", 0);
    };
    descent.run(level, [&](auto&&...) { tell(++count); });
    // A sheet of thickness 2 (half width + radius) over an area, in cubes.
    const auto per_area = [&](int of_level) {
        const double edge = std::ldexp(block_size * lattice.voxel_size, of_level);
        return 2 * (levels.half_width + edge * std::numbers::sqrt3 / 2) / (edge * edge * edge);
    };
    const double estimate = static_cast<double>(count) * per_area(0) / per_area(level);
    // Within a factor of two it takes a count of the blocks themselves to tell.
    if (estimate > (level > 0 ? 2 * most : most)) refuse_memory(estimate, memory_bytes);
    if (level == 0) return count;
    count = 0;
    descent.run(0, [&](auto&&...) {
        const std::size_t number = ++count;
        if (static_cast<double>(number) > most)
            refuse_memory(std::max(estimate, most), memory_bytes);
        tell(number);
    });
    return count;
}

} // namespace

SparseField molecular_surface(std::span<const Sphere> atoms, const MolecularSurfaceOptions& options,
                              const Progress& progress) {
    require_usable(atoms, options);
    const double voxel_size = options.voxel_size_world;
    const double growth =
        options.kind == MolecularSurface::VanDerWaals ? 0 : options.probe_radius_world;
    const Levels levels{options.kind == MolecularSurface::Excluded ? growth : 0,
                        options.half_width_voxels * voxel_size};
    const double memory_bytes = std::min(options.memory_bytes, available_memory_bytes());
    if (progress) progress("boundary", 0);
    const Lattice lattice = on_lattice(atoms, growth, levels, voxel_size);
    const double tolerance = lattice.extent * 0x1p-42;
    const UnionBoundary boundary = boundary_of(lattice.balls, tolerance);

    if (progress) progress("blocks", 0);
    Descent descent(lattice, boundary, levels);
    const std::size_t most = count_blocks(lattice, levels, descent, memory_bytes, progress);
    FieldBlocks blocks(most);
    std::atomic<std::size_t> next = 0, done = 0;
    tbb::enumerable_thread_specific<BlockFiller> fillers(levels, tolerance);
    descent.run(0, [&](const Node& node, const BoundaryPart& part, const Vec3d& middle) {
        FieldBlock block;
        if (fillers.local().fill(block, boundary, part, middle, voxel_size)) {
            block.coordinate = node.coordinate + lattice.anchor / block_size;
            std::construct_at(&blocks[next++], block);
        }
        if (const std::size_t number = ++done; progress && number % 64 == 0)
            progress("distances", static_cast<double>(number) / static_cast<double>(most));
    });
    blocks.resize(next);
    return SparseField(lattice.space, levels.half_width, Outside::SignedBackground,
                       std::move(blocks));
}

} // namespace isocast
