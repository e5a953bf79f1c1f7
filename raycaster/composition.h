// The pass of hits with a solid composed of several objects (thesis section 6.4.3).
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "raycaster/frame.h"

namespace isocast {

/// Writes FrameImage::Hit with w = the object's number + 1, negative where it is taken away from
/// others, so that its gradient leads inwards.
///
/// The composed function's roots are roots of its objects' (minima, maxima and signs of them), so
/// each object is searched as if it were alone, and the tree is evaluated at roots only:
///
///           ┌──────────────────────────────────────────────────────┐
///           ▼                                                      │ passed roots
///     raycast.frag, an object at a time ──► Roots ──► compose.frag ┴─► Hit
///     its next root: position,              one each   the nearest root; does the ray
///     ± distance                                       enter the solid there, or leave it?
///
/// An object is drawn again on the tiles of the picture alone in which rays wait for its next root.
///
/// source  the thesis evaluates the composed function at samples of the ray; roots of exact
///         operands make the crease exact and keep each operand's certificate
void run_composition(FrameContext& frame);

/// Every program of it but the objects' (field_programs).
std::vector<gl::ProgramKey> composition_programs();

} // namespace isocast
