// The passes of a frame: GL programs and state for each (DESIGN section 4).
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "gl/program.h"
#include "raycaster/brick_atlas.h"
#include "raycaster/frame_plan.h"
#include "raycaster/scene.h"

#include <array>

namespace isocast {

/// A scene's field on the GPU.
struct FieldOnGpu {
    BrickAtlas atlas;
    gl::Buffer face_records;
    gl::VertexArray faces;
    int face_count = 0;
};

/// The images of a frame; only those that a live pass writes exist.
struct FrameTargets {
    std::array<gl::Texture, frame_image_count> textures;
    std::array<gl::Framebuffer, frame_image_count> framebuffers;

    gl::Texture& texture(FrameImage image) { return textures[static_cast<std::size_t>(image)]; }
    gl::Framebuffer& framebuffer(FrameImage image) {
        return framebuffers[static_cast<std::size_t>(image)];
    }
};

/// What every pass of a frame sees.
struct FrameContext {
    gl::ShaderLibrary& shaders;
    const gl::VertexArray& no_vertices;
    const Scene& scene;
    const FieldOnGpu& field;
    const Camera& camera;
    int width;
    int height;
    FrameTargets& targets;
};

/// Every pass there is, in dataflow order. They refer to `frame`, which must outlive them.
std::vector<Pass> declare_passes(FrameContext& frame);

/// Every program that the passes can ask for; for the test that compiles them all.
std::vector<gl::ProgramKey> all_programs();

/// The format of each frame image.
gl::Format format_of(FrameImage image);

/// Coefficients of shaders/common/ray.glsl, computed in double: columns are the constant and the
/// derivatives by gl_FragCoord's x and y.
struct RayCoefficients {
    Mat3d point;    // local index coordinates of a point on a plane through the object
    Mat3d vector;   // from the ray's start to that point [voxels]
    Mat3d from_eye; // from the eye to that point [voxels]
};
RayCoefficients ray_coefficients(const Camera& camera, int width, int height,
                                 const GridSpace& space, const Index3& local_origin_index);

} // namespace isocast
