// SPDX-License-Identifier: MPL-2.0
#include "apps/sequence.h"

#include <algorithm>
#include <numbers>

namespace isocast {

namespace {

/// The part of a sequence that has passed at frame i.
double passed(int i, int count, bool is_loop) {
    return is_loop ? double(i) / count : count > 1 ? double(i) / (count - 1) : 0;
}

/// A key's eye, target and angle of view.
using KeyVector = Eigen::Matrix<double, 7, 1>;

KeyVector vector_of(const CameraKey& key, const Camera& base) {
    KeyVector v;
    v << key.eye_world, key.target_world.value_or(base.target_world),
        key.fov_y_degrees.value_or(base.fov_y_degrees);
    return v;
}

/// At `time`, which lies between the first key's and the last's.
KeyVector on_path(const std::vector<CameraKey>& keys, const Camera& base, double time,
                  bool is_smooth) {
    const auto after = std::ranges::upper_bound(keys, time, {}, &CameraKey::time);
    const auto last = std::ssize(keys) - 1;
    const auto i = std::clamp<std::ptrdiff_t>(after - keys.begin() - 1, 0, last - 1);
    const auto time_of = [&](std::ptrdiff_t j) { return keys[static_cast<std::size_t>(j)].time; };
    const auto at = [&](std::ptrdiff_t j) {
        return vector_of(keys[static_cast<std::size_t>(j)], base);
    };
    const double step = time_of(i + 1) - time_of(i);
    const double u = (time - time_of(i)) / step;
    if (!is_smooth) return (1 - u) * at(i) + u * at(i + 1);
    const auto slope = [&](std::ptrdiff_t j) -> KeyVector {
        const auto lo = std::max<std::ptrdiff_t>(j - 1, 0);
        const auto hi = std::min(j + 1, last);
        return (at(hi) - at(lo)) / (time_of(hi) - time_of(lo));
    };
    // Hermite's basis.
    const double v = 1 - u;
    return v * v * (1 + 2 * u) * at(i) + u * u * (1 + 2 * v) * at(i + 1) +
           step * u * v * (v * slope(i) - u * slope(i + 1));
}

} // namespace

Change change_of_key(const std::string& key) {
    const bool is_of_object = key.starts_with("object.");
    return is_of_object && key.ends_with(".iso")                                    ? Change::Iso
           : is_of_object || key.starts_with("quality.") || key.starts_with("cut.") ? Change::Load
           : key.starts_with("camera.") ? Change::Nothing
                                        : Change::Look;
}

Change change_of(const SceneFile& scene) {
    Change change = Change::Nothing;
    for (const Animation& animation : scene.animations)
        change = std::max(change, change_of_key(animation.key));
    return change;
}

SceneFile scene_at(const SceneFile& scene, int i, int count) {
    SceneFile out = scene;
    for (const Animation& animation : scene.animations) {
        const double u = passed(i, count, animation.is_loop);
        set_number(out, animation.key, (1 - u) * animation.from + u * animation.to);
    }
    return out;
}

Camera camera_at(const SceneFile& scene, const Camera& camera, int i, int count) {
    Camera out = camera;
    if (!scene.camera_keys.empty()) {
        const double first = scene.camera_keys.front().time;
        const double last = scene.camera_keys.back().time;
        const double u = passed(i, count, false);
        const KeyVector v =
            on_path(scene.camera_keys, camera, (1 - u) * first + u * last, scene.has_smooth_path);
        out.eye_world = v.head<3>();
        out.target_world = v.segment<3>(3);
        out.fov_y_degrees = v[6];
    } else if (scene.turntable_degrees != 0) {
        // A loop: the frame after the last has turned all the way.
        const double angle =
            scene.turntable_degrees * passed(i, count, true) * std::numbers::pi / 180;
        out.eye_world = camera.target_world + Eigen::AngleAxisd(angle, camera.up.normalized()) *
                                                  (camera.eye_world - camera.target_world);
    }
    return out;
}

} // namespace isocast
