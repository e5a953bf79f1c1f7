// Where the surfaces of a scene lie, for cameras that frame them.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "raycaster/scene.h"

#include <Eigen/Geometry>

#include <array>
#include <vector>

namespace isocast {

std::array<Vec3d, 8> corners_of(const Eigen::AlignedBox3d& box);
/// Corners of the box of points lo ... hi - 1.
std::array<Vec3d, 8> corners_of(const IndexBox& box, const GridSpace& space);
/// The box along the world's axes around them; empty if `box` is.
Eigen::AlignedBox3d world_box(const IndexBox& box, const GridSpace& space);

/// The isosurfaces' boxes, and that of the primitives, as the scene's tree composes them.
struct ShownSurfaces {
    const Scene& scene;
    std::vector<IndexBox> boxes;        // of the scene's objects: filtering/blocks.h
    Eigen::AlignedBox3d primitives_box; // as a picture has them; else empty

    /// False if no field crosses its iso value, or the boxes of several leave nothing.
    bool is_any() const;
    /// Corners of the box of the isosurface [world]; of the field's extent where there is none. Of
    /// several objects the least box along the world's axes that the tree of their boxes' gives.
    std::array<Vec3d, 8> box_world() const;
    /// Points whose convex hull is about that of all that is drawn: the corners of that box, or of
    /// primitives alone their farthest points. Of dots where they are, however large a picture has
    /// them.
    std::vector<Vec3d> points_world() const;
};

} // namespace isocast
