// What a picture takes of bilinear patches and of quadratic functions in tetrahedra.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "quadrics/splats.h"

namespace isocast {

/// A patch from the eye, about the point of it that is nearest to the eye: c + U h + V e + UV d
/// with U = u - base_u, V = v - base_v. What is close to the eye keeps its digits, however large
/// the patch.
struct PatchFrame {
    Vec3d c, h, e, d;
    double base_u = 0;
    double base_v = 0;
};
/// In view space; of parallel rays about the point nearest to the view's axis.
PatchFrame frame_of(const Patch& patch, const PictureSpace& space);

/// Those of a mesh that a picture can show.
///
/// number  of the mesh, as splats_of() has it
void append_splats(const PatchMesh& mesh, std::size_t number, const SplatView& view,
                   Splats& splats);
void append_splats(const TetrahedralMesh& mesh, std::size_t number, const SplatView& view,
                   Splats& splats);

/// As put_body() of quadrics, for rays from anywhere: shaders/quadrics/tree.glsl.
void put_body(const Patch& patch, const PictureSpace& space, float* to);
void put_body(const Tetrahedron& tetrahedron, const PictureSpace& space, float* to);

} // namespace isocast
