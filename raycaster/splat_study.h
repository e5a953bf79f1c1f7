// Earlier ways to draw splats, and what they cost: for benchmarks.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "gl/program.h"
#include "quadrics/splats.h"

#include <cstdint>

namespace isocast {

struct FrameContext;

struct SplatStudy {
    BoundingShape shape = BoundingShape::Rectangle;
    /// Of Sigg et al. 2006, in floats, with the near and the far plane right around all spheres, or
    /// the near one at 1/1000 of the far one.
    bool meets_spheres_by_equation_7 = false;
    bool counts_fragments = false;
};

/// Of the splats of a frame, however they hide each other.
struct SplatFragments {
    std::int64_t rasterised;
    std::int64_t hit;
};
SplatFragments count_fragments(const FrameContext& frame);

/// Of shaders/quadrics/equation_7.glsl.
void set_equation_7(const gl::Program& program, const FrameContext& frame);

/// Every program that a study can ask for, beside those with SplatStudy's defaults.
std::vector<gl::ProgramKey> splat_study_programs();

} // namespace isocast
