// The truths that pictures are measured against.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/checked_mesh.h"
#include "distance_transform/exact_distance.h"
#include "quadrics/primitives.h"
#include "raycaster/camera.h"
#include "volume/analytic_fields.h"
#include "volume/progress.h"

#include <functional>
#include <string>
#include <vector>

namespace isocast {

/// A picture's rays, one for each pixel, the top row first.
struct View {
    Camera camera;
    int width = 0;
    int height = 0;

    std::size_t pixel_count() const {
        return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    }
    Ray ray(std::size_t pixel) const {
        const auto x = static_cast<int>(pixel % static_cast<std::size_t>(width));
        const auto y = static_cast<int>(pixel / static_cast<std::size_t>(width));
        return camera_ray(camera, width, height, x + 0.5, y + 0.5);
    }
};

/// Calls at(pixel) for every pixel, on all threads. throws  what `progress` does
void for_each_pixel(const View& view, const std::function<void(std::size_t pixel)>& at,
                    const Progress& progress);

/// Where rays first meet a surface, as a parameter of each; infinite where they miss it.
using FirstHits = std::vector<double>;

struct Truth {
    std::string source; // for people
    FirstHits hits;
    /// Of a point that was found in that pixel [world].
    std::function<double(const Vec3d& p_world, std::size_t pixel)> distance_world;
    /// Unit normal there; empty if it is not known.
    std::function<Vec3d(const Vec3d& p_world, std::size_t pixel)> normal;
    /// With the derivatives of a field in closed form; else empty.
    std::function<Jet(const Vec3d& p_world)> jet;
};

/// The zero set of a function within its cube, on which a ray is on the side on which it enters.
/// Rays march by |f| / L, and bisect where f changes sign.
///
/// L      the greatest slope at 20,000 seeded points, half as much again
/// floor  of a step: 1/64 of `detail_world`; only a stretch shorter than that can be missed
Truth truth_of(const AnalyticField& field, double detail_world, const View& view,
               const Progress& progress);

/// A mesh, in double: rays against triangles, and points by their exact distance. Normals are those
/// of the faces.
///
/// mesh, distance  must outlive the truth
Truth truth_of(const CheckedMesh& mesh, const ExactDistance& distance, const View& view,
               const Progress& progress);

/// Rays in double against every primitive that their pixel is near to. The distance is that to the
/// plane through the first one's hit.
Truth truth_of(const Primitives& primitives, const View& view);

} // namespace isocast
