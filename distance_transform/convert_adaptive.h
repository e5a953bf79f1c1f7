// From mesh to adaptive distance field.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "distance_transform/adaptive.h"
#include "distance_transform/convert.h"

namespace isocast {

struct AdaptiveConvertOptions {
    /// What the field may err by near the surface [world]; empty divides every cell that holds a
    /// part of the surface down to the finest.
    std::optional<double> max_error_world;
    /// Edge of the finest cells; empty takes the largest that cannot err by more than
    /// max_error_world, by Lipschitz's bound: 2/sqrt(3) of it.
    std::optional<double> voxel_size_world;
    /// How far from the surface the error is kept [world]; see AdaptiveOptions.
    double accurate_within_world = 0;
    OctreeFilter filter = OctreeFilter::Linear;
    SignMethod sign = SignMethod::Auto;
    double memory_bytes = std::numeric_limits<double>::infinity();
};

struct AdaptiveConvertResult {
    HashedOctree tree;
    /// Of the tree's index space. Finest cells lie between samples of convert()'s lattice.
    GridSpace space;
    SignMethod sign_used;
    std::string sign_reason;
    double prepare_seconds = 0;
    double transform_seconds = 0;
    std::vector<std::string> warnings = {};
};

/// An octree around the mesh, on all cores of the current TBB arena.
///
/// accuracy  exact distances in double, rounded once to float, at nodes that do not hang
/// throws    InputError for unusable options, or a mesh without inside; ResourceError if the tree
///           would be deeper than greatest_octree_depth, or take more memory than allowed
AdaptiveConvertResult convert_adaptive(const CheckedMesh& input,
                                       const AdaptiveConvertOptions& options,
                                       const Progress& progress = {});

} // namespace isocast
