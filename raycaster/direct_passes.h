// Primitives shaded where they are drawn, as the thesis's table 7.3 compares it: no hits are kept.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "raycaster/frame.h"

namespace isocast {

/// throws  InputError that names all that direct shading cannot draw of the look, of fields and of
///         SLIM surfaces
void check_direct(const Look& look, bool has_fields, bool has_slims);

ImageSet direct_reads(const FrameContext& frame);
/// FrameImage::Beauty, of primitives alone: what run_shading() makes of hits, in each fragment.
void run_direct(FrameContext& frame);

std::vector<gl::ProgramKey> direct_programs();

} // namespace isocast
