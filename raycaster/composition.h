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

/// The program that draws the next roots of an object (raycast.frag with IS_OPERAND), with all
/// uniforms set and all textures bound but those of roots (unit 5) and of what waits (unit 6).
using OperandProgram = std::function<const gl::Program&(const FrameContext& object, int number)>;
/// Those of them that are the same for any rays.
void set_operand_uniforms(const gl::Program& program, const FrameContext& frame, int number);
struct CompositionWork {
    int rounds = 0;
    int searches = 0;
};
/// Into `hit` what one ray of each pixel meets first: run_composition for any rays. A ray that
/// starts inside meets the place where it leaves.
CompositionWork compose_roots(FrameContext& frame, const gl::Texture& hit,
                              const OperandProgram& operand);

/// Every program of it but the objects' (field_programs).
std::vector<gl::ProgramKey> composition_programs();

} // namespace isocast
