// Fields that ray casters miss: control samples of a B-spline with parts thinner than a voxel.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "stability/fields.h"

#include <string>
#include <vector>

namespace isocast::stability {

/// Control samples with unit voxels in [0, n)^3, sample i at world i; negative inside.
struct HardField {
    std::string name;
    std::shared_ptr<const DenseField> control;
    /// Thickness of the thinnest part, across it [voxel].
    double thickness_voxels;
};

/// A sheet through the middle, its normal at random, whose spline is (s^2 - w^2)/8 near it for the
/// distance s from its middle: negative for |s| < w = thickness/2. Its values there reach -w^2/8
/// only, 1.25e-5 for the default thickness, where control samples of 2 round to 1e-7.
struct ThinSheet {
    HardField field;
    Vec3d p_on_sheet;
    Vec3d normal;
};
ThinSheet thin_sheet(int n, unsigned seed, double thickness_voxels = 0.02);

/// A spherical shell of radius about n/3: the spline through the samples of (s^2 - w^2)/8.
struct ThinShell {
    HardField field;
    Vec3d centre;
    double radius;
};
ThinShell thin_shell(int n, unsigned seed, double thickness_voxels = 0.1);

/// A torus with a thin tube, off the lattice and tilted: control samples are its distances.
HardField tilted_torus(int n, unsigned seed);

/// Needles that stand on the plane z = 0, tilted at random, and end in points: paraboloids
/// rho^2 = radius^2 (1 - h) for the distance rho from the axis and the height h, 1 at the tip.
/// Where two needles come within 7 voxels of each other the spline smooths over the minimum of
/// both, and they are up to twice as wide.
HardField needles(int n, unsigned seed, int count = 24, double radius_voxels = 0.3);

/// Waves of random directions, 10 voxels long and more: surfaces everywhere, of all curvatures,
/// with necks and islands as thin as chance makes them.
HardField smooth_noise(int n, unsigned seed, int waves = 24);

/// One of each.
std::vector<HardField> hard_fields(int n, unsigned seed);

} // namespace isocast::stability
