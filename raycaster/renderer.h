// From scene and camera to images.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "gl/context.h"
#include "gl/program.h"
#include "raycaster/image.h"
#include "raycaster/passes.h"

namespace isocast {

/// What one pass of a frame cost, or that it did not run.
struct PassReport {
    std::string name;
    bool ran = false;
    std::string asked_by;           // passes that read its image, "output" if it was requested
    double milliseconds = 0;        // of the last frame
    std::int64_t texture_bytes = 0; // of the image it writes
};

/// What a frame cost.
struct FrameReport {
    std::vector<PassReport> passes; // all declared ones, in order
    int programs_compiled = 0;      // since the renderer was made
    std::int64_t image_bytes = 0;   // textures of frame images
    std::int64_t field_bytes = 0;   // atlas, reference texture and bounding geometry
};

/// Draws one scene with one context.
class Renderer {
public:
    /// shader_folder  the project's shaders/
    Renderer(gl::Context& context, const std::filesystem::path& shader_folder);
    Renderer(const Renderer&) = delete; // the bricks on the GPU refer to the ranges here
    Renderer& operator=(const Renderer&) = delete;

    /// Finds the active blocks and uploads their bricks.
    /// throws  InputError if the scene has no field; ResourceError if it does not fit
    void load(Scene scene, const Progress& progress = {});

    /// Corners of the box of the isosurface [world]; of the field's extent where there is none.
    std::array<Vec3d, 8> surface_box_world() const;
    /// False if the field never crosses the iso value.
    bool has_surface() const { return !surface_box_.is_empty(); }
    const BrickPool& pool() const { return field_.pool(); }
    /// What was coarsened to fit the budget, if anything was.
    const std::optional<CoarseBricks>& coarse_bricks() const { return coarse_; }

    /// Runs the passes that `wanted` needs.
    /// throws  InputError for a size below 1 or above what the GL offers
    FrameReport draw(const Camera& camera, int width, int height, const ImageSet& wanted);

    /// An image of the last frame, which it must have wanted or needed.
    Image read(FrameImage image) const;

private:
    gl::Context& context_;
    gl::ShaderLibrary shaders_;
    gl::VertexArray no_vertices_;
    Scene scene_;
    std::shared_ptr<const FieldSource> control_;
    BlockRanges ranges_;
    std::vector<ActivePage> active_;
    std::optional<CoarseBricks> coarse_;
    FieldOnGpu field_;
    IndexBox surface_box_;
    FrameTargets targets_;
};

} // namespace isocast
