// Normals by principal components, oriented along a minimum spanning tree.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/point_normals.h"

#include "volume/errors.h"

#include <Eigen/Eigenvalues>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <cmath>
#include <numeric>

namespace isocast {

namespace {

/// Two neighbours, and what it costs to carry an orientation from one to the other.
struct Link {
    double turning; // 1 - |cos| of the angle between the normals
    std::int32_t a, b;

    auto operator<=>(const Link&) const = default;
};

/// Sets of points whose normals agree once some of them are turned.
class Parts {
public:
    explicit Parts(std::size_t count) : parent_(count), turned_(count, 0) {
        std::iota(parent_.begin(), parent_.end(), 0);
    }
    struct Root {
        std::int32_t point;
        bool turned; // against the root
    };
    Root root(std::int32_t i) {
        bool turned = false;
        std::int32_t at = i;
        for (; parent_[at] != at; at = parent_[at]) turned ^= turned_[at] != 0;
        // Shortens the way for the next one that asks.
        for (bool left = turned; parent_[i] != i;) {
            const std::int32_t next = std::exchange(parent_[i], at);
            const bool step = turned_[i] != 0;
            turned_[i] = left;
            left ^= step;
            i = next;
        }
        return {at, turned};
    }
    void join(std::int32_t a, std::int32_t b, bool opposed) {
        const Root ra = root(a);
        const Root rb = root(b);
        if (ra.point == rb.point) return;
        parent_[rb.point] = ra.point;
        turned_[rb.point] = ra.turned ^ rb.turned ^ opposed;
    }

private:
    std::vector<std::int32_t> parent_;
    std::vector<char> turned_; // against the parent
};

} // namespace

std::vector<Vec3d> estimated_normals(std::span<const Vec3d> points, const PointTree& tree,
                                     int neighbours) {
    const std::size_t count = points.size();
    const auto width = std::min(static_cast<std::size_t>(neighbours) + 1, count);
    std::vector<Vec3d> normals(count);
    std::vector<std::int32_t> near(count * width);
    std::vector<char> is_line(count);
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, 256), [&](const auto& range) {
        std::vector<Neighbour> seen;
        for (std::size_t i = range.begin(); i < range.end(); ++i) {
            tree.nearest(points[i], width, seen);
            Vec3d middle = Vec3d::Zero(); // from the point, so that nothing is lost far away
            for (const Neighbour& n : seen)
                middle += (points[n.point] - points[i]) / static_cast<double>(width);
            Mat3d spread = Mat3d::Zero();
            for (std::size_t k = 0; k < width; ++k) {
                const Vec3d offset = points[seen[k].point] - points[i] - middle;
                spread += offset * offset.transpose();
                near[i * width + k] = seen[k].point;
            }
            const Eigen::SelfAdjointEigenSolver<Mat3d> axes(spread);
            normals[i] = axes.eigenvectors().col(0);
            // 1e-12: the second axis is a millionth of the first, which rounding can make
            is_line[i] = axes.eigenvalues()[1] <= 1e-12 * axes.eigenvalues()[2];
        }
    });
    if (std::ranges::all_of(is_line, [](char line) { return line != 0; }))
        throw InputError("normals cannot be estimated: the points lie on lines");

    std::vector<Link> links;
    links.reserve(count * (width - 1));
    for (std::size_t i = 0; i < count; ++i) {
        for (std::size_t k = 1; k < width; ++k) {
            const std::int32_t j = near[i * width + k];
            links.push_back(
                {1 - std::abs(normals[i].dot(normals[j])), static_cast<std::int32_t>(i), j});
        }
    }
    tbb::parallel_sort(links);
    Parts parts(count);
    for (const auto& [turning, a, b] : links) parts.join(a, b, normals[a].dot(normals[b]) < 0);

    std::vector<Vec3d> middle(count, Vec3d::Zero());
    std::vector<double> size(count, 0.0);
    for (std::size_t i = 0; i < count; ++i) {
        const Parts::Root root = parts.root(static_cast<std::int32_t>(i));
        if (root.turned) normals[i] = -normals[i];
        middle[root.point] += points[i] - points[root.point];
        size[root.point] += 1;
    }
    std::vector<std::pair<double, std::int32_t>> farthest(count, {-1.0, 0});
    const auto from_middle = [&](std::size_t i, std::size_t root) -> Vec3d {
        return points[i] - points[root] - middle[root] / size[root];
    };
    for (std::size_t i = 0; i < count; ++i) {
        const std::int32_t root = parts.root(static_cast<std::int32_t>(i)).point;
        const double distance = from_middle(i, static_cast<std::size_t>(root)).squaredNorm();
        if (distance > farthest[root].first)
            farthest[root] = {distance, static_cast<std::int32_t>(i)};
    }
    std::vector<char> is_inward(count, 0); // of the root's part
    for (std::size_t root = 0; root < count; ++root) {
        if (size[root] == 0) continue;
        const std::int32_t out = farthest[root].second;
        is_inward[root] = normals[out].dot(from_middle(static_cast<std::size_t>(out), root)) < 0;
    }
    for (std::size_t i = 0; i < count; ++i)
        if (is_inward[parts.root(static_cast<std::int32_t>(i)).point]) normals[i] = -normals[i];
    return normals;
}

} // namespace isocast
