// What is drawn: a field, how finely rays search it, and how it looks.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "raycaster/brick_pool.h"
#include "raycaster/camera.h"
#include "raycaster/look.h"
#include "volume/field_source.h"

#include <memory>
#include <optional>
#include <string_view>

namespace isocast {

/// How rays find the blocks to search, in order; the picture is the same (thesis sections 6.3.1,
/// 6.3.2; docs/raycasting.md compares them).
enum class Traversal {
    TileLists,     // the CPU lists for each 4^2 pixels the blocks that they see
    DrawnBlocks,   // the GL draws the back faces of all blocks, the nearest first
    BoundingFaces, // block by block between the first and the last face around active blocks
    Walk,          // of the table, with jumps over empty space
};

/// "lists", "drawn", "bounds" or "walk".
/// throws  InputError that lists these
Traversal traversal_from_name(std::string_view name);

/// How rays search.
struct Quality {
    Traversal traversal = Traversal::TileLists;
    double guarantee_voxels = 0.01; // the longest stretch inside the object that a ray may miss
    /// Instead of certified steps, samples at this rate r0 [1/voxel] (thesis section 6.3.3), and
    /// at rate_factor times it where the value is nearer to iso than near_voxels [of slope one].
    std::optional<double> rate;
    int rate_factor = 1;
    double near_voxels = 1;
};

struct Scene {
    std::shared_ptr<const FieldSource> field;
    double iso_world = 0;
    Filter filter = Filter::Interpolating;
    /// Gradients by another filter than values (thesis section 6.4.4); by the same if empty.
    std::optional<Filter> derivative_filter;
    /// Curvatures and their directions, and what is made of these, are those of the field smoothed
    /// by a Gaussian of so many voxels (filtering/smoothed_field.h), at the same hits: neither the
    /// surface nor its normals move. At most greatest_scale_voxels.
    double curvature_scale_voxels = 0;
    StorageOptions storage;
    Quality quality;
    Look look;
};

} // namespace isocast
