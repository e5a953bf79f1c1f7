// From scene and camera to images.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "gl/context.h"
#include "gl/program.h"
#include "raycaster/frame.h"
#include "raycaster/image.h"
#include "raycaster/loaded_object.h"
#include "raycaster/shown_surfaces.h"

namespace isocast {

/// What one pass of a frame cost, or that it did not run.
struct PassReport {
    std::string name;
    bool ran = false;
    std::string asked_by;           // passes that read its image, "output" if it was requested
    std::string drawn_by;           // another pass that writes its image on the way
    bool is_kept = false;           // it need not run: its image is the last frame's
    double milliseconds = 0;        // of the last frame
    std::int64_t texture_bytes = 0; // of the image it writes
};

/// What a frame cost.
struct FrameReport {
    std::vector<PassReport> passes; // all declared ones, in order
    int programs_compiled = 0;      // since the renderer was made
    std::int64_t image_bytes = 0;   // textures of frame images
    std::int64_t field_bytes = 0;   // atlas, reference texture and bounding geometry
    std::int64_t splat_bytes = 0;   // primitives that the camera can see, and all their colours
    std::int64_t scratch_bytes = 0; // textures that live during one pass alone
    std::int64_t look_bytes = 0;    // environments, colour maps, noise
    std::vector<std::string> notes; // what was chosen for the user, like a colour map's range
    std::optional<SplatFragments> splat_fragments; // if a study counts them
};

/// Draws one scene with one context.
class Renderer {
public:
    /// shader_folder  the project's shaders/
    Renderer(gl::Context& context, const std::filesystem::path& shader_folder);
    /// Finds the active blocks and uploads their bricks; what the scene before had alike is kept.
    /// throws  InputError if the scene is wrong (objects_of), asks for Catmull-Rom's filter by
    ///         linear fetches, for an impossible scale of curvatures, or for several objects by
    ///         other than certified steps and lists; ResourceError if it does not fit
    void load(Scene scene, const Progress& progress = {});

    /// Moves the isosurface of an object of the loaded scene: pictures are, bit by bit, those of
    /// the same scene loaded at `iso_world`. The control samples and the ranges stay. All bricks
    /// are cut anew, since samples are stored as f - iso: near the surface, where these are small,
    /// that keeps the digits that sums of f would lose. throws  as load
    void set_iso(double iso_world, int object = 0);
    /// The same of those that differ. objects  the scene's, with other iso values
    void set_isos(const std::vector<FieldObject>& objects);

    /// Changes how rays search, but for the traversal. throws  as load
    void set_quality(const Quality& quality);

    /// Keeps what the last pictures of so many parts were made of: what is drawn again of the same
    /// camera and size runs only the passes whose images a new look changed.
    void keep_parts(std::size_t count);

    /// Changes how hits are shaded; the field stays, and so do the numbers that were found.
    /// throws  InputError if the look asks for what there is not
    void set_look(Look look);
    const Look& look() const { return scene_.look; }

    /// For benchmarks.
    void set_study(const SplatStudy& study);

    /// What effects found in the first picture since load, where the look says no number: in the
    /// whole picture at overview_pixels at most, whatever part and size are drawn.
    const LookNumbers& look_numbers() const { return look_numbers_; }
    /// Of another load, to be used instead of this one's.
    void set_look_numbers(LookNumbers numbers);

    /// As ShownSurfaces has them; found when one is first asked for.
    std::array<Vec3d, 8> surface_box_world() const;
    std::vector<Vec3d> surface_points_world() const; // cameras frame these
    bool has_surface() const;
    const BrickPool& pool(int object = 0) const { return at(object).field().pool(); }
    /// Bricks of lower resolution, if there are any: since the budget has no room for more, or, if
    /// it is adapted, since the field has no more detail.
    const std::optional<CoarseBricks>& coarse_bricks(int object = 0) const {
        return at(object).coarse_bricks();
    }
    bool is_adapted(int object = 0) const { return at(object).is_adapted(); }

    /// Runs the passes that `wanted` needs.
    ///
    /// part    of the picture of width x height that is drawn; all of it if empty. Pixels are, bit
    ///         by bit, those of the whole picture, unless an effect reads its neighbours.
    /// throws  InputError for a size below 1, a picture above max_picture_extent or a part above
    ///         what the GL offers, and for shadows if no light casts any
    FrameReport draw(const Camera& camera, int width, int height, const ImageSet& wanted,
                     const std::optional<PicturePart>& part = {});

    /// An image of the last frame, which it must have wanted or needed.
    Image read(FrameImage image) const;
    /// The same on the GPU, the bottom row first.
    const gl::Texture& texture(FrameImage image) const;

private:
    /// The last picture of a part, and which of its images still hold.
    struct DrawnPart {
        Camera camera;
        int width = 0;
        int height = 0;
        PicturePart part;
        FrameTargets targets = {};
        std::optional<SeenScene> seen = {};
        ImageSet drawn = {};
    };
    /// Becomes the last of those that are kept.
    DrawnPart& part_of(const Camera& camera, int width, int height, const PicturePart& part);
    /// Nothing that was drawn is what would be drawn.
    void forget_parts();
    const LoadedObject& at(int object) const {
        return *objects_.at(static_cast<std::size_t>(object));
    }
    /// throws  ResourceError if a field does not fit that must
    void check_residence();
    ShownSurfaces shown() const;

    SeenScene seen_by(const Camera& camera, int width, int height, const PicturePart& part,
                      double detail_pixels);

    gl::Context& context_;
    gl::ShaderLibrary shaders_;
    gl::VertexArray no_vertices_;
    Scene scene_;
    SplatStudy study_;
    std::vector<std::unique_ptr<LoadedObject>> objects_;
    std::shared_ptr<const Primitives> primitives_; // of the scene, as the last picture had dots
    PrimitivesOnGpu primitives_on_gpu_;            // of these
    std::vector<CutPlane> cut_planes_;             // of these, of the last picture's viewer
    Eigen::AlignedBox3d primitives_box_;           // of these, if there are some; else empty
    std::optional<LightView> shadow_map_; // where it was drawn from, if it is that of these objects
    std::size_t kept_part_count_ = 0;
    std::vector<DrawnPart> parts_; // that of the last frame is the last
    LookTextures look_textures_;
    LookNumbers look_numbers_;
};

} // namespace isocast
