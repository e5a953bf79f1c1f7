// A triangle in its own orthonormal frame, ready for many distance queries.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/mesh.h"
#include "distance_transform/point_triangle.h"
#include "distance_transform/triangle_frame_data.h"

namespace isocast {

/// Degenerate triangles become their longest side, or a point.
TriangleFrame triangle_frame(const std::array<Vec3d, 3>& corners);

/// Of all triangles of `mesh`.
std::vector<TriangleFrame> triangle_frames(const Mesh& mesh);

struct LocalClosest {
    Vec3d offset; // of the point from the closest one of the triangle
    Feature feature;
};

/// The closest feature to `p`, by the arithmetic of the block kernels.
LocalClosest closest_feature(const TriangleFrame& frame, const Vec3d& p);

} // namespace isocast
