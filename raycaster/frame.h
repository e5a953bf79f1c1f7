// What the passes of a frame share: its images, its camera, and how they draw.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "gl/program.h"
#include "raycaster/field_on_gpu.h"
#include "raycaster/frame_plan.h"

#include <array>
#include <functional>
#include <map>
#include <optional>
#include <string>

namespace isocast {

/// The images of a frame; only those that a live pass writes exist.
struct FrameTargets {
    std::array<gl::Texture, frame_image_count> textures;
    std::array<gl::Framebuffer, frame_image_count> framebuffers;
    gl::Framebuffer hit_and_gradient; // where one pass writes both

    gl::Texture& texture(FrameImage image) { return textures[static_cast<std::size_t>(image)]; }
    gl::Framebuffer& framebuffer(FrameImage image) {
        return framebuffers[static_cast<std::size_t>(image)];
    }
};

/// What effects make from the scene (environments, maps, noise) and find in its first picture,
/// kept from frame to frame.
class LookTextures {
public:
    /// Made on the first call with this name.
    const gl::Texture& texture(const std::string& name, const std::function<gl::Texture()>& make);
    /// Found on the first call with this name that finds something, so that a sequence of pictures
    /// has one range.
    std::optional<std::array<double, 2>>
    range(const std::string& name,
          const std::function<std::optional<std::array<double, 2>>()>& find);
    std::int64_t byte_count() const;

private:
    std::map<std::string, gl::Texture> textures_;
    std::map<std::string, std::array<double, 2>> ranges_;
};

/// What every pass of a frame sees.
struct FrameContext {
    gl::ShaderLibrary& shaders;
    const gl::VertexArray& no_vertices;
    const Scene& scene;
    FieldOnGpu& field;
    FieldOnGpu& derivative_field; // of the same blocks; `field` where control samples are shared
    const PlacesOnGpu& places;
    const Camera& camera;
    int width;
    int height;
    FrameTargets& targets;
    LookTextures& look_textures;
    bool has_fused_gradient = false;     // the pass "raycast" writes gradients too
    std::vector<std::string> notes = {}; // what was chosen for the user, to be reported
};

/// Depth test, culling and blending off.
void set_fixed_state();
/// Runs the program on every pixel that can show something, into the bound framebuffer.
void draw_on_tiles(const FrameContext& frame, const gl::Program& program);
/// The same into an image whose other pixels become `empty`.
void draw_tiles(const FrameContext& frame, FrameImage image, const gl::Program& program,
                const Eigen::Vector4f& empty);
/// The same on all pixels.
void draw_everywhere(const FrameContext& frame, FrameImage image, const gl::Program& program);

/// Coefficients of shaders/common/ray.glsl, computed in double: columns are the constant and the
/// derivatives by gl_FragCoord's x and y.
struct RayCoefficients {
    Mat3d point;    // local index coordinates of a point on a plane through the object
    Mat3d vector;   // from the ray's start to that point [voxels]
    Mat3d from_eye; // from the eye to that point [voxels]
};
RayCoefficients ray_coefficients(const Camera& camera, int width, int height,
                                 const GridSpace& space, const Index3& local_origin_index);

/// Columns (constant, d/dx, d/dy) of the affine map from gl_FragCoord to the vector in world axes
/// from a ray's start to a point `depth_world` in front of it.
Mat3d world_vector_coefficients(const Camera& camera, int width, int height,
                                double depth_world = 1);

/// The eye, in local index coordinates.
Vec3d eye_local(const Camera& camera, const GridSpace& space, const Index3& local_origin_index);

/// The format of each frame image.
gl::Format format_of(FrameImage image);

} // namespace isocast
