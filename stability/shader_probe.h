// GLSL functions, called for numbers of one's own.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "stability/devices.h"

#include <vector>

namespace isocast::stability {

/// principal_curvatures() and principal_direction() of shaders/filtering.
///
/// derivatives  of each point four: the gradient and the columns of the Hessian
/// returns      of each three: (k1, k2), the direction of k1, that of k2
std::vector<Eigen::Vector4f> run_curvature_probe(Device& device,
                                                 const std::vector<Eigen::Vector4f>& derivatives);

/// All programs that these run.
std::vector<gl::ProgramKey> probe_programs();

} // namespace isocast::stability
