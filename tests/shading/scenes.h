// Fields and quantities that tests of shadows and of ambient occlusion share.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "shading_scene.h"
#include "volume/dense_field.h"

#include <algorithm>

namespace isocast::test {

/// The floor z = floor_z, and a ball over it: exact distances outside, away from where both are
/// near.
inline constexpr double floor_z = -0.75;
struct Ball {
    Vec3d centre;
    double radius;
};
inline AnalyticField floor_and(const Ball& ball) {
    return {"floor and ball", [=](const Vec3d& p) {
                return Jet{.value =
                               std::min(p.z() - floor_z, (p - ball.centre).norm() - ball.radius)};
            }};
}
inline std::shared_ptr<const FieldSource> floor_and_ball(const Ball& ball) {
    return sampled(floor_and(ball), 64);
}

/// Samples of `field` on any grid.
inline std::shared_ptr<const FieldSource> on_grid(const AnalyticField& field,
                                                  const GridSpace& space, const Index3& size) {
    std::vector<float> values;
    for (int z = 0; z < size.z(); ++z)
        for (int y = 0; y < size.y(); ++y)
            for (int x = 0; x < size.x(); ++x)
                values.push_back(float(field.jet(space.to_world(Vec3d(x, y, z))).value));
    return std::make_shared<DenseField>(space, IndexBox{Index3::Zero(), size}, std::move(values));
}

/// Turned, and its voxels are no cubes: 0.03, 0.04, 0.025.
inline GridSpace skew_space() {
    GridSpace space;
    space.world_from_index.linear() = Eigen::AngleAxisd(0.5, Vec3d(1, 2, 2) / 3) *
                                      Vec3d(0.03, 0.04, 0.025).asDiagonal().toDenseMatrix();
    space.world_from_index.translation() = -(space.world_from_index.linear() * Vec3d(40, 32, 48));
    return space;
}

/// Within six of the 48 samples from the border of [-1, 1]^3: there the spline is not linear where
/// samples are, by 0.27 of its deviation more each voxel.
inline bool is_near_border(const Vec3d& p) {
    return p.cwiseAbs().maxCoeff() > 1 - 6 * 2.0 / 47;
}

/// A pixel that hits, and where [world].
struct HitPixel {
    int x, y;
    Vec3d p;
};
inline std::vector<HitPixel> hit_pixels(const Image& hits, const Camera& camera) {
    std::vector<HitPixel> pixels;
    for (int y = 0; y < hits.height; ++y)
        for (int x = 0; x < hits.width; ++x)
            if (const float* hit = hits.pixel(x, y); hit[3] != 0)
                pixels.push_back({x, y, camera.eye_world + Vec3d(hit[0], hit[1], hit[2])});
    return pixels;
}
/// Those on the floor. 1e-3: of some voxels of 0.03 where a ball's distances make the spline's
/// floor uneven.
inline std::vector<HitPixel> floor_pixels(const Image& hits, const Camera& camera) {
    std::vector<HitPixel> pixels = hit_pixels(hits, camera);
    std::erase_if(pixels,
                  [](const HitPixel& pixel) { return std::abs(pixel.p.z() - floor_z) > 1e-3; });
    return pixels;
}

} // namespace isocast::test
