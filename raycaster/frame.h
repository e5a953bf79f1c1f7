// What the passes of a frame share: its images, its camera, and how they draw.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "gl/program.h"
#include "raycaster/field_on_gpu.h"
#include "raycaster/frame_plan.h"
#include "raycaster/splats_on_gpu.h"

#include <array>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>

namespace isocast {

/// The images of a frame; only those that a live pass writes exist.
struct FrameTargets {
    std::array<gl::Texture, frame_image_count> textures;
    std::array<gl::Framebuffer, frame_image_count> framebuffers;

    gl::Texture& texture(FrameImage image) { return textures[static_cast<std::size_t>(image)]; }
    gl::Framebuffer& framebuffer(FrameImage image) {
        return framebuffers[static_cast<std::size_t>(image)];
    }
    /// Contents are undefined until drawn.
    void make(FrameImage image, int width, int height);
};

/// What effects make from the scene (environments, maps, noise), kept from frame to frame.
class LookTextures {
public:
    /// Made on the first call with this name.
    const gl::Texture& texture(const std::string& name, const std::function<gl::Texture()>& make);
    std::int64_t byte_count() const;

private:
    std::map<std::string, gl::Texture> textures_;
};

/// A number that an effect found in a picture, or that this one had none.
struct FoundNumber {
    std::optional<double> value;
    // of the picture
    Camera camera;
    int width;
    int height;
};
/// By names that say what they measure (raycaster/effects/hit_statistics.h). They hold from the
/// first picture that has any on, so that sequences do not flicker.
using LookNumbers = std::map<std::string, FoundNumber>;

/// An object of a field as a frame sees it.
struct FrameObject {
    const FieldObject& object;
    FieldOnGpu& field;
    FieldOnGpu& derivative_field; // of the same blocks; `field` where control samples are shared
    FieldOnGpu& curvature_field;  // of the same blocks, what curvatures are derived from
    PlacesOnGpu places;
    Eigen::AlignedBox3d box_world; // of its active blocks; empty if there is none
};

/// What one camera sees of a scene.
struct SeenScene {
    std::vector<FrameObject> objects;  // by number; none in a scene of primitives alone
    std::optional<SplatsOnGpu> splats; // of a scene with primitives
    /// Corners of the extents of all fields, and of the box of the primitives.
    std::vector<std::array<Vec3d, 8>> extents_world;
    /// The tiles in which any of them can show something, without lists: unless there is but one
    /// object, which has its own.
    PlacesOnGpu places_of_all;

    bool has_one_object() const { return objects.size() == 1 && !splats; }
    const PlacesOnGpu& places() const {
        return has_one_object() ? objects.front().places : places_of_all;
    }
};

/// The camera of the shadow map, and its size.
struct LightView {
    Camera camera; // orthographic
    int width;
    int height;
    double texel_world;
    bool operator==(const LightView&) const = default;
};

struct OwnFrame;

/// What every pass of a frame sees.
struct FrameContext {
    gl::ShaderLibrary& shaders;
    const gl::VertexArray& no_vertices;
    const Scene& scene;
    const SeenScene& seen;
    // The scene's first object, or that of of_object(); none in a scene of primitives alone. Passes
    // that read a field read this one's.
    const FrameObject* one;
    const PlacesOnGpu& places;
    const Camera& camera;
    int width; // of the whole picture
    int height;
    FrameTargets& targets;
    LookTextures& look_textures;
    LookNumbers& look_numbers;
    PicturePart part{.width = width, .height = height}; // of the picture, that the images show
    std::int64_t scratch_bytes = 0;      // of textures that a pass made for itself alone
    ImageSet live = {};                  // what the passes of this frame write
    bool has_fused_gradient = false;     // the pass "raycast" writes gradients too
    std::vector<std::string> notes = {}; // what was chosen for the user, to be reported
    std::optional<LightView> light = {}; // if there is a shadow map
    std::function<std::array<Vec3d, 8>()> surface_box_world = {}; // as Renderer's
    /// The scene as another camera sees it.
    std::function<SeenScene(const Camera& camera, int width, int height)> see = {};
    const Primitives* primitives = nullptr;  // these, with spheres for dots
    std::shared_ptr<OwnFrame> overview = {}; // the whole picture in small, once it is asked for

    const FieldObject& object() const { return one->object; }
    FieldOnGpu& field() const { return one->field; }
    FieldOnGpu& derivative_field() const { return one->derivative_field; }
    FieldOnGpu& curvature_field() const { return one->curvature_field; }
};

/// Another view of a frame's scene, with images of its own.
struct OwnFrame {
    /// outer, camera  must outlive it
    OwnFrame(const FrameContext& outer, const Camera& camera, int width, int height);
    OwnFrame(const OwnFrame&) = delete;

    FrameTargets targets;
    SeenScene seen;
    FrameContext frame;
};

/// The frame with one of its objects in the place of the only one.
FrameContext of_object(const FrameContext& frame, const FrameObject& object);
/// Whether hits have several owners: objects, or an object and the primitives.
inline bool has_owners(const FrameContext& frame) {
    return !frame.seen.has_one_object();
}
/// Length of the longest diagonal of an object's extent [world].
double extent_diagonal_world(const FrameContext& frame);
/// Below it the scene has nothing to show: a voxel, or 1/1000 of the extent of primitives alone.
double detail_world(const FrameContext& frame);
/// Towards the light, of unit length, world axes.
Vec3d direction_world(const Light& light, const Camera& viewer);

/// Depth test, culling and blending off.
void set_fixed_state();
/// Sets the uniform of shaders/common/pixel.glsl if the program has it. Those below do.
void set_first_pixel(const FrameContext& frame, const gl::Program& program);
/// Runs the program on every pixel that can show something, into the bound framebuffer.
void draw_on_tiles(const FrameContext& frame, const gl::Program& program);
/// The same on tiles of one's own.
void draw_on_tiles(const FrameContext& frame, const gl::Program& program, const PlacesOnGpu& tiles);
/// The same where gl_FragDepth is greater than what is there.
void draw_on_tiles_by_depth(const FrameContext& frame, const gl::Program& program);
/// The same into an image whose other pixels become `empty`.
void draw_tiles(const FrameContext& frame, FrameImage image, const gl::Program& program,
                const Eigen::Vector4f& empty);
/// The same a pixel farther, for effects that reach so far beyond hits.
void draw_around_tiles(const FrameContext& frame, FrameImage image, const gl::Program& program,
                       const Eigen::Vector4f& empty);
/// The same on all pixels.
void draw_everywhere(const FrameContext& frame, FrameImage image, const gl::Program& program);

/// Coefficients of shaders/common/ray.glsl, computed in double: columns are the constant and the
/// derivatives by the x and y of shaders/common/pixel.glsl, in a picture of width x height.
struct RayCoefficients {
    Mat3d point;        // local index coordinates of a point on a plane through the object
    Mat3d vector;       // from the ray's start to that point [voxels]
    Mat3d from_eye;     // from the eye to that point [voxels]
    double depth_world; // of the plane, in front of the eye
};
RayCoefficients ray_coefficients(const Camera& camera, int width, int height,
                                 const GridSpace& space, const Index3& local_origin_index);

/// Its rotation, of the frame's camera.
Eigen::Matrix3f world_from_view(const FrameContext& frame);

/// Columns (constant, d/dx, d/dy) of the affine map from the place in the picture, of
/// shaders/common/pixel.glsl, to the vector in world axes from a ray's start to a point
/// `depth_world` in front of it.
Mat3d world_vector_coefficients(const Camera& camera, int width, int height,
                                double depth_world = 1);

/// Of the map to a ray's start from the eye [world], in world axes: 0 unless rays are parallel.
Mat3d world_start_coefficients(const Camera& camera, int width, int height);

/// The eye, in local index coordinates.
Vec3d eye_local(const Camera& camera, const GridSpace& space, const Index3& local_origin_index);

/// The format of each frame image.
gl::Format format_of(FrameImage image);

} // namespace isocast
