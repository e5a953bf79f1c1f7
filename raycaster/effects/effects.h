// The passes of effects, each of which draws one image of the frame, and their programs.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "raycaster/frame.h"

namespace isocast {

void run_contours(FrameContext& frame);
void run_ridges(FrameContext& frame);
void run_uncertainty(FrameContext& frame);
/// Normals and depths in the form that outlines are found in.
void run_outline_source(FrameContext& frame);
void run_outlines(FrameContext& frame);

std::vector<gl::ProgramKey> contours_programs();
std::vector<gl::ProgramKey> ridges_programs();
std::vector<gl::ProgramKey> uncertainty_programs();
std::vector<gl::ProgramKey> outlines_programs();

} // namespace isocast
