// Points that are spread evenly over an isosurface, with its curvatures there: where glyphs stand.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "quadrics/tensor_glyphs.h"
#include "raycaster/scene.h"
#include "volume/progress.h"

#include <cstdint>

namespace isocast {

struct CurvedPoints {
    std::vector<CurvedPoint> points;
    double spacing_world = 0; // of as many points in a hexagonal lattice
    std::size_t lost = 0;     // points from which Newton's steps did not lead to the surface
};

/// count of scatter() on isosurface_mesh(), then moved along the gradient to the isosurface of the
/// function that rays meet: that of object.filter. Normals and curvatures are those of pictures: of
/// the derivative filter, curvatures of the samples smoothed by curvature_scale_voxels.
///
/// accuracy  points within 1e-4 voxels of the isosurface, others are lost; as even as scatter()'s,
///           but for what a voxel's move does
/// throws    InputError if the field has no surface at object.iso_world
CurvedPoints curved_points(const FieldObject& object, std::size_t count, std::uint64_t seed,
                           double curvature_scale_voxels, const Progress& progress = {});

} // namespace isocast
