// Covers of points by SLIM surfaces against the surfaces that these sample.
// SPDX-License-Identifier: MPL-2.0
#include "quadrics/slim_points.h"
#include "random_primitives.h"
#include "volume/errors.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <functional>
#include <numbers>

namespace isocast {
namespace {

struct Cloud {
    std::vector<Vec3d> points_world, normals;
    std::vector<double> spacing_world;
    SlimPoints all() const { return {points_world, normals, spacing_world}; }
};
using Surface = std::function<std::optional<std::pair<Vec3d, Vec3d>>(Random&)>; // point, normal

/// noise_world  along the normal, evenly distributed on either side
Cloud cloud_of(const Surface& surface, double area_world, int count, double noise_world) {
    Random random(11);
    Cloud cloud;
    while (std::ssize(cloud.points_world) < count)
        if (const auto sample = surface(random)) {
            const auto& [p, n] = *sample;
            cloud.points_world.push_back(p + random.uniform(-noise_world, noise_world) * n);
            cloud.normals.push_back(n);
        }
    cloud.spacing_world.assign(cloud.points_world.size(), std::sqrt(area_world / count));
    return cloud;
}
std::optional<std::pair<Vec3d, Vec3d>> on_sphere(Random& random) {
    const Vec3d n = random.unit();
    return std::pair(n, n);
}
std::optional<std::pair<Vec3d, Vec3d>> on_torus(Random& random) { // of radii 1 and 0.4
    const double around = random.uniform(0, 2 * std::numbers::pi);
    const double across = random.uniform(0, 2 * std::numbers::pi);
    const Vec3d out(std::cos(around), std::sin(around), 0);
    const Vec3d n = std::cos(across) * out + std::sin(across) * Vec3d::UnitZ();
    // Accepted by the element of area, (1 + 0.4 cos) / 1.4 of the greatest.
    if (random.uniform(0, 1.4) > 1 + 0.4 * std::cos(across)) return std::nullopt;
    return std::pair(Vec3d(out + 0.4 * n), n);
}
double distance_to_sphere(const Vec3d& p) {
    return std::abs(p.norm() - 1);
}
double distance_to_torus(const Vec3d& p) {
    return std::abs(std::hypot(std::hypot(p.x(), p.y()) - 1, p.z()) - 0.4);
}

/// Rays against the surface's normals, from 0.1 in front of it to as far behind.
void expect_covered(const SlimLevel& level, const Surface& surface,
                    const std::function<double(const Vec3d&)>& distance, double most_off) {
    Random random(12);
    for (int i = 0; i < 3000; ++i) {
        const auto sample = surface(random);
        if (!sample) continue;
        const auto& [p, n] = *sample;
        bool is_met = false;
        for (const SlimPatch& patch : level.patches)
            for (const SlimHit& hit : intersect(patch, p + 0.1 * n, -n, true)) {
                if (hit.t > 0.2) continue;
                is_met = true;
                ASSERT_LT(distance(p + (0.1 - hit.t) * n), most_off);
            }
        ASSERT_TRUE(is_met) << p.transpose();
    }
}

TEST(SlimPoints, SphereAndTorusWithNoiseAreCoveredWithinTheError) {
    const double pi = std::numbers::pi;
    const double noise = 1e-3;
    const double error = 4e-3;
    for (const bool is_torus : {false, true}) {
        const Surface surface = is_torus ? Surface(on_torus) : Surface(on_sphere);
        const Cloud cloud = cloud_of(surface, is_torus ? 4 * pi * pi * 0.4 : 4 * pi, 30000, noise);
        std::vector<SlimReport> reports;
        const SlimSurface made = slim_of_points(cloud.all(), error, reports);
        check(made);
        EXPECT_FALSE(made.is_closed);
        EXPECT_LT(made.levels[0].patches.size(), cloud.points_world.size() / 50);
        EXPECT_EQ(reports[0].over_bound, 0U);
        EXPECT_LE(reports[0].greatest_error_world, error);
        // A point is off by the noise, the patch from the point by the error.
        expect_covered(made.levels[0], surface, is_torus ? distance_to_torus : distance_to_sphere,
                       error + noise);
    }
}

TEST(SlimPoints, OpenCloudsEndWithinTwoCells) {
    const Surface half = [](Random& random) {
        auto sample = on_sphere(random);
        return sample->first.z() > 0 ? sample : std::nullopt;
    };
    const Cloud cloud = cloud_of(half, 2 * std::numbers::pi, 20000, 0);
    std::vector<SlimReport> reports;
    const double error = 2e-3;
    const SlimSurface made = slim_of_points(cloud.all(), error, reports);
    expect_covered(made.levels[0], half, distance_to_sphere, error);
    // Nothing is met by rays towards the axis that are two cells' diagonals below the border.
    const double past = 2 * 3 * std::numbers::sqrt2 * cloud.spacing_world[0];
    Random random(13);
    for (int i = 0; i < 3000; ++i) {
        const double around = random.uniform(0, 2 * std::numbers::pi);
        const Vec3d out(std::cos(around), std::sin(around), 0);
        const Vec3d origin = 2 * out - random.uniform(1, 5) * past * Vec3d::UnitZ();
        for (const SlimPatch& patch : made.levels[0].patches)
            EXPECT_TRUE(intersect(patch, origin, -out, false).empty());
    }
}

TEST(SlimPoints, SheetsBackToBackStayApart) {
    // A slab as thick as half of the least radius, whose sides have points alone.
    Random random(14);
    Cloud cloud;
    for (int i = 0; i < 20000; ++i) {
        const double side = random.coin() ? 1 : -1;
        cloud.points_world.emplace_back(random.uniform(-1, 1), random.uniform(-1, 1), side * 0.02);
        cloud.normals.push_back(side * Vec3d::UnitZ());
        cloud.spacing_world.push_back(0.02);
    }
    std::vector<SlimReport> reports;
    const SlimSurface made = slim_of_points(cloud.all(), 1e-3, reports);
    EXPECT_EQ(reports[0].over_bound, 0U);
    EXPECT_LT(reports[0].greatest_error_world, 1e-9); // flat: roundings, and 1e-12 of the sums
}

TEST(SlimPoints, TooFewAreRefused) {
    Cloud cloud = cloud_of(on_sphere, 4 * std::numbers::pi, 11, 0);
    std::vector<SlimReport> reports;
    EXPECT_THROW(slim_of_points(cloud.all(), 0.01, reports), InputError);
    cloud = cloud_of(on_sphere, 4 * std::numbers::pi, 12, 0);
    EXPECT_FALSE(slim_of_points(cloud.all(), 0.01, reports).levels[0].patches.empty());
}

TEST(SlimPoints, ThreadsDoNotMatter) {
    const Cloud cloud = cloud_of(on_torus, 16, 5000, 1e-3);
    std::vector<SlimSurface> made;
    for (const std::size_t threads : {1, 3}) {
        const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
        std::vector<SlimReport> reports;
        made.push_back(slim_of_points(cloud.all(), 4e-3, reports));
    }
    ASSERT_EQ(made[0].patch_count(), made[1].patch_count());
    for (std::size_t i = 0; i < made[0].levels[0].patches.size(); ++i) {
        const SlimPatch& one = made[0].levels[0].patches[i];
        const SlimPatch& other = made[1].levels[0].patches[i];
        EXPECT_EQ(one.centre_world, other.centre_world);
        EXPECT_EQ(one.radius_world, other.radius_world);
        EXPECT_EQ(one.height, other.height);
    }
}

} // namespace
} // namespace isocast
