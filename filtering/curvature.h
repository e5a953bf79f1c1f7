// Curvatures at a point of a field, from the derivatives there.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "volume/grid_space.h"

namespace isocast {

/// Principal curvatures, k1 >= k2, and their directions; all of one space.
struct Curvatures {
    double k1 = 0; // [1/length]; a sphere of radius r whose inside is negative has k1 = k2 = 1/r
    double k2 = 0;
    Vec3d direction1 = Vec3d::Zero(); // unit tangents; at an umbilic any two that are orthogonal
    Vec3d direction2 = Vec3d::Zero();
};

/// Zero where the gradient vanishes.
///
/// gradient, hessian  in a space with orthonormal axes, not in index space of voxels that are no
///                    cubes: GridSpace::gradient_to_world, hessian_to_world
/// accuracy           a few roundings of the greatest entry of hessian / |gradient|: the tangent
/// basis
///                    does not cancel for any normal, nor does the root of eq. 6.6 in this form
/// source             thesis eqs 6.5 - 6.8; the direction of 6.8 from the longer of two rows, since
///                    one of them vanishes where the first tangent is principal
/// twin               shaders/filtering/curvature.glsl
Curvatures principal_curvatures(const Vec3d& gradient, const Mat3d& hessian);

/// Normal curvature of the isosurface in the direction of the tangential part of `direction`; zero
/// where that or the gradient vanishes.
///
/// twin  shaders/filtering/curvature.glsl
double normal_curvature(const Vec3d& gradient, const Mat3d& hessian, const Vec3d& direction);

/// Curvature of the line that runs along the gradient, |P H n| / |g| with P the projection to the
/// tangent plane: how fast the normal turns off the surface, which is nothing in a distance field.
/// Zero where the gradient vanishes.
///
/// source  Kindlmann et al. 2003, as teem computes its gageSclFlowlineCurv
/// twin    shaders/filtering/curvature.glsl
double flow_line_curvature(const Vec3d& gradient, const Mat3d& hessian);

} // namespace isocast
