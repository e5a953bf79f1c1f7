// SPDX-License-Identifier: MPL-2.0
#include "raycaster/shown_surfaces.h"

#include "quadrics/primitives.h"

#include <span>

namespace isocast {

namespace {

using Box = Eigen::AlignedBox3d;

bool is_one_field(const ShownSurfaces& shown) {
    return shown.boxes.size() == 1 && !is_composed(shown.scene) && shown.primitives_box.isEmpty();
}

Box composed_box(const ShownSurfaces& shown, const Box& of_primitives) {
    if (shown.boxes.empty()) return of_primitives;
    const std::vector<FieldObject> objects = objects_of(shown.scene);
    std::vector<Box> boxes;
    for (std::size_t i = 0; i < objects.size(); ++i)
        boxes.push_back(world_box(shown.boxes[i], objects[i].field->space()));
    if (!is_composed(shown.scene)) return boxes.front().merged(of_primitives);
    return evaluate(
               tree_of(shown.scene), std::span<const Box>(boxes),
               [](const Box& a, const Box& b) { return a.merged(b); },
               [](const Box& a, const Box& b) { return a.intersection(b); },
               [](const Box& a, const Box&) { return a; })
        .merged(of_primitives);
}

} // namespace

std::array<Vec3d, 8> corners_of(const Box& box) {
    std::array<Vec3d, 8> corners;
    for (int i = 0; i < 8; ++i)
        corners[static_cast<std::size_t>(i)] = box.corner(static_cast<Box::CornerType>(i));
    return corners;
}

std::array<Vec3d, 8> corners_of(const IndexBox& box, const GridSpace& space) {
    std::array<Vec3d, 8> corners;
    for (int i = 0; i < 8; ++i)
        corners[static_cast<std::size_t>(i)] = space.to_world(
            Vec3d(i & 1 ? box.hi.x() - 1 : box.lo.x(), i & 2 ? box.hi.y() - 1 : box.lo.y(),
                  i & 4 ? box.hi.z() - 1 : box.lo.z()));
    return corners;
}

Box world_box(const IndexBox& box, const GridSpace& space) {
    Box around;
    if (!box.is_empty())
        for (const Vec3d& corner : corners_of(box, space)) around.extend(corner);
    return around;
}

bool ShownSurfaces::is_any() const {
    return is_one_field(*this) ? !boxes.front().is_empty()
                               : !composed_box(*this, primitives_box).isEmpty();
}

std::array<Vec3d, 8> ShownSurfaces::box_world() const {
    if (!boxes.empty() && (!is_any() || is_one_field(*this))) {
        const FieldObject object = objects_of(scene).front();
        return corners_of(is_any() ? boxes.front() : object.field->extent(), object.field->space());
    }
    return corners_of(composed_box(*this, primitives_box));
}

std::vector<Vec3d> ShownSurfaces::points_world() const {
    if (boxes.empty()) return extreme_points(*scene.primitives);
    const bool has_dots = scene.primitives && !scene.primitives->dots.empty();
    const std::array<Vec3d, 8> box =
        has_dots ? corners_of(composed_box(*this, box_of(*scene.primitives))) : box_world();
    return {box.begin(), box.end()};
}

} // namespace isocast
