// Ellipsoids that show how a surface is curved, seated on it.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "quadrics/primitives.h"

#include <optional>
#include <span>
#include <vector>

namespace isocast {

/// The curvature of a surface at one of its points, as of principal_curvatures().
struct CurvedPoint {
    Vec3d position_world = Vec3d::Zero();
    Vec3d normal = Vec3d::UnitZ(); // unit, outwards
    double k1 = 0;                 // [1/world]; positive where the surface falls off the normal
    double k2 = 0;
    Vec3d direction1 = Vec3d::UnitX(); // of k1; any where k1 = k2, zero too
};

struct CurvatureGlyphLook {
    double size_world = 1; // the greatest semi-axis: half the spacing, and they do not overlap
    /// |k| of which a semi-axis is as long as size_world, as of all that are less;
    /// typical_curvature() if not given.
    std::optional<double> curvature_of_size;
    double least_share = 0.2;      // of size_world: the least tangential semi-axis
    double thickness_share = 0.25; // of the lesser tangential semi-axis: the one along the normal
};

/// A flat ellipsoid at each point, whose outline is Dupin's indicatrix: what a plane below the
/// tangent plane cuts from the surface, by |k|.
///
/// The semi-axis along a principal direction is size sqrt(curvature_of_size / |k|), from
/// least_share size to size: on a cylinder long along its axis, on a sphere a disc, on a plane a
/// disc as large as any. So it tells directions as soon as |k1| and |k2| differ, k1 from -k2 not at
/// all.
///
/// Its centre is the point, lifted along the normal by as much as the surface rises at the
/// ellipsoid's ends where it is hollow, |k| a^2 / 2 but not more than a, so that none is buried.
///
/// Colours say the direction of the greater |k|: red, green and blue are its absolute components
/// along x, y and z, the greatest of them 1; grey by as much as |k1| and |k2| are the same.
///
/// points   finite but for curvatures, which may be infinite (an apex)
/// returns  in their order
/// source   Toledo and Levy 2004, figures 1 and 9: 5000 and 6500 ellipsoids of the curvature
/// tensor,
///          whose "color represents the maximum curvature direction"; the lengths are ours, since
///          their captions say none
std::vector<Ellipsoid> curvature_ellipsoids(std::span<const CurvedPoint> points,
                                            const CurvatureGlyphLook& look = {});

/// The lower quartile of all |k1| and |k2| but those that are 0: then a quarter of all semi-axes
/// are as long as may be. 1 if all are 0.
double typical_curvature(std::span<const CurvedPoint> points);

} // namespace isocast
