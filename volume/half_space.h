// A half space as a field, for planes that cut others.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "volume/field_source.h"

#include <Eigen/Geometry>

#include <memory>

namespace isocast {

/// What lies in front of planes with one normal, in a box.
struct HalfSpaces {
    /// -(n . (p - centre)), n of unit length: the signed distance to the plane through the centre.
    /// Linear, so that B-spline filtering of its samples as they are, and of its derivatives, gives
    /// it back to float's rounding, all over the box.
    std::shared_ptr<const FieldSource> field;
    Vec3d centre_world = Vec3d::Zero();
    Vec3d normal = Vec3d::UnitZ();

    /// The iso value of the half space n . p > offset.
    double iso_of(double offset_world) const { return normal.dot(centre_world) - offset_world; }
};

/// normal     of any length but 0
/// box_world  not empty; along its longest side lie 64 cells, so that a root that is found to 1e-5
///            of a cell is found to 2e-7 of the box
HalfSpaces half_spaces(const Vec3d& normal, const Eigen::AlignedBox3d& box_world);

} // namespace isocast
