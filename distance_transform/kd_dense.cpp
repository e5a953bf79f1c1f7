// A dense field by the kD-tree: blocks gather candidates once, their parts cull them.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/kd_dense.h"

#include "distance_transform/prepared_triangle.h"
#include "distance_transform/progress_meter.h"
#include "volume/errors.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>

namespace isocast {

namespace {

/// Samples along a block's edge: for the bunny at 192^3 8 takes 1.4 times as long, 32 as long.
constexpr int dense_block = 16;

/// Culling margin [voxels]: far above the rounding of distances between coordinates below 2^28
/// voxels (1e-7), far below what culling gains.
constexpr double culling_slack = 1e-6;

using Corners = std::array<Vec3d, 3>;

/// The samples of a cube: size^3 of them, the outermost at its corners.
struct Cube {
    Index3 first;
    int size;
    Vec3d centre() const { return first.cast<double>() + Vec3d::Constant(half_edge()); }
    double half_edge() const { return (size - 1) / 2.0; }
    Cube child(int k) const {
        return {first + size / 2 * Index3(k & 1, k >> 1 & 1, k >> 2), size / 2};
    }
};

Vec3d corner_direction(int k) {
    return {k & 1 ? 1.0 : -1.0, k & 2 ? 1.0 : -1.0, k & 4 ? 1.0 : -1.0};
}

/// A triangle that may be closest to some sample of a cube, and what is known at its centre c.
struct Candidate {
    std::int32_t triangle;
    Feature feature; // closest to c
    double distance; // of c
    Vec3d closest;   // to c
    Vec3d direction; // from `closest` to c, unit; 0 where the distance is 0
};

/// What of a triangle can matter within a cube, when triangle j is known.
///
/// The distance d_i to a convex set is a convex function with gradient u_i, so that
///   d_i(c + x) >= d_i(c) + u_i · x,
/// and d_j(c + x) - u_i · x, being convex, is greatest at a corner x_k of the cube. Triangle i lies
/// nowhere closer than j if d_i(c) + u_i · x_k > d_j(c + x_k) at all eight. For a far cube this
/// keeps few, where the radius-based bounds keep a whole cap of the surface.
struct Reach {
    double half_edge;
    std::array<double, 8> at_corner; // d_j there, or more

    bool holds(double distance, const Vec3d& direction) const {
        const Vec3d d = half_edge * direction;
        const std::array<double, 4> xy = {distance - d.x() - d.y(), distance + d.x() - d.y(),
                                          distance - d.x() + d.y(), distance + d.x() + d.y()};
        for (int k = 0; k < 4; ++k)
            if (xy[k] - d.z() <= at_corner[k] || xy[k] + d.z() <= at_corner[k + 4]) return true;
        return false;
    }
};

/// One block's descent 16^3 → 8^3 → 4^3 → 2^3 → sample, in voxels from the lattice's anchor.
class Descent {
public:
    Descent(std::span<const PreparedTriangle> triangles, const KdTree& tree)
        : triangles_(triangles), tree_(tree) {}

    /// Calls at_sample(index, triangle, closest) for every sample of `block` in `wanted`.
    template<class AtSample>
    void run(const Cube& block, const IndexBox& wanted, const AtSample& at_sample) {
        const Vec3d centre = block.centre();
        // The last block's answer bounds this one's; the slack is for its rounding.
        double bound = std::numeric_limits<double>::infinity();
        if (hint_ >= 0) bound = candidate_at(centre, hint_, Feature::Face).distance + culling_slack;
        const auto nearest = tree_.closest(centre, bound);
        hint_ = nearest->triangle;
        const Reach reach = reach_of(block, hint_, nearest->closest.feature);
        std::vector<Candidate>& candidates = levels_[0];
        candidates.clear();
        tree_.visit(
            centre,
            [&](const Vec3d& offset) {
                const double distance = offset.norm();
                return !(distance > 0) || reach.holds(distance, offset / distance);
            },
            [&](std::int32_t triangle, const Corners&) {
                const Candidate c = candidate_at(centre, triangle, Feature::Face);
                if (reach.holds(c.distance, c.direction)) candidates.push_back(c);
            });
        descend(block, wanted, 0, at_sample);
    }

    std::int64_t evaluations() const { return evaluations_; }

private:
    ClosestPoint closest_at(const Vec3d& p, std::int32_t triangle, Feature guess) {
        ++evaluations_;
        return closest_point(p, triangles_[triangle], guess);
    }

    Candidate candidate_at(const Vec3d& p, std::int32_t triangle, Feature guess) {
        const ClosestPoint found = closest_at(p, triangle, guess);
        const double distance = std::sqrt(found.squared_distance);
        const Vec3d offset = p - found.p;
        const Vec3d direction = distance > 0 ? Vec3d(offset / distance) : Vec3d::Zero();
        return {triangle, found.feature, distance, found.p, direction};
    }

    Reach reach_of(const Cube& cube, std::int32_t triangle, Feature guess) {
        Reach reach{cube.half_edge(), {}};
        for (int k = 0; k < 8; ++k) {
            const Vec3d corner = cube.centre() + cube.half_edge() * corner_direction(k);
            reach.at_corner[k] =
                std::sqrt(closest_at(corner, triangle, guess).squared_distance) + culling_slack;
        }
        return reach;
    }

    /// True if no point of the triangle is closer than `q` to any point of the cube: from |p - x|^2
    /// = |p - q|^2 - 2 (p - q) · (x - q) + |x - q|^2, if (p - q) · (x - q) <= 0 for its corners x.
    static bool is_behind(const Vec3d& q, const Corners& corners, const Vec3d& centre,
                          double half_edge) {
        const Vec3d to_centre = centre - q;
        for (const Vec3d& corner : corners) {
            const Vec3d edge = corner - q;
            if (to_centre.dot(edge) + half_edge * edge.lpNorm<1>() > 0) return false;
        }
        return true;
    }

    /// Leaves what can matter in the cube, the closest to its centre in front.
    void cull(const Cube& cube, std::vector<Candidate>& candidates) {
        const auto nearest = std::ranges::min_element(candidates, {}, &Candidate::distance);
        std::swap(*candidates.begin(), *nearest);
        if (candidates.size() == 1) return;
        const Candidate front = candidates.front();
        const Vec3d centre = cube.centre();
        // This leaves, say, one of the triangles around a vertex to which a cube belongs.
        candidates.erase(std::remove_if(candidates.begin() + 1, candidates.end(),
                                        [&](const Candidate& c) {
                                            return is_behind(front.closest,
                                                             triangles_[c.triangle].corners, centre,
                                                             cube.half_edge());
                                        }),
                         candidates.end());
        if (candidates.size() == 1 || cube.size == 2) return;
        const Reach reach = reach_of(cube, front.triangle, front.feature);
        std::erase_if(candidates,
                      [&](const Candidate& c) { return !reach.holds(c.distance, c.direction); });
    }

    template<class AtSample>
    void descend(const Cube& cube, const IndexBox& wanted, std::size_t depth,
                 const AtSample& at_sample) {
        const std::vector<Candidate>& parents = levels_[depth];
        const Vec3d centre = cube.centre();
        if (parents.size() == 1) {
            fill(cube, wanted, parents.front(), at_sample);
            return;
        }
        if (cube.size == 2) {
            visit_samples(cube, wanted, parents, at_sample);
            return;
        }
        std::vector<Candidate>& kept = levels_[depth + 1];
        for (int k = 0; k < 8; ++k) {
            const Cube child = cube.child(k);
            const Index3 end = child.first + Index3::Constant(child.size);
            if (intersection({child.first, end}, wanted).is_empty()) continue;
            const Vec3d point = child.centre();
            const Vec3d offset = point - centre;
            // The point of a candidate is a convex set too: its distances at the corners serve.
            const Candidate* upper = &parents.front();
            for (const Candidate& c : parents)
                if ((point - c.closest).squaredNorm() < (point - upper->closest).squaredNorm())
                    upper = &c;
            Reach reach{child.half_edge(), {}};
            for (int corner = 0; corner < 8; ++corner)
                reach.at_corner[corner] =
                    (point + child.half_edge() * corner_direction(corner) - upper->closest).norm() +
                    culling_slack;
            kept.clear();
            for (const Candidate& c : parents)
                if (reach.holds(c.distance + c.direction.dot(offset), c.direction) &&
                    (&c == upper || !is_behind(upper->closest, triangles_[c.triangle].corners,
                                               point, child.half_edge())))
                    kept.push_back(candidate_at(point, c.triangle, c.feature));
            cull(child, kept);
            descend(child, wanted, depth + 1, at_sample);
        }
    }

    /// All samples of a cube in which nothing but `only` matters.
    template<class AtSample>
    void fill(const Cube& cube, const IndexBox& wanted, const Candidate& only,
              const AtSample& at_sample) {
        const Index3 end = cube.first + Index3::Constant(cube.size);
        const IndexBox samples = intersection({cube.first, end}, wanted);
        for (int z = samples.lo.z(); z < samples.hi.z(); ++z)
            for (int y = samples.lo.y(); y < samples.hi.y(); ++y)
                for (int x = samples.lo.x(); x < samples.hi.x(); ++x)
                    at_sample({x, y, z}, only.triangle,
                              closest_at(Vec3d(x, y, z), only.triangle, only.feature));
    }

    /// A cube of 2^3: its samples are its corners.
    template<class AtSample>
    void visit_samples(const Cube& cube, const IndexBox& wanted,
                       std::span<const Candidate> candidates, const AtSample& at_sample) {
        std::array<Vec3d, 8> points;
        std::array<ClosestPoint, 8> best;
        std::array<std::int32_t, 8> best_triangle;
        best_triangle.fill(candidates.front().triangle);
        Reach reach{cube.half_edge(), {}};
        const auto set_best = [&](int k, const ClosestPoint& found) {
            best[k] = found;
            reach.at_corner[k] = std::sqrt(found.squared_distance) + culling_slack;
        };
        for (int k = 0; k < 8; ++k) {
            points[k] = cube.centre() + 0.5 * corner_direction(k);
            set_best(k, closest_at(points[k], best_triangle[k], candidates.front().feature));
        }
        for (const Candidate& c : candidates.subspan(1)) {
            if (!reach.holds(c.distance, c.direction)) continue;
            for (int k = 0; k < 8; ++k) {
                const double least = c.distance + 0.5 * c.direction.dot(corner_direction(k));
                if (least > reach.at_corner[k] ||
                    is_behind(best[k].p, triangles_[c.triangle].corners, points[k], 0))
                    continue;
                const ClosestPoint found = closest_at(points[k], c.triangle, c.feature);
                if (found.squared_distance >= best[k].squared_distance) continue;
                set_best(k, found);
                best_triangle[k] = c.triangle;
            }
        }
        for (int k = 0; k < 8; ++k) {
            const Index3 index = cube.first + Index3(k & 1, k >> 1 & 1, k >> 2);
            if (wanted.contains(index)) at_sample(index, best_triangle[k], best[k]);
        }
    }

    std::span<const PreparedTriangle> triangles_;
    const KdTree& tree_;
    std::int32_t hint_ = -1;
    std::array<std::vector<Candidate>, 5> levels_;
    std::int64_t evaluations_ = 0;
};

/// Signs by the winding number for samples that are + so far, x fastest: where it is constant off
/// the surface, neighbours which the surface cannot part need but one evaluation.
void sign_by_winding(const IndexBox& block, std::span<double> distances,
                     const WindingNumber& winding, bool is_constant_off_surface) {
    const Index3 size = block.size();
    const Index3 stride(1, size.x(), size.x() * size.y());
    std::vector<bool> is_known(distances.size());
    std::vector<Index3> reached;
    for (std::size_t seed = 0; seed < distances.size(); ++seed) {
        if (is_known[seed]) continue;
        const int i = static_cast<int>(seed);
        reached.emplace_back(i % stride.y(), i / stride.y() % size.y(), i / stride.z());
        const double sign = winding.is_inside((block.lo + reached.front()).cast<double>()) ? -1 : 1;
        is_known[seed] = true;
        distances[seed] *= sign;
        while (is_constant_off_surface && !reached.empty()) {
            const Index3 at = reached.back();
            reached.pop_back();
            const double distance = std::abs(distances[at.dot(stride)]);
            for (int k = 0; k < 6; ++k) {
                Index3 neighbour = at;
                neighbour[k / 2] += k % 2 == 0 ? -1 : 1;
                if ((neighbour.array() < 0).any() || (neighbour.array() >= size.array()).any())
                    continue;
                const int n = neighbour.dot(stride);
                if (is_known[n] || distance + distances[n] <= 1 + culling_slack) continue;
                is_known[n] = true;
                distances[n] *= sign;
                reached.push_back(neighbour);
            }
        }
        reached.clear();
    }
}

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

} // namespace

KdDenseResult dense_distances(const LatticeMesh& lattice, const KdTree& tree,
                              const SignOracle& sign, const KdDenseOptions& options,
                              const Progress& progress) {
    require_usable(options);
    const IndexBox box = {options.box.lo - lattice.anchor, options.box.hi - lattice.anchor};
    const Index3 size = box.size();
    const Index3 blocks = (size.array() + dense_block - 1) / dense_block;
    const double voxel_size = lattice.space.voxel_size_world();
    const auto* normals = std::get_if<Pseudonormals>(&sign);
    std::vector<float> values(static_cast<std::size_t>(box.sample_count()));
    std::vector<PreparedTriangle> triangles;
    triangles.reserve(lattice.mesh.triangles.size());
    for (const auto& [a, b, c] : lattice.mesh.triangles)
        triangles.emplace_back(Corners{lattice.mesh.vertices_world[a],
                                       lattice.mesh.vertices_world[b],
                                       lattice.mesh.vertices_world[c]});
    ProgressMeter meter(progress, "distances", double(blocks.y()) * blocks.z(), 16);
    std::atomic<std::int64_t> evaluations = 0;

    // A row of blocks along x goes by one thread, so that each starts from the last one's answer.
    tbb::parallel_for(
        std::int64_t{0}, std::int64_t{blocks.y()} * blocks.z(), [&](std::int64_t row) {
            Descent descent(triangles, tree);
            std::vector<double> distances;
            for (int x = 0; x < blocks.x(); ++x) {
                const Cube cube{box.lo + dense_block * Index3(x, static_cast<int>(row % blocks.y()),
                                                              static_cast<int>(row / blocks.y())),
                                dense_block};
                const IndexBox block =
                    intersection(box, {cube.first, cube.first + Index3::Constant(dense_block)});
                const Index3 block_size_samples = block.size();
                distances.resize(static_cast<std::size_t>(block.sample_count()));
                descent.run(
                    cube, block,
                    [&](const Index3& index, std::int32_t triangle, const ClosestPoint& closest) {
                        const Index3 local = index - block.lo;
                        const bool is_inside =
                            normals && (index.cast<double>() - closest.p)
                                               .dot(normals->at(triangle, closest.feature)) < 0;
                        const double distance = std::sqrt(closest.squared_distance);
                        distances[local.x() +
                                  block_size_samples.x() *
                                      (local.y() + block_size_samples.y() * local.z())] =
                            is_inside ? -distance : distance;
                    });
                if (!normals)
                    sign_by_winding(block, distances, std::get<WindingNumber>(sign),
                                    options.is_closed_and_oriented);
                const Index3 first = block.lo - box.lo;
                std::size_t from = 0;
                for (int z = 0; z < block_size_samples.z(); ++z)
                    for (int y = 0; y < block_size_samples.y(); ++y) {
                        const std::size_t to =
                            first.x() +
                            size.x() * (first.y() + y + std::size_t(size.y()) * (first.z() + z));
                        for (int i = 0; i < block_size_samples.x(); ++i)
                            values[to + i] = static_cast<float>(voxel_size * distances[from++]);
                    }
            }
            evaluations += descent.evaluations();
            meter.add(1);
        });
    return {.field = DenseField(lattice.space, options.box, std::move(values)),
            .distance_evaluations = evaluations};
}

} // namespace isocast
