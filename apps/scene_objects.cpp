// SPDX-License-Identifier: MPL-2.0
#include "apps/scene_objects.h"

#include "distance_transform/convert.h"
#include "volume/errors.h"
#include "volume/histogram.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace isocast {

namespace {

/// Refuses what a Scene cannot hold.
const SceneObject& only_object(const SceneFile& scene) {
    const std::vector<std::size_t> drawn = drawn_objects(scene);
    if (drawn.size() != 1)
        throw InputError(fmt::format("{} objects: one at a time can be drawn", drawn.size()));
    const SceneObject& object = scene.objects[drawn.front()];
    if (object.csg || !object.morph.empty())
        throw InputError("csg and morph of objects cannot be drawn yet");
    return object;
}

/// The file of a series at a time.
std::string file_of_series(const SceneObject& object) {
    const auto first = object.series.find('#');
    const auto last = object.series.rfind('#');
    return fmt::format("{}{:0{}}{}", object.series.substr(0, first), std::lround(object.time),
                       last - first + 1, object.series.substr(last + 1));
}

Input input_of(const SceneObject& object) {
    if (!object.series.empty()) return input_from(file_of_series(object));
    return input_from(object.mesh.empty() ? object.field : object.mesh);
}

} // namespace

OpenedObject open_object(const SceneFile& scene) {
    OpenedObject opened{.input = input_of(only_object(scene))};
    if (opened.input.is_mesh())
        opened.mesh = read_checked_mesh(opened.input);
    else
        opened.field = read_field(opened.input, scene.memory_bytes.value_or(default_field_bytes()));
    return opened;
}

Scene scene_from(const SceneFile& scene, OpenedObject opened, const Progress& progress,
                 const std::function<void(const std::string&)>& warn) {
    const SceneObject& object = only_object(scene);
    if (opened.mesh) {
        const ConvertOptions options{
            .voxel_size_world = voxel_size_for_resolution(bounding_box(opened.mesh->mesh),
                                                          object.resolution.value_or(256)),
            .memory_bytes = scene.memory_bytes.value_or(ConvertOptions{}.memory_bytes)};
        ConvertResult result = convert(*opened.mesh, options, progress);
        for (const auto& warning : opened.mesh->warnings) warn(warning);
        for (const auto& warning : result.warnings) warn(warning);
        opened.field = std::make_shared<SparseField>(std::move(result.field));
    }
    Scene out;
    out.field = std::move(opened.field);
    // A file may hold anything; meshes and built-in fields have their surface at 0.
    const bool is_file = opened.input.kind == Input::Kind::FieldFile;
    out.iso_world = object.iso_world ? *object.iso_world
                    : is_file        ? suggested_iso(*out.field).iso
                                     : 0;
    out.filter = object.filter.value_or(scene.filter);
    out.derivative_filter = scene.derivative_filter;
    out.curvature_scale_voxels = scene.curvature_scale_voxels;
    out.storage = scene.storage;
    out.quality = scene.quality;
    return out;
}

Look look_of(const SceneFile& scene, bool is_opaque) {
    Look look = scene.look;
    look.material.colour = only_object(scene).colour.value_or(look.material.colour);
    if (!is_opaque) {
        look.background = Vec3d::Zero();
        look.shows_environment = false;
    }
    return look;
}

} // namespace isocast
