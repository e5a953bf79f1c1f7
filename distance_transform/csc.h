// Characteristics/Scan-Conversion: towers, wedges and cones, one per face, edge and vertex (4.2.2).
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/lattice.h"
#include "distance_transform/reference_band.h"
#include "volume/progress.h"

namespace isocast {

/// Least distance at each sample to the sites (planes, lines, points) whose polyhedra hold it: the
/// reference method, on one thread and simple.
///
/// Signs: at a face its side; at an edge outside if it is convex; at a vertex its pseudonormal, for
/// the sign by convexity that Mauch's method takes is wrong at some of them.
/// memory_bytes  what the distances and the blocks made of them may take
/// throws    InputError as one_rings(), or if the mesh is not closed; ResourceError beyond
///           memory_bytes
/// source    Mauch 2003, by Sigg 2006, section 4.2.2. At saddles the pyramid on each side is the
///           convex hull of the faces' normals, as proposed there; where a face is turned away from
///           the mean normal, which it excludes as poor triangulation, the ball's box is scanned.
ReferenceBand characteristics_scan_conversion(const LatticeMesh& lattice, double half_width_voxels,
                                              double memory_bytes, const Progress& progress = {});

} // namespace isocast
