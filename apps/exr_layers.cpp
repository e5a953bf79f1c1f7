// SPDX-License-Identifier: MPL-2.0
#include "apps/exr_layers.h"

#include "apps/inputs.h"
#include "raycaster/effects/curvature_measure.h"

#include <fmt/format.h>

#include <limits>

namespace isocast {

namespace {

Eigen::Matrix4d camera_from_world(const Camera& camera) {
    const Mat3d rotation = camera.view_from_world_rotation();
    Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
    matrix.topLeftCorner<3, 3>() = rotation;
    matrix.topRightCorner<3, 1>() = -rotation * camera.eye_world;
    return matrix;
}

/// The third row is a depth that grows away from the eye: nothing reads it, but without it the
/// matrix would have no inverse.
Eigen::Matrix4d ndc_from_camera(const Camera& camera, double aspect) {
    Eigen::Matrix4d matrix = Eigen::Matrix4d::Zero();
    if (camera.projection == Projection::Perspective) {
        const double tan_y = camera.half_height_at(1);
        matrix(0, 0) = 1 / (tan_y * aspect);
        matrix(1, 1) = 1 / tan_y;
        matrix(2, 3) = -1; // -1 / distance
        matrix(3, 2) = -1;
    } else {
        matrix(0, 0) = 2 / (camera.height_world * aspect);
        matrix(1, 1) = 2 / camera.height_world;
        matrix(2, 2) = -1;
        matrix(3, 3) = 1;
    }
    return matrix;
}

} // namespace

ExrLayers exr_layers_from(std::string_view list) {
    ExrLayers layers;
    for (;;) {
        const auto comma = list.find(',');
        const std::string_view name = list.substr(0, comma);
        if (name == "P")
            layers.position = true;
        else if (name == "N")
            layers.normal = true;
        else if (name == "curvature")
            layers.curvature = true;
        else
            throw UsageError(fmt::format("unknown output '{}' (known: P, N, curvature)", name));
        if (comma == std::string_view::npos) return layers;
        list.remove_prefix(comma + 1);
    }
}

ExrImage exr_image(const FrameImages& frame, const Camera& camera, const ExrLayers& layers) {
    ExrImage exr{.width = frame.hit.width,
                 .height = frame.hit.height,
                 .channels = {},
                 .strings = {},
                 .floats = {},
                 .matrices = {}};
    const std::size_t count = frame.hit.rgba.size() / 4;
    const auto channel = [&](const std::string& name, bool as_half = false) -> auto& {
        ExrChannel& made = exr.channels[name];
        made.as_half = as_half;
        made.values.assign(count, 0.0f);
        return made.values;
    };

    for (std::size_t c = 0; c < 4; ++c) {
        auto& values = channel(std::string(1, "RGBA"[c]), true);
        for (std::size_t i = 0; i < count; ++i) {
            const float coverage = frame.beauty.rgba[4 * i + 3];
            values[i] = c == 3 ? coverage : coverage * frame.beauty.rgba[4 * i + c];
        }
    }

    const Mat3d rotation = camera.view_from_world_rotation();
    auto& z = channel("Z");
    for (std::size_t i = 0; i < count; ++i) {
        const float* hit = &frame.hit.rgba[4 * i];
        z[i] = hit[3] != 0 ? static_cast<float>(-rotation.row(2).dot(Vec3d(hit[0], hit[1], hit[2])))
                           : std::numeric_limits<float>::infinity();
    }

    constexpr const char* axes[] = {"X", "Y", "Z"};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        if (layers.position) {
            auto& p = channel(fmt::format("P.{}", axes[axis]));
            const double eye = camera.eye_world[static_cast<int>(axis)];
            for (std::size_t i = 0; i < count; ++i)
                if (frame.hit.rgba[4 * i + 3] != 0)
                    p[i] = static_cast<float>(eye + double{frame.hit.rgba[4 * i + axis]});
        }
        if (layers.normal) {
            auto& n = channel(fmt::format("N.{}", axes[axis]));
            for (std::size_t i = 0; i < count; ++i) {
                const float* g = &frame.gradient.rgba[4 * i];
                const double length = Vec3d(g[0], g[1], g[2]).norm();
                if (length > 0) n[i] = static_cast<float>(g[axis] / length);
            }
        }
    }

    if (layers.curvature) {
        const auto add = [&](const char* name, CurvatureMeasure measure) {
            auto& values = channel(fmt::format("curvature.{}", name));
            for (std::size_t i = 0; i < count; ++i) {
                const float* k = &frame.curvature.rgba[4 * i];
                if (k[3] != 0) values[i] = static_cast<float>(curvature_measure(measure, k[0], k[1]));
            }
        };
        add("k1", CurvatureMeasure::K1);
        add("k2", CurvatureMeasure::K2);
        add("mean", CurvatureMeasure::Mean);
        add("gauss", CurvatureMeasure::Gauss);
        add("shapeIndex", CurvatureMeasure::ShapeIndex);
        add("curvedness", CurvatureMeasure::Curvedness);
    }

    const Eigen::Matrix4d world_to_camera = camera_from_world(camera);
    const double aspect = double(exr.width) / exr.height;
    exr.matrices["worldToCamera"] = world_to_camera.cast<float>();
    exr.matrices["worldToNDC"] = (ndc_from_camera(camera, aspect) * world_to_camera).cast<float>();
    return exr;
}

} // namespace isocast
