// What a picture takes of triangles: what the GL draws of each, and the numbers by which rays meet
// it.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "quadrics/splats.h"

#include <optional>

namespace isocast {

/// A triangle in the picture that holds another's picture with a margin, so that the GL's roundings
/// leave out no pixel. Which pixels show the triangle shaders decide, the same in any part of a
/// picture.
struct TriangleCover {
    Eigen::Vector2d corner; // pixels, as PixelBox
    Eigen::Vector2d side_a; // to the other corners
    Eigen::Vector2d side_b;
    PixelBox box; // that holds the picture
};

/// returns  none if no pixel of the part has its middle near the triangle's picture, or if it has
/// no
///          area
std::optional<TriangleCover> cover_of(const Triangle& triangle, const SplatView& view);

/// Of a triangle, as shaders/quadrics/triangle.glsl takes it.
struct TriangleRay {
    /// The products of two corners each: their product with a ray's direction is the volume that it
    /// spans with that edge, whose sign says on which side of the edge it passes. Of parallel rays
    /// the same in the plane of the picture.
    std::array<Vec3d, 3> edges;
    Vec3d normal;                         // unit
    double offset_world;                  // of its plane, from the eye
    double nearest_world, farthest_world; // along the view
};
TriangleRay ray_of(const Triangle& triangle, const PictureSpace& space);

/// By which shaders find colours and normals.
struct MeshNumbers {
    std::size_t mesh;           // through all primitives, as splats_of() has it
    std::size_t first_triangle; // through all meshes
};
/// Those of a mesh that a picture can show, in order: triangles that share an edge are hit at one
/// depth there and the first one drawn shows, which must not depend on what else is in the part.
void append_splats(const TriangleMesh& mesh, const MeshNumbers& numbers, const SplatView& view,
                   Splats& splats);

} // namespace isocast
