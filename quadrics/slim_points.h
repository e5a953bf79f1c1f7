// From points to a SLIM surface.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "quadrics/slim_choice.h"
#include "volume/progress.h"

#include <span>

namespace isocast {

/// Samples of a surface, all of one length.
struct SlimPoints {
    std::span<const Vec3d> points_world;
    std::span<const Vec3d> normals;        // outwards, unit
    std::span<const double> spacing_world; // the edge of a square that each stands for
};

/// Covers points by spheres with patches, as slim_of() covers a mesh: heights over the points that
/// face a patch's way are no greater than the error. Each point lies, with a disc of its spacing
/// around it, within 0.93 of a patch's radius and, by more than the error, within its sphere.
///
/// A sphere holds if its points fill it: of a grid over it no cell of three spacings that lies in
/// it as a whole is empty. So patches pass creases and borders, at which nothing clips them (the
/// points do not say where these run), by the diagonals of two cells at most, 8.5 spacings. The
/// least radius is 2.5 spacings; there a patch may be off by more, and is counted.
///
/// max_error_world  above 0; above the noise of the points
/// returns          open: nobody knows whether points close a surface; bit for bit the same for any
///                  number of threads
/// throws           InputError if there are fewer than 12 points; Interrupted by `progress`
/// source           Ohtake, Belyaev, Alexa 2005, as Stoll et al. 2006 section 5.1.1 describes it;
///                  least squares weighted by the square of the spacing alone: a weight that falls
///                  towards the sphere leaves points there off, and half as many patches again as
///                  the horse's are needed
SlimSurface slim_of_points(const SlimPoints& points, double max_error_world,
                           std::vector<SlimReport>& reports, const Progress& progress = {});

} // namespace isocast
