// SPDX-License-Identifier: MPL-2.0
#include "distance_transform/exact_distance.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace isocast {

SurfaceInCube LipschitzDistance::surface_in(const Cube& cube, const CellFunction& g,
                                            double tolerance) const {
    const double radius = std::numbers::sqrt3 * cube.half_edge;
    if (std::abs(at_(cube.centre).distance) > radius) return {};
    const double bound = std::abs(g.at(cube.centre)) + g.bounds().slope * radius;
    if (bound <= tolerance || 2 * cube.half_edge <= finest_)
        return {.is_there = true,
                .bound = bound <= tolerance ? bound : std::numeric_limits<double>::infinity(),
                .box = {cube.lo(), cube.hi()}};
    SurfaceInCube all;
    const double half = cube.half_edge / 2;
    for (int i = 0; i < 8 && std::isfinite(all.bound); ++i) {
        const SurfaceInCube part =
            surface_in({cube.centre + half * corner_direction(i), half}, g, tolerance);
        if (!part.is_there) continue;
        all.is_there = true;
        all.bound = std::max(all.bound, part.bound);
        all.box.extend(part.box);
    }
    return all;
}

} // namespace isocast
