// A dense field by the kD-tree: a tile's triangles by one query, its samples by their sites.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/kd_dense.h"

#include "distance_transform/progress_meter.h"
#include "distance_transform/tile_columns.h"
#include "volume/errors.h"

#include <fmt/format.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>

namespace isocast {

namespace {

/// Culling margin [voxels]: far above the rounding of distances between coordinates below 2^28
/// voxels (1e-7), far below what culling gains.
constexpr double culling_slack = 1e-6;

using Corners = std::array<Vec3d, 3>;

double distance_to(const Vec3d& p, const Corners& triangle) {
    return std::sqrt(closest_point(p, triangle).squared_distance);
}

/// What of a mesh can matter within a cube about c, when triangle j is known.
///
/// The distance d_i to a convex set is a convex function with gradient u_i, so that
///   d_i(c + x) >= d_i(c) + u_i · x,
/// and d_j(c + x) - u_i · x, being convex, is greatest at a corner x_k of the cube. Triangle i lies
/// nowhere closer than j if d_i(c) + u_i · x_k > d_j(c + x_k) at all eight. For a far cube this
/// keeps few, where the radius-based bounds keep a whole cap of the surface.
class Reach {
public:
    Reach(const Vec3d& centre, double half_edge, const Corners& known) : half_edge_(half_edge) {
        for (int k = 0; k < 8; ++k)
            at_corner_[k] =
                distance_to(centre + half_edge * corner_direction(k), known) + culling_slack;
    }

    /// offset  to c from the closest point of the convex set
    bool holds(const Vec3d& offset) const {
        const double distance = offset.norm();
        if (!(distance > 0)) return true;
        const Vec3d d = half_edge_ / distance * offset;
        const std::array<double, 4> xy = {distance - d.x() - d.y(), distance + d.x() - d.y(),
                                          distance - d.x() + d.y(), distance + d.x() + d.y()};
        for (int k = 0; k < 4; ++k)
            if (xy[k] - d.z() <= at_corner_[k] || xy[k] + d.z() <= at_corner_[k + 4]) return true;
        return false;
    }

    /// No sample of the cube is farther from the mesh.
    double greatest() const { return std::ranges::max(at_corner_); }

private:
    double half_edge_;
    std::array<double, 8> at_corner_; // d_j there, or more
};

/// The sites of the triangles that can be nearest to a tile's samples, by one thread.
class SiteFinder {
public:
    SiteFinder(const Sites& sites, const MeshTopology& topology,
               std::span<const std::uint32_t> edge_of_halfedge, const KdTree& tree)
        : arrays_(sites.arrays()), topology_(topology), edge_of_halfedge_(edge_of_halfedge),
          tree_(tree), tile_of_site_(static_cast<std::size_t>(sites.count())) {}

    /// list  becomes faces, then edges, then fans. returns  what no sample's distance passes
    double run(const Vec3d& centre, double half_edge, const Mesh& mesh,
               std::vector<std::int32_t>& list) {
        const std::int32_t nearest = tree_.closest(centre)->triangle;
        const auto& [a, b, c] = mesh.triangles[static_cast<std::size_t>(nearest)];
        const Reach reach(centre, half_edge,
                          {mesh.vertices_world[a], mesh.vertices_world[b], mesh.vertices_world[c]});
        list.clear();
        ++tile_;
        tree_.visit(
            centre, [&](const Vec3d& offset) { return reach.holds(offset); },
            [&](std::int32_t triangle, const Corners& corners) {
                ++evaluations_;
                if (reach.holds(centre - closest_point(centre, corners).p)) add(triangle, list);
            });
        const std::size_t face_count = list.size();
        for (std::size_t i = 0; i < face_count; ++i)
            for (int k = 0; k < 3; ++k)
                add(arrays_.face_count +
                        static_cast<std::int32_t>(edge_of_halfedge_[3 * list[i] + k]),
                    list);
        for (std::size_t i = 0; i < face_count; ++i)
            for (int k = 0; k < 3; ++k)
                add(arrays_.face_count + arrays_.edge_count +
                        topology_.fan_of_corner[3 * list[i] + k],
                    list);
        return reach.greatest();
    }

    std::int64_t evaluations() const { return evaluations_; }

private:
    void add(std::int32_t site, std::vector<std::int32_t>& list) {
        std::uint32_t& tile = tile_of_site_[static_cast<std::size_t>(site)];
        if (tile != tile_) list.push_back(site);
        tile = tile_;
    }

    const SiteArrays& arrays_;
    const MeshTopology& topology_;
    std::span<const std::uint32_t> edge_of_halfedge_;
    const KdTree& tree_;
    std::vector<std::uint32_t> tile_of_site_; // the last one that it was added to
    std::uint32_t tile_ = 0;
    std::int64_t evaluations_ = 0;
};

void require_usable(const KdDenseOptions& options) {
    const IndexBox& box = options.box;
    if (box.is_empty()) throw InputError("the box of samples is empty");
    if ((box.lo.array() < -greatest_index).any() || (box.hi.array() > greatest_index + 1).any())
        throw InputError(fmt::format("the box of samples passes index {}", greatest_index));
    // In double: the product of three extents may pass 2^63.
    const double bytes = sizeof(float) * box.size().cast<double>().prod();
    if (bytes > options.memory_bytes)
        throw ResourceError(fmt::format("{} x {} x {} samples would take {:.3g} GB of memory, more "
                                        "than the {:.3g} GB that may be used",
                                        box.size().x(), box.size().y(), box.size().z(), bytes / 1e9,
                                        options.memory_bytes / 1e9));
}

/// Writes the samples of a block that lie in `box`; all from the anchor.
void write_block(const Index3& first, const float (&from)[samples_per_block], const IndexBox& box,
                 std::span<float> values) {
    const IndexBox part = intersection({first, first + Index3::Constant(block_size)}, box);
    const Index3 size = box.size();
    for (int z = part.lo.z(); z < part.hi.z(); ++z)
        for (int y = part.lo.y(); y < part.hi.y(); ++y) {
            const Index3 at = Index3(part.lo.x(), y, z) - box.lo;
            const float* row = from + block_size * (y - first.y() + block_size * (z - first.z()));
            std::copy(row + part.lo.x() - first.x(), row + part.hi.x() - first.x(),
                      &values[at.x() + size.x() * (at.y() + std::size_t(size.y()) * at.z())]);
        }
}

} // namespace

KdDenseResult dense_distances(const LatticeMesh& lattice, const MeshTopology& topology,
                              const KdTree& tree, const KdDenseOptions& options,
                              const Progress& progress) {
    require_usable(options);
    const IndexBox box = {options.box.lo - lattice.anchor, options.box.hi - lattice.anchor};
    const double voxel_size = lattice.space.voxel_size_world();
    std::vector<float> values(static_cast<std::size_t>(box.sample_count()));
    // Each tile has a half width of its own; what depends on it is made with the tile.
    const Sites sites(lattice.mesh, topology, box.size().maxCoeff());
    std::vector<std::uint32_t> edge_of_halfedge(topology.halfedges.size());
    for (std::size_t e = 0; e < topology.edge_count(); ++e)
        for (const std::uint32_t h : topology.edge(e))
            edge_of_halfedge[h] = static_cast<std::uint32_t>(e);

    const IndexBox tiles = {floor_div(box.lo, tile_size),
                            (floor_div((box.hi.array() - 1).matrix(), tile_size).array() + 1)};
    ProgressMeter meter(progress, "distances", static_cast<double>(tiles.sample_count()), 4);
    struct Worker {
        SiteFinder finder;
        TileMemory memory{false};
        std::vector<std::int32_t> list = {};
    };
    tbb::enumerable_thread_specific<Worker> workers(
        [&] { return Worker{SiteFinder(sites, topology, edge_of_halfedge, tree)}; });
    std::atomic<std::int64_t> evaluations = 0;
    tbb::parallel_for(std::int64_t{0}, tiles.sample_count(), [&](std::int64_t number) {
        const Index3 count = tiles.size();
        const Index3 first =
            tile_size * (tiles.lo + Index3(static_cast<int>(number % count.x()),
                                           static_cast<int>(number / count.x() % count.y()),
                                           static_cast<int>(number / count.x() / count.y())));
        Worker& worker = workers.local();
        constexpr double half_edge = (tile_size - 1) / 2.0;
        const Vec3d origin = first.cast<double>();
        SiteArrays arrays = sites.arrays();
        arrays.half_width = worker.finder.run(origin + Vec3d::Constant(half_edge), half_edge,
                                              lattice.mesh, worker.list);
        evaluations += sites.kernels().scan({.sites = &arrays,
                                             .list = worker.list.data(),
                                             .count = std::ssize(worker.list),
                                             .first_sample = {origin.x(), origin.y(), origin.z()}},
                                            worker.memory.columns());
        ScannedBlock scanned;
        float with_signs[samples_per_block];
        for (int b = 0; b < blocks_per_tile; ++b) {
            const Index3 at = block_in_tile(b);
            const Index3 first_of_block = first + block_size * at;
            if (intersection({first_of_block, first_of_block + Index3::Constant(block_size)}, box)
                    .is_empty())
                continue;
            sites.kernels().finish(worker.memory.columns(), arrays.half_width, voxel_size, at.x(),
                                   at.y(), at.z(), scanned);
            if (options.winding)
                set_rows(winding_signs(scanned.distance, bits_of_rows(scanned.active), voxel_size,
                                       *options.winding, first_of_block.cast<double>()),
                         scanned.negative);
            sites.kernels().apply_signs(scanned.distance, scanned.negative, with_signs);
            write_block(first_of_block, with_signs, box, values);
        }
        meter.add(1);
    });
    for (const Worker& worker : workers) evaluations += worker.finder.evaluations();
    return {.field = DenseField(lattice.space, options.box, std::move(values)),
            .distance_evaluations = evaluations};
}

} // namespace isocast
