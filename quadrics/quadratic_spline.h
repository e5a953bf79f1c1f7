// Isosurfaces of fields as quadrics: a quadratic spline over tetrahedra of their lattice.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "quadrics/tetrahedra.h"
#include "volume/field_source.h"
#include "volume/progress.h"

namespace isocast {

/// Where a quadratic spline of the samples is `iso`, within the field's extent: each cell of the
/// lattice is 24 tetrahedra of its middle, the middle of a face and an edge of that face.
///
/// A tetrahedron's coefficient at a corner is the value there, the sample itself or, in middles,
/// the mean of those around less their bending; that of an edge is the mean of the tangent planes
/// at its two ends, half way along it. Quadratic functions are given back exactly. Neighbours have
/// the same values in their common face; their gradients differ as the tangents do, by O(h^2).
///
/// returns  only the tetrahedra that the surface may cross
/// accuracy third order in the cell's size (QuadraticSpline.ConvergesAtThirdOrder)
/// source   the partition: Roessl, Zeilfelder, Nuernberger, Seidel 2004. The coefficients are our
/// own:
///          theirs make the spline smooth across most faces, but do not interpolate samples
/// throws   Interrupted, when `progress` asks for it
TetrahedralMesh quadratic_spline(const FieldSource& field, double iso_world,
                                 const Progress& progress = {});

} // namespace isocast
