// SPDX-License-Identifier: MPL-2.0
#include "raycaster/scene.h"

#include "volume/errors.h"

#include <fmt/format.h>

#include <algorithm>

namespace isocast {

Traversal traversal_from_name(std::string_view name) {
    if (name == "lists") return Traversal::TileLists;
    if (name == "drawn") return Traversal::DrawnBlocks;
    if (name == "bounds") return Traversal::BoundingFaces;
    if (name == "walk") return Traversal::Walk;
    throw InputError(fmt::format("'{}' is not one of lists, drawn, bounds, walk", name));
}

std::vector<FieldObject> objects_of(const Scene& scene) {
    if (scene.field && !scene.objects.empty())
        throw InputError("the scene has a field of its own and objects beside it");
    if (scene.field) return {{scene.field, scene.iso_world, scene.filter, scene.derivative_filter}};
    const std::size_t count = scene.objects.size();
    const bool has_primitives = scene.primitives && scene.primitives->count() > 0;
    if (count == 0 && !has_primitives)
        throw InputError("the scene has neither a field nor primitives");
    if (count == 0) return {};
    if (count > max_object_count)
        throw InputError(fmt::format("{} objects: {} at most", count, max_object_count));
    for (std::size_t i = 0; i < count; ++i)
        if (!scene.objects[i].field) throw InputError(fmt::format("object {} has no field", i));
    check_tree(tree_of(scene), static_cast<int>(count));
    return scene.objects;
}

CsgTree tree_of(const Scene& scene) {
    const int count = scene.field ? 1 : static_cast<int>(scene.objects.size());
    return scene.tree.empty() ? union_of_all(count) : scene.tree;
}

} // namespace isocast
