// SPDX-License-Identifier: MPL-2.0
#include "apps/stereo.h"

#include <cmath>

namespace isocast {

std::vector<PictureView> views_of(const SceneFile& scene, const Camera& camera) {
    const int width = scene.output.width;
    if (!scene.camera.is_stereo) return {{.camera = camera, .picture_width = width}};
    const double distance_world = (camera.target_world - camera.eye_world).norm();
    // 1/30: stereo photography's rule of thumb, for the nearest thing; here for the target.
    const double separation_world = scene.camera.eye_separation_world.value_or(distance_world / 30);
    const double pixel_slope = 2 * camera.half_height_at(1) / scene.output.height;
    // How far the target is from where each eye looks.
    const double aside =
        std::round(128 * (separation_world / 2 / distance_world / pixel_slope)) / 128;
    const int margin = static_cast<int>(std::ceil(aside));
    const Vec3d to_right = separation_world / 2 * camera.view_from_world_rotation().row(0);
    std::vector<PictureView> views;
    for (const int side : {-1, 1}) {
        PictureView& view = views.emplace_back();
        view.name = side < 0 ? "left" : "right";
        view.camera = camera;
        view.camera.eye_world += side * to_right;
        view.camera.target_world += side * to_right;
        view.picture_width = width + 2 * margin;
        view.first_pixel = margin - side * aside;
    }
    return views;
}

} // namespace isocast
