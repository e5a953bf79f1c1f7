// From scene and camera to images.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "filtering/active_set.h"
#include "gl/context.h"
#include "gl/program.h"
#include "raycaster/frame.h"
#include "raycaster/image.h"

namespace isocast {

/// What one pass of a frame cost, or that it did not run.
struct PassReport {
    std::string name;
    bool ran = false;
    std::string asked_by;           // passes that read its image, "output" if it was requested
    std::string drawn_by;           // another pass that writes its image on the way
    double milliseconds = 0;        // of the last frame
    std::int64_t texture_bytes = 0; // of the image it writes
};

/// What a frame cost.
struct FrameReport {
    std::vector<PassReport> passes; // all declared ones, in order
    int programs_compiled = 0;      // since the renderer was made
    std::int64_t image_bytes = 0;   // textures of frame images
    std::int64_t field_bytes = 0;   // atlas, reference texture and bounding geometry
    std::int64_t look_bytes = 0;    // environments, colour maps, noise
    std::vector<std::string> notes; // what was chosen for the user, like a colour map's range
};

/// Draws one scene with one context.
class Renderer {
public:
    /// shader_folder  the project's shaders/
    Renderer(gl::Context& context, const std::filesystem::path& shader_folder);
    Renderer(const Renderer&) = delete; // the bricks on the GPU refer to the ranges here
    Renderer& operator=(const Renderer&) = delete;

    /// Finds the active blocks and uploads their bricks.
    /// throws  InputError if the scene has no field, or Catmull-Rom's filter for linear fetches;
    ///         ResourceError if it does not fit
    void load(Scene scene, const Progress& progress = {});

    /// Moves the isosurface of the loaded scene: pictures are, bit by bit, those of the same scene
    /// loaded at `iso_world`. The control samples and the ranges stay. All bricks are cut anew,
    /// since samples are stored as f - iso: near the surface, where these are small, that keeps
    /// the digits that sums of f would lose.
    /// throws  as load
    void set_iso(double iso_world);

    /// Changes how hits are shaded; the field stays.
    /// throws  InputError if the look asks for what there is not
    void set_look(Look look);
    const Look& look() const { return scene_.look; }

    /// Corners of the box of the isosurface [world]; of the field's extent where there is none.
    /// Found when it is first asked for.
    std::array<Vec3d, 8> surface_box_world() const;
    /// False if the field never crosses the iso value.
    bool has_surface() const { return !surface_box().is_empty(); }
    const BrickPool& pool() const { return field_.pool(); }
    /// What was coarsened to fit the budget, if anything was.
    const std::optional<CoarseBricks>& coarse_bricks() const { return coarse_; }

    /// Runs the passes that `wanted` needs.
    ///
    /// part    of the picture of width x height that is drawn; all of it if empty. Pixels are, bit
    ///         by bit, those of the whole picture, unless an effect reads its neighbours.
    /// throws  InputError for a size below 1, a picture above max_picture_extent or a part above
    ///         what the GL offers
    FrameReport draw(const Camera& camera, int width, int height, const ImageSet& wanted,
                     const std::optional<PicturePart>& part = {});

    /// An image of the last frame, which it must have wanted or needed.
    Image read(FrameImage image) const;

private:
    /// Greatest error of the stored samples of active_ [world].
    float error_of_storage() const;
    /// The active blocks to the GPU.
    void upload(const Progress& progress);
    const IndexBox& surface_box() const;

    gl::Context& context_;
    gl::ShaderLibrary shaders_;
    gl::VertexArray no_vertices_;
    Scene scene_;
    std::shared_ptr<const FieldSource> control_;
    BlockRanges ranges_;
    std::vector<ActivePage> active_;
    std::optional<ActiveSet> moving_; // made when the iso value moves first
    std::optional<CoarseBricks> coarse_;
    FieldOnGpu field_;
    // Where the derivative filter has control samples of its own.
    std::shared_ptr<const FieldSource> derivative_control_;
    BlockRanges derivative_ranges_;
    FieldOnGpu derivative_field_;
    mutable std::optional<IndexBox> surface_box_;
    FrameTargets targets_;
    LookTextures look_textures_;
};

} // namespace isocast
