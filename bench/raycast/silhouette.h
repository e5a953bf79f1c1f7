// What samples at a rate miss along the silhouette of a sphere (thesis figure 6.7).
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "raycaster/renderer.h"
#include "volume/analytic_fields.h"

#include "volume/dense_field.h"

#include <algorithm>
#include <cmath>

namespace isocast {

struct SilhouetteError {
    int rays = 0;                    // that meet the surface, by the certified search
    int missed = 0;                  // of those, by samples
    int false_hits = 0;              // of samples, where the certified search finds none
    double deepest_voxels = 0;       // a missed ray's greatest depth below the surface
    double bound_voxels = 0;         // R - sqrt(R^2 - c^2/4) for the distance c between samples
    double surface_error_voxels = 0; // greatest distance of certified hits from the sphere
};

/// Spheres of `radius` voxels, which the field gives exactly, under parallel rays: `phases` of
/// them, each moved along the rays by a fraction of the distance between two samples.
///
/// factor  1: samples at `rate`; else `rate` is the greatest one, r1, and r0 = rate / factor
inline SilhouetteError silhouette_error(Renderer& renderer, double radius, double rate, int factor,
                                        int size, int phases) {
    const int n = 2 * static_cast<int>(std::ceil(radius)) + 16;
    const Vec3d to_eye(0.48, 0.36, 0.8);
    const double chord = 1 / rate;
    const Vec3d base(0.5 * n + 0.13, 0.5 * n - 0.24, 0.5 * n + 0.32); // off the lattice
    // Rays start at the plane through the eye, where samples are counted from.
    const Camera camera{.eye_world = base + 3 * radius * to_eye,
                        .target_world = base,
                        .projection = Projection::Orthographic,
                        .height_world = 2 * radius + 1};
    SilhouetteError error{.bound_voxels = radius - std::sqrt(radius * radius - chord * chord / 4)};
    for (int phase = 0; phase < phases; ++phase) {
        const Vec3d middle = base + chord * phase / phases * to_eye;
        const IndexBox box{Index3::Zero(), Index3::Constant(n)};
        std::vector<float> values;
        for (int z = 0; z < n; ++z)
            for (int y = 0; y < n; ++y)
                for (int x = 0; x < n; ++x)
                    values.push_back(static_cast<float>((Vec3d(x, y, z) - middle).norm() - radius));
        Scene scene{
            .field = std::make_shared<DenseField>(GridSpace::uniform(1), box, std::move(values))};
        const auto hits = [&] {
            renderer.load(scene);
            renderer.draw(camera, size, size, {FrameImage::Hit});
            return renderer.read(FrameImage::Hit);
        };
        const Image truth = hits();
        scene.quality = {.rate = rate / factor, .rate_factor = factor};
        const Image sampled = hits();
        for (int y = 0; y < size; ++y) {
            for (int x = 0; x < size; ++x) {
                const float* hit = truth.pixel(x, y);
                const bool is_found = sampled.pixel(x, y)[3] != 0;
                error.false_hits += is_found && hit[3] == 0;
                if (hit[3] == 0) continue;
                ++error.rays;
                const Vec3d p = camera.eye_world + Vec3d(hit[0], hit[1], hit[2]);
                error.surface_error_voxels =
                    std::max(error.surface_error_voxels, std::abs((p - middle).norm() - radius));
                if (is_found) continue;
                ++error.missed;
                const Ray ray = camera_ray(camera, size, size, x + 0.5, y + 0.5);
                const double offset =
                    ray.direction_world.normalized().cross(middle - ray.origin_world).norm();
                error.deepest_voxels = std::max(error.deepest_voxels, radius - offset);
            }
        }
    }
    return error;
}

} // namespace isocast
