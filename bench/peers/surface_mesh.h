// Triangles of a field's zero set, made by another library.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "volume/sparse_field.h"

#include <array>
#include <cstdint>

namespace isocast {

struct SurfaceMesh {
    std::vector<Eigen::Vector3f> points_world;
    std::vector<Eigen::Vector3f> normals; // one a point, of any length
    std::vector<std::array<std::uint32_t, 3>> triangles;
    double extraction_seconds; // without copies to or from the library's own types
    std::string extractor;
};

/// The library is VTK where it is installed, OpenVDB elsewhere; on as many threads as TBB may use.
SurfaceMesh extract_surface(const SparseField& field);

} // namespace isocast
