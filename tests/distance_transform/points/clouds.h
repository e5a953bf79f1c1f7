// Clouds for the tests of the meshless transform.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "../fields.h"
#include "distance_transform/convert_points.h"
#include "distance_transform/sample_meshes.h"

#include <random>

namespace isocast::test {

inline std::vector<Vec3d> random_points(std::size_t count, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> any(-1, 1);
    std::vector<Vec3d> points(count);
    for (Vec3d& p : points) p = {any(random), any(random), any(random)};
    return points;
}

/// Points at random on the unit sphere: as uneven as points without order are.
inline PointCloud random_sphere(std::size_t count, unsigned seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    PointCloud cloud;
    for (std::size_t i = 0; i < count; ++i) {
        const Vec3d direction(normal(random), normal(random), normal(random));
        cloud.points_world.push_back(direction.normalized());
        cloud.normals.push_back(direction.normalized());
    }
    return cloud;
}

inline Meshless meshless_of(const PointCloud& cloud, const MeshlessOptions& options = {}) {
    const CheckedPoints points = check(cloud, options.neighbours);
    return {points.cloud.points_world, points.cloud.normals, options};
}

} // namespace isocast::test
