// What is drawn: a field or a solid composed of several, how finely rays search it, and how it
// looks.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "quadrics/cut.h"
#include "raycaster/brick_pool.h"
#include "raycaster/camera.h"
#include "raycaster/csg.h"
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

/// Where primitives are shaded (thesis table 7.3).
enum class SplatShading {
    Deferred, // once a pixel, when all are drawn
    Direct,   // wherever one is drawn: plain Phong with shadows, of primitives alone
};

/// How rays search.
struct Quality {
    Traversal traversal = Traversal::TileLists;
    double guarantee_voxels = 0.01; // the longest stretch inside the object that a ray may miss
    /// Instead of certified steps, samples at this rate r0 [1/voxel] (thesis section 6.3.3), and
    /// at rate_factor times it where the value is nearer to iso than near_voxels [of slope one].
    std::optional<double> rate;
    int rate_factor = 1;
    double near_voxels = 1;
    int refine_steps = 12; // with `rate`: of the root between two samples, at most
    /// Of primitives, as in SplatView, for the viewer alone: lights and reflections see all.
    double detail_pixels = 0;
    SplatShading splats = SplatShading::Deferred;
};

/// A field and its isosurface. Fields of a scene may differ in grid, spacing, orientation and
/// filter.
struct FieldObject {
    std::shared_ptr<const FieldSource> field;
    double iso_world = 0;
    Filter filter = Filter::Interpolating;
    /// Gradients by another filter than values (thesis section 6.4.4); by the same if empty.
    std::optional<Filter> derivative_filter;
    /// The material's if empty.
    std::optional<Vec3d> colour = {};
    /// Where this object is taken away from others; `colour` if empty.
    std::optional<Vec3d> cut_colour = {};

    bool operator==(const FieldObject&) const = default;
};

/// `field` and what follows it are the one object of a scene without `objects`.
struct Scene {
    std::shared_ptr<const FieldSource> field;
    double iso_world = 0;
    Filter filter = Filter::Interpolating;
    std::optional<Filter> derivative_filter;
    /// Curvatures and their directions, and what is made of these, are those of the field smoothed
    /// by a Gaussian of so many voxels (filtering/smoothed_field.h), at the same hits: neither the
    /// surface nor its normals move. At most greatest_scale_voxels.
    double curvature_scale_voxels = 0;
    StorageOptions storage; // the budget is that of all objects
    Quality quality;
    Look look;
    /// Instead of `field`: max_object_count at most. Rays search each by certified steps through
    /// lists of blocks, whose bricks all fit; composed roots are roots of objects, so that what a
    /// ray may miss is a stretch inside an object, or outside it, that is shorter than the
    /// guarantee in that object's voxels, or one between roots of two objects that lie no farther
    /// apart than 1e-5 of a voxel of each and rounding. Beyond the extent of a field without a band
    /// a ray stays on the side on which it enters or leaves the extent, and is outside if it misses
    /// the extent.
    std::vector<FieldObject> objects = {};
    CsgTree tree = {}; // of `objects`; empty: their union
    /// Drawn beside what the tree says of the fields, or alone. With fields, all bricks must fit.
    std::shared_ptr<const Primitives> primitives = {};
    Cut cut = {}; // of the primitives
};

/// The objects; none in a scene of primitives alone.
/// throws  InputError if there is nothing at all, or both `field` and `objects`, or too many, or
/// one without
///         a field, or a tree that is wrong
std::vector<FieldObject> objects_of(const Scene& scene);
/// The tree of the objects.
CsgTree tree_of(const Scene& scene);
/// Whether it takes more than the first hit with one object.
inline bool is_composed(const Scene& scene) {
    return scene.objects.size() > 1 || scene.tree.size() > 1;
}

} // namespace isocast
