// Skin surfaces of spheres as quadrics in tetrahedra, by CGAL: programs that link this are under
// the GPL.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "quadrics/primitives.h"

namespace isocast {

/// The envelope of all spheres between the given ones, shrunk: pieces of spheres and hyperboloids
/// that meet with one tangent plane, one in each tetrahedron of a mixed complex.
///
/// spheres  a single one keeps its radius: they are grown before they shrink
/// shrink   between 0 and 1; of radii, squared: near 1 the spheres with short necks, near 0 the
///          hull of them
/// returns  closed; the same floats on both sides of a face
/// throws   InputError for no spheres, or a shrink factor that is not between 0 and 1
/// source   Edelsbrunner, Deformable Smooth Surface Design, 1999; CGAL 5.5, Skin_surface_3
/// (Kruithof
///          and Vegter 2007), whose triangulated mixed complex this takes
TetrahedralMesh skin_surface(std::span<const Sphere> spheres, double shrink = 0.5);

} // namespace isocast
