// What a picture takes of SLIM surfaces.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "quadrics/slim_blend.h"
#include "quadrics/splats.h"

namespace isocast {

/// Whether only the outside of the surface shows: it is closed, in front of the eye, and nothing is
/// cut away.
bool shows_outside_only(const SlimSurface& surface, const SplatView& view);

/// The pieces that a picture can show, of all levels that it draws. Where only the outside shows,
/// those that face away are left out.
///
/// number  of the surface, as splats_of() has it
void append_splats(const SlimSurface& surface, std::size_t number, const SplatView& view,
                   Splats& splats);

/// As put_body() of quadrics, with what patches do not know: shaders/quadrics/tree.glsl.
struct SlimPiece {
    const SlimPatch& patch;
    double max_error_world;
};
inline Reach reach_along(const SlimPiece& piece, const Vec3d& n) {
    return reach_along(piece.patch, n);
}
void put_body(const SlimPiece& piece, const PictureSpace& space, float* to);

} // namespace isocast
