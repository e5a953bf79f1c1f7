// Points that are spread evenly over a triangle mesh: where glyphs stand.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "volume/grid_space.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace isocast {

/// A point of a mesh; what vertices have is interpolated by `barycentric`.
struct SurfacePoint {
    Vec3d position_world = Vec3d::Zero(); // the vertices' sum, weighted by `barycentric`
    int triangle = 0;
    Vec3d barycentric = Vec3d::Zero(); // of the triangle's corners, >= 0, sum 1
};

/// Points without large gaps or close pairs, as many in each part as its share of the area.
///
/// Distances are straight, so that two sheets closer than the spacing share their points; along the
/// border of an open mesh there is no neighbour on the other side, and points lie denser there
/// (Scatter.BordersOfOpenMeshesAreDenser says how much).
///
/// vertices_world  finite
/// triangles       indices of vertices
/// count           below 2^29; 6500 take a tenth of a second, 5e5 ten: n log n with n = 5 count
/// seed            the same points for the same seed, on every machine
/// returns         `count` points by ascending triangle, none on triangles without an area; nothing
///                 if no triangle has one
/// accuracy        the closest pair is at least 0.65 of the greatest possible distance
///                 2 sqrt(area / (2 sqrt(3) count)) apart, that of a hexagonal lattice:
///                 Scatter.PointsKeepTheirDistance
/// source          Yuksel 2015, "Sample Elimination for Generating Poisson Disk Sample Sets", with
///                 weight limits, as in its author's cySampleElim.h: alpha, beta, gamma and the
///                 greatest radius; five candidates for each point
std::vector<SurfacePoint> scatter(std::span<const Vec3d> vertices_world,
                                  std::span<const Eigen::Vector3i> triangles, std::size_t count,
                                  std::uint64_t seed);

} // namespace isocast
