// One point per position, unit normals, and how densely the points lie.
// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/point_cloud.h"

#include "distance_transform/checked_mesh.h"
#include "distance_transform/point_normals.h"
#include "distance_transform/point_tree.h"
#include "volume/errors.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace isocast {

namespace {

bool has_usable_normals(const PointCloud& cloud) {
    return !cloud.normals.empty() && std::ranges::all_of(cloud.normals, [](const Vec3d& n) {
        return n.allFinite() && n.stableNorm() > 0;
    });
}

void keep_only(PointCloud& cloud, const std::vector<char>& keep) {
    PointCloud kept;
    for (std::size_t i = 0; i < keep.size(); ++i) {
        if (!keep[i]) continue;
        kept.points_world.push_back(cloud.points_world[i]);
        if (!cloud.normals.empty()) kept.normals.push_back(cloud.normals[i]);
    }
    cloud = std::move(kept);
}

/// Points at the position of no earlier one.
std::vector<char> first_at_positions(const std::vector<Vec3d>& points) {
    std::vector<std::size_t> order(points.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::ranges::sort(order, {}, [&](std::size_t i) {
        return std::tuple(points[i].x(), points[i].y(), points[i].z(), i);
    });
    std::vector<char> keep(points.size(), 1);
    for (std::size_t i = 1; i < order.size(); ++i)
        keep[order[i]] = points[order[i]] != points[order[i - 1]];
    return keep;
}

/// Points that keep their distance from all earlier ones. Two that nearly coincide ask for
/// whatever slope joins them, and from 1e-4 of a spacing on their equations are lost in rounding.
std::vector<char> apart_from_earlier(const std::vector<Vec3d>& points, int neighbours) {
    constexpr double least = 1e-3; // of the distance to the last neighbour
    const PointTree tree(points);
    std::vector<Neighbour> seen;
    std::vector<char> keep(points.size(), 1);
    for (std::size_t i = 0; i < points.size(); ++i) {
        tree.nearest(points[i], static_cast<std::size_t>(neighbours) + 1, seen);
        for (const Neighbour& n : seen) {
            const auto j = static_cast<std::size_t>(n.point);
            if (j < i && keep[j] &&
                n.squared_distance < least * least * seen.back().squared_distance)
                keep[i] = 0;
        }
    }
    return keep;
}

/// The farthest of m others that face the point's way is as far as a disc reaches that holds the
/// area of m points.
double spacing_at(std::int32_t i, std::span<const Neighbour> seen,
                  const std::vector<Vec3d>& normals) {
    double facing = 0;
    double squared_radius = 0;
    for (const Neighbour& n : seen.subspan(1)) {
        if (!(normals[n.point].dot(normals[i]) > 0)) continue;
        facing += 1;
        squared_radius = n.squared_distance;
    }
    if (facing == 0) squared_radius = seen[1].squared_distance;
    return std::sqrt(std::numbers::pi * squared_radius / std::max(facing, 1.0));
}

} // namespace

CheckedPoints check(const PointCloud& given, int neighbours) {
    CheckedPoints result{.cloud = given};
    PointCloud& cloud = result.cloud;
    for (std::size_t i = 0; i < cloud.points_world.size(); ++i)
        if (!cloud.points_world[i].allFinite())
            throw InputError(fmt::format("point {} is not finite", i));
    keep_only(cloud, first_at_positions(cloud.points_world));
    keep_only(cloud, apart_from_earlier(cloud.points_world, neighbours));
    const std::size_t count = cloud.points_world.size();
    if (const std::size_t dropped = given.points_world.size() - count; dropped > 0)
        result.warnings.push_back(
            fmt::format("{} points at or next to the position of another were dropped.", dropped));
    if (neighbours < 1 || count < static_cast<std::size_t>(neighbours) + 1)
        throw InputError(fmt::format("{} points are too few to look at {} neighbours of each",
                                     count, neighbours));

    const PointTree tree(cloud.points_world);
    result.normals_given = has_usable_normals(cloud);
    if (result.normals_given) {
        for (Vec3d& n : cloud.normals) n.stableNormalize();
    } else {
        result.warnings.push_back(fmt::format(
            "{}: they are estimated, and outward is a guess where the cloud does not hang together "
            "or has thin parts.",
            cloud.normals.empty() ? "The points have no normals" : "Some normals have no length"));
        // Half of them: a plane asks for less than a blend, and bends less over less.
        cloud.normals = estimated_normals(cloud.points_world, tree, std::max(neighbours / 2, 4));
    }

    result.spacing_world.resize(count);
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, 256), [&](const auto& range) {
        std::vector<Neighbour> seen;
        for (std::size_t i = range.begin(); i < range.end(); ++i) {
            tree.nearest(cloud.points_world[i], static_cast<std::size_t>(neighbours) + 1, seen);
            result.spacing_world[i] = spacing_at(static_cast<std::int32_t>(i), seen, cloud.normals);
        }
    });
    std::vector<double> sorted = result.spacing_world;
    std::ranges::sort(sorted);
    result.median_spacing_world = sorted[count / 2];
    constexpr double wild = 10; // a hundred times the points on the same area
    const double close = sorted[count / 20];
    const double wide = sorted[count - 1 - count / 20];
    if (wide > wild * close)
        result.warnings.push_back(
            fmt::format("The points lie unevenly: a twentieth of them is closer together than "
                        "{:.3g}, and another farther apart than {:.3g}; the surface is vague "
                        "between those.",
                        close, wide));
    return result;
}

PointCloud vertices_of(const CheckedMesh& checked) {
    const Mesh& mesh = checked.mesh;
    PointCloud cloud{mesh.vertices_world,
                     std::vector<Vec3d>(mesh.vertices_world.size(), Vec3d::Zero())};
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        const Vec3d normal = face_normal(mesh, static_cast<int>(t));
        for (int k = 0; k < 3; ++k) {
            const auto corner = [&](int i) { return mesh.triangles[t][(k + i) % 3]; };
            const Vec3d& p = mesh.vertices_world[corner(0)];
            const Vec3d u = mesh.vertices_world[corner(1)] - p;
            const Vec3d v = mesh.vertices_world[corner(2)] - p;
            cloud.normals[corner(0)] += angle_between(u, v) * normal;
        }
    }
    return cloud;
}

} // namespace isocast
