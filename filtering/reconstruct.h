// From samples to the smooth function, its gradient and Hessian, in double: the CPU twin of the
// shaders and the truth that they are tested against.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "filtering/bspline.h"
#include "volume/analytic_fields.h"
#include "volume/field_source.h"

namespace isocast {

/// Value of the tricubic B-spline whose control samples are `field`'s samples.
///
/// p_index  samples at integers
/// returns  [world]; the spline smooths: it does not pass through the samples
/// source   thesis eq. 5.1 per axis
/// twin     shaders/filtering/tricubic.glsl: tricubic_value()
double tricubic_value(const FieldSource& field, const Vec3d& p_index);

/// Value [world], gradient [world/voxel] and Hessian [world/voxel^2] in index space.
/// source  thesis section 5.3
/// twin    shaders/filtering/tricubic.glsl: tricubic_gradient()
Jet tricubic_jet(const FieldSource& field, const Vec3d& p_index);

/// The same with any kernel. Where a derivative jumps from cell to cell (the first of Linear, the
/// second of Catmull-Rom) it is that of the cell above.
double kernel_value(const FieldSource& field, const Vec3d& p_index, Kernel kernel);
Jet kernel_jet(const FieldSource& field, const Vec3d& p_index, Kernel kernel);

} // namespace isocast
