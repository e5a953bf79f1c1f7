// Fields that ray casters miss, as control samples of a B-spline with unit voxels in [0, n)^3.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "stability/fields.h"

namespace isocast::stability {

/// A sheet whose spline is (s^2 - w^2)/8 near it, w half its thickness.
struct ThinSheet {
    std::shared_ptr<const FieldSource> control;
    Vec3d middle;
    Vec3d normal;
};
ThinSheet thin_sheet(int n, unsigned seed, double thickness_voxels);

/// A spherical shell of radius n/3.
std::shared_ptr<const FieldSource> thin_shell(int n, double thickness_voxels);

/// A tube of 2 to 3 voxels, off the lattice and tilted.
std::shared_ptr<const FieldSource> tilted_torus(int n, unsigned seed);

/// Paraboloids with a radius of 0.3 voxel at their feet, which stand on z = 0.
std::shared_ptr<const FieldSource> needles(int n, unsigned seed);

/// Waves of random directions: necks and islands as thin as chance makes them.
std::shared_ptr<const FieldSource> smooth_noise(int n, unsigned seed);

} // namespace isocast::stability
