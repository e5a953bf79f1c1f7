// Measures the front from which `--max-error` chooses.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "apps/accuracy/promise.h"
#include "apps/accuracy/study.h"

namespace isocast {

/// Draws built-in fields and meshes by each filter at several resolutions: how the greatest error
/// of a picture compares with the probe's, and the median over inputs of what it takes.
Front calibrated(const StudyOptions& options, gl::Context& context, Renderer& renderer, int rounds,
                 const Progress& progress);

} // namespace isocast
