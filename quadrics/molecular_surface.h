// The surfaces of a molecule as distance fields: van der Waals, solvent-accessible,
// solvent-excluded.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "quadrics/primitives.h"
#include "volume/progress.h"
#include "volume/sparse_field.h"

#include <limits>
#include <span>

namespace isocast {

enum class MolecularSurface {
    VanDerWaals, // of the union of the atoms' spheres
    Accessible,  // where the centre of a probe that touches atoms can be: radii grow by its radius
    Excluded,    // of what no probe reaches that keeps out of the atoms
};

/// World units are angstrom where atoms are in angstrom.
struct MolecularSurfaceOptions {
    MolecularSurface kind = MolecularSurface::Excluded;
    double probe_radius_world = 1.4;
    double voxel_size_world = 0.5;
    double half_width_voxels = 3; // >= 1
    /// What the field's blocks may take; infinity stands for what the system says is available.
    double memory_bytes = std::numeric_limits<double>::infinity();

    bool operator==(const MolecularSurfaceOptions&) const = default;
};

/// Signed distance to a surface of `atoms` at every sample with |d| <= half width, on all cores of
/// the current TBB arena. Samples lie at integer multiples of the voxel size; where that index
/// would pass 2^28 the transform is shifted by whole voxels.
///
/// A probe may be wherever it keeps out of all atoms, in closed cavities too: these get surfaces of
/// their own. Let A be the set of its possible centres, the complement of the union U of the open
/// balls of radius r + p. The accessible surface is A's boundary, and the solid that the excluded
/// surface bounds is E = { x : dist(x, A) >= p }.
///
/// - Within E, dist(x, A) - p is the distance: E's complement is A grown by p.
/// - In A, p + dist(x, U) is: from the nearest ball's sphere, p further to its centre is a point of
///   E.
/// - Between, where 0 < dist(x, A) < p, p - dist(x, A) is, if y = a + p (x - a)/|x - a| is in E,
///   with the nearest a of A. So it always is where a is within a face of the accessible surface.
///   Else two probes or more meet near x in a cusp and the distance is greater: the cusp is found
///   (ProbeCuts).
///
/// returns   blocks that hold the whole band, and only blocks that hold a part of it
/// accuracy  exact distances in double, rounded once to float, for radii that differ from those
///           given by up to 2^-42 of the molecule's extent: by so little may spheres miss a common
///           point. Outside by cusps: a lower bound, where the nearest point is at most 1e-8 probe
///           radii within a probe
/// source    the distances are our own derivation, above; the surfaces are known by Lee & Richards
///           (accessible) and Connolly (excluded)
/// throws    InputError for no atoms, spheres that check() refuses and unusable options,
///           ResourceError if the blocks would not fit in memory
SparseField molecular_surface(std::span<const Sphere> atoms,
                              const MolecularSurfaceOptions& options = {},
                              const Progress& progress = {});

} // namespace isocast
