// From a mesh to a SLIM surface.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "quadrics/slim_choice.h"
#include "quadrics/triangles.h"
#include "volume/progress.h"

namespace isocast {

struct SlimOptions {
    double max_error_world = 0;
    double crease_degrees = 40; // faces that turn more may be cut from one another
    int max_levels = 16;        // 1: the finest alone
};

/// Covers a mesh by spheres, each with a patch that keeps the error: centres are taken at random
/// from what is not covered yet, and spheres grow as far as their patch keeps it. Every point of
/// the mesh lies, with a triangle around it, within 0.93 of the radius of a patch whose part of the
/// mesh it belongs to, and by more than the error within its sphere: what is not is halved until it
/// is, and until it is small beside the patches about. The patches of three such covers are chosen
/// from: needed_patches().
///
/// Then come the coarser levels of with_levels(), each a whole cover.
///
/// options  max_error_world above 0
/// reports  of each level
/// returns  bit for bit the same for any number of threads
/// throws   InputError as SlimMesh; Interrupted by `progress`
/// source   Ohtake, Belyaev, Alexa 2005, of points; ours is of the mesh, and proves what it covers
SlimSurface slim_of(const TriangleMesh& mesh, const SlimOptions& options,
                    std::vector<SlimReport>& reports, const Progress& progress = {});

} // namespace isocast
