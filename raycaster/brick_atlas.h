// The field on the GPU: active bricks packed in one texture, and a reference texture that finds
// them (thesis section 6.2.2, figure 6.4).
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "gl/program.h"
#include "volume/bricks.h"
#include "volume/progress.h"

namespace isocast {

/// Where bricks stand in the atlas.
struct AtlasLayout {
    int bricks_per_row = 0; // along x and along y
    int layers = 0;         // along z
    Index3 texels = Index3::Zero();

    /// The texel of the first sample (apron included) of the n-th brick.
    Index3 first_texel(int n) const;
};

/// The smallest near-cubic layout for `brick_count` bricks. Widths and heights are powers of two,
/// so that the division of texel coordinates by them is exact in float.
/// throws  ResourceError if it would pass `max_extent` texels along an axis
AtlasLayout plan_atlas(int brick_count, int max_extent);

/// A field's active bricks at one iso value, uploaded.
class BrickAtlas {
public:
    BrickAtlas() = default;
    /// Local coordinates are index coordinates minus `local_origin_index`, a brick corner near the
    /// middle of the active bricks, so that float coordinates stay small.
    /// throws  ResourceError if the bricks do not fit in one texture
    BrickAtlas(const FieldSource& field, float iso, const ActiveBlocks& blocks,
               const Progress& progress = {});

    const Index3& local_origin_index() const { return local_origin_index_; }
    int brick_count() const { return brick_count_; }
    std::int64_t byte_count() const { return atlas_.byte_count() + reference_.byte_count(); }

    /// Greatest |difference| of neighbouring samples over the bricks, per axis, combined: a bound
    /// of the spline's gradient [world/voxel] (FORMULAS: convex hull of the differences).
    float greatest_slope() const { return greatest_slope_; }

    /// Binds the textures and sets the uniforms that shaders/raycast/field.glsl declares.
    void bind(const gl::Program& program) const;

private:
    gl::Texture atlas_;
    gl::Texture reference_;
    Eigen::Vector3f atlas_scale_ = Eigen::Vector3f::Zero();
    Index3 local_origin_index_ = Index3::Zero();
    Index3 first_brick_local_ = Index3::Zero();
    IndexBox extent_local_;
    int brick_count_ = 0;
    float greatest_slope_ = 0;
};

} // namespace isocast
