// SPDX-License-Identifier: MPL-2.0
#include "apps/exr_layers.h"

#include "apps/inputs.h"
#include "raycaster/effects/curvature_measure.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace isocast {

namespace {

using Known = std::pair<std::string_view, bool ExrLayers::*>;
constexpr std::array<Known, 8> known_layers{{{"P", &ExrLayers::position},
                                             {"N", &ExrLayers::normal},
                                             {"curvature", &ExrLayers::curvature},
                                             {"T", &ExrLayers::directions},
                                             {"AO", &ExrLayers::occlusion},
                                             {"shadow", &ExrLayers::shadow},
                                             {"id", &ExrLayers::id},
                                             {"steps", &ExrLayers::steps}}};

Eigen::Matrix4d camera_from_world(const Camera& camera) {
    const Mat3d rotation = camera.view_from_world_rotation();
    Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
    matrix.topLeftCorner<3, 3>() = rotation;
    matrix.topRightCorner<3, 1>() = -rotation * camera.eye_world;
    return matrix;
}

/// The third row is a depth that grows away from the eye: nothing reads it, but without it the
/// matrix would have no inverse.
Eigen::Matrix4d ndc_from_camera(const Camera& camera, double aspect, double off_axis) {
    Eigen::Matrix4d matrix = Eigen::Matrix4d::Zero();
    if (camera.projection == Projection::Perspective) {
        const double tan_y = camera.half_height_at(1);
        matrix(0, 0) = 1 / (tan_y * aspect);
        matrix(1, 1) = 1 / tan_y;
        matrix(0, 2) = -off_axis; // z is negative in front
        matrix(2, 3) = -1;        // -1 / distance
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
        const auto layer = std::ranges::find(known_layers, list.substr(0, comma), &Known::first);
        if (layer == known_layers.end())
            throw UsageError(fmt::format("unknown output '{}' (known: {})", list.substr(0, comma),
                                         exr_layer_names));
        layers.*layer->second = true;
        if (comma == std::string_view::npos) return layers;
        list.remove_prefix(comma + 1);
    }
}

std::vector<std::string> names_of(const ExrLayers& layers) {
    std::vector<std::string> names;
    for (const auto& [name, layer] : known_layers)
        if (layers.*layer) names.emplace_back(name);
    return names;
}

std::vector<FrameImage> images_of(const ExrLayers& layers) {
    std::vector<FrameImage> images{FrameImage::Hit};
    if (layers.normal || layers.directions) images.push_back(FrameImage::Gradient);
    if (layers.curvature) images.push_back(FrameImage::Curvature);
    if (layers.directions) images.push_back(FrameImage::Direction);
    if (layers.occlusion) images.push_back(FrameImage::Occlusion);
    if (layers.shadow) images.push_back(FrameImage::Shadow);
    if (layers.steps) images.push_back(FrameImage::Steps);
    return images;
}

ExrImage exr_image(const FrameImages& frame, const Camera& camera, const ExrLayers& layers,
                   const std::optional<double>& aspect, double off_axis) {
    const Image& hits = frame.at(FrameImage::Hit);
    ExrImage exr{.width = hits.width,
                 .height = hits.height,
                 .channels = {},
                 .strings = {},
                 .floats = {},
                 .matrices = {}};
    const std::size_t count = hits.rgba.size() / 4;
    const auto is_hit = [&](std::size_t i) { return hits.rgba[4 * i + 3] != 0; };
    /// A channel with value(i) where pixel i is a hit, and 0 elsewhere.
    const auto add = [&](const std::string& name, auto value) -> std::vector<float>& {
        std::vector<float>& values = exr.channels[name].values;
        values.assign(count, 0.0f);
        for (std::size_t i = 0; i < count; ++i)
            if (is_hit(i)) values[i] = static_cast<float>(value(i));
        return values;
    };
    const auto vector = [](const Image& image, std::size_t i) {
        return Vec3d(image.rgba[4 * i], image.rgba[4 * i + 1], image.rgba[4 * i + 2]);
    };
    const auto add_vector = [&](const std::string& name, auto value) {
        for (const int axis : {0, 1, 2})
            add(fmt::format("{}.{}", name, "XYZ"[axis]),
                [&](std::size_t i) { return value(i)[axis]; });
    };

    if (const auto beauty = frame.find(FrameImage::Beauty); beauty != frame.end())
        for (std::size_t c = 0; c < 4; ++c) {
            ExrChannel& channel = exr.channels[std::string(1, "RGBA"[c])];
            channel.as_half = true;
            for (std::size_t i = 0; i < count; ++i)
                channel.values.push_back(beauty->second.rgba[4 * i + c]);
        }
    const Mat3d rotation = camera.view_from_world_rotation();
    std::vector<float>& z =
        add("Z", [&](std::size_t i) { return -rotation.row(2).dot(vector(hits, i)); });
    for (std::size_t i = 0; i < count; ++i)
        if (!is_hit(i)) z[i] = std::numeric_limits<float>::infinity();

    const auto unit_gradient = [&](std::size_t i) -> Vec3d {
        const Vec3d gradient = vector(frame.at(FrameImage::Gradient), i);
        return gradient.norm() > 0 ? Vec3d(gradient.normalized()) : Vec3d::Zero();
    };
    if (layers.position)
        add_vector("P", [&](std::size_t i) -> Vec3d { return camera.eye_world + vector(hits, i); });
    if (layers.normal) add_vector("N", unit_gradient);
    if (layers.directions) {
        const Image& directions = frame.at(FrameImage::Direction);
        add_vector("T1", [&](std::size_t i) { return vector(directions, i); });
        add_vector("T2", [&](std::size_t i) -> Vec3d {
            return unit_gradient(i).cross(vector(directions, i));
        });
    }
    if (layers.curvature) {
        const Image& curvatures = frame.at(FrameImage::Curvature);
        const auto add_of = [&](const char* name, CurvatureMeasure measure) {
            add(fmt::format("curvature.{}", name), [&](std::size_t i) {
                return curvature_measure(measure, curvatures.rgba[4 * i],
                                         curvatures.rgba[4 * i + 1]);
            });
        };
        add_of("k1", CurvatureMeasure::K1);
        add_of("k2", CurvatureMeasure::K2);
        add_of("mean", CurvatureMeasure::Mean);
        add_of("gauss", CurvatureMeasure::Gauss);
        add_of("shapeIndex", CurvatureMeasure::ShapeIndex);
        add_of("curvedness", CurvatureMeasure::Curvedness);
        add("curvature.flag", [&](std::size_t i) { return curvatures.rgba[4 * i + 3]; });
    }
    const auto add_first = [&](const std::string& name, FrameImage image) {
        add(name, [&](std::size_t i) { return frame.at(image).rgba[4 * i]; });
    };
    if (layers.occlusion) add_first("AO.Y", FrameImage::Occlusion);
    if (layers.shadow) add_first("shadow.Y", FrameImage::Shadow);
    if (layers.id) add("id", [&](std::size_t i) { return std::abs(hits.rgba[4 * i + 3]); });
    if (layers.steps) {
        std::vector<float>& steps = exr.channels["debug.steps"].values;
        for (std::size_t i = 0; i < count; ++i)
            steps.push_back(frame.at(FrameImage::Steps).rgba[4 * i]);
    }

    const Eigen::Matrix4d world_to_camera = camera_from_world(camera);
    exr.matrices["worldToCamera"] = world_to_camera.cast<float>();
    exr.matrices["worldToNDC"] =
        (ndc_from_camera(camera, aspect.value_or(double(exr.width) / exr.height), off_axis) *
         world_to_camera)
            .cast<float>();
    return exr;
}

} // namespace isocast
