// Built-in fields with exact value, gradient and Hessian: samples with no data at hand, and the
// truth that tests compare with.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "volume/field_source.h"

#include <functional>
#include <memory>
#include <string>
#include <string_view>

namespace isocast {

/// A field's value and its first two derivatives at one point, in one space.
struct Jet {
    double value = 0;
    Vec3d gradient = Vec3d::Zero();
    Mat3d hessian = Mat3d::Zero();
};

/// A scalar function of world space, negative inside.
struct AnalyticField {
    std::string name;
    std::function<Jet(const Vec3d& p_world)> jet;
    /// The cube [-half_extent, half_extent]^3 holds what is worth seeing.
    double half_extent_world = 1;
};

// The distances below have no derivative at some points (a centre, an axis, the circle within a
// torus); there gradient and Hessian are zero.

AnalyticField sphere_field(const Vec3d& centre_world, double radius_world);
/// Exact distance to a torus about `axis` (any length) through `centre_world`; the minor radius is
/// the smaller one.
AnalyticField torus_field(const Vec3d& centre_world, const Vec3d& axis, double major_radius_world,
                          double minor_radius_world);
/// Exact distance to an infinite cylinder.
AnalyticField cylinder_field(const Vec3d& point_world, const Vec3d& axis, double radius_world);

/// The names that `builtin_field` knows: sphere, torus, cylinder, gyroid, saddle, marschner-lobb,
/// cube.
std::vector<std::string> builtin_field_names();

/// A built-in field by name; its iso value is 0 (Marschner-Lobb's 0.5 is subtracted).
///
/// sphere, torus,  distances: radius 1 in [-1.5, 1.5]^3; radii 1 and 0.4 about z in
///   cylinder      [-1.75, 1.75]^3; radius 0.5 about z in [-1, 1]^3
/// gyroid          (sin kx cos ky + sin ky cos kz + sin kz cos kx)/k, k = 2 pi: two periods in
///                 [-1, 1]^3
/// saddle          z - (x^2 - y^2)/2 in [-1, 1]^3: principal curvatures ± 1 at the origin
/// marschner-lobb  the test signal less 0.5 in [-1, 1]^3, f_M = 6 and alpha = 0.25; it falls
///                 along z, so the inside is the side of large z
/// cube            the rounded cube x^4 + y^4 + z^4 - x^2 - y^2 - z^2 in [-1.5, 1.5]^3; it also is
///                 zero at the origin, an isolated point
/// throws  InputError that lists the known names
/// source  Marschner & Lobb 1994; the cube is the function that Kindlmann et al. 2003 sampled for
///         their figure 1, by the comment in fs3d-scl.diderot of Diderot's examples, there negated
AnalyticField builtin_field(std::string_view name);

/// The field less `iso_world`: its surface there is at 0.
AnalyticField at_iso(AnalyticField field, double iso_world);

/// A field source that evaluates `field` at `samples_per_axis`^3 points of its cube, the first and
/// the last on the cube's faces. Samples are computed when they are asked for, never stored. Beyond
/// the cube the samples at its border continue; with a band all is outside there.
///
/// half_width_voxels  clamps values to ± that many voxels, if given (a narrow band, for tests)
/// throws             InputError unless 4 <= samples_per_axis <= 4096
std::unique_ptr<FieldSource> sampled(AnalyticField field, int samples_per_axis,
                                     std::optional<double> half_width_voxels = std::nullopt);

} // namespace isocast
