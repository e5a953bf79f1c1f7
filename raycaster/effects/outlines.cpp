// SPDX-License-Identifier: MPL-2.0
#include "raycaster/effects/effects.h"
#include "raycaster/effects/hit_statistics.h"

#include <algorithm>

namespace isocast {

namespace {

const gl::ProgramKey source_program{{"common/tiles.vert", "shading/outlines/outline_source.frag"},
                                    {}};
const gl::ProgramKey outlines_program{{"common/tiles.vert", "shading/outlines/outlines.frag"}, {}};

/// Depth of the farthest corner of the objects' extents, and the longest diagonal [world].
struct Extent {
    double depth;
    double size;
};

Extent extent_of(const FrameContext& frame) {
    Extent extent{-1e30, extent_diagonal_world(frame)};
    const Mat3d view_from_world = frame.camera.view_from_world_rotation();
    for (const std::array<Vec3d, 8>& corners : frame.seen.extents_world)
        for (const Vec3d& corner : corners)
            extent.depth =
                std::max(extent.depth, -(view_from_world * (corner - frame.camera.eye_world)).z());
    return extent;
}

void set_camera_uniforms(const gl::Program& program, const FrameContext& frame) {
    program.set(
        "u_ray_vector",
        Eigen::Matrix3f(
            world_vector_coefficients(frame.camera, frame.width, frame.height).cast<float>()));
    program.set("u_is_perspective", frame.camera.projection == Projection::Perspective ? 1 : 0);
}

} // namespace

void run_outline_source(FrameContext& frame) {
    const gl::Program& program = frame.shaders.program(source_program);
    frame.targets.texture(FrameImage::Hit).bind_to_unit(0);
    frame.targets.texture(FrameImage::Gradient).bind_to_unit(1);
    set_camera_uniforms(program, frame);
    program.set(
        "u_forward",
        Eigen::Vector3f(-frame.camera.view_from_world_rotation().row(2).transpose().cast<float>()));
    const Extent extent = extent_of(frame);
    program.set("u_background_depth", static_cast<float>(extent.depth + extent.size));
    draw_tiles(frame, FrameImage::OutlineSource, program, Eigen::Vector4f::Zero());
}

void run_outlines(FrameContext& frame) {
    const Outlines& outlines = frame.scene.look.effects.outlines;
    const gl::Program& program = frame.shaders.program(outlines_program);
    frame.targets.texture(FrameImage::OutlineSource).bind_to_unit(0);
    set_camera_uniforms(program, frame);
    const Mat3d view_from_world = frame.camera.view_from_world_rotation();
    const double pixel = 2 * frame.camera.half_height_at(1) / frame.height;
    program.set("u_pixel_x",
                Eigen::Vector3f((pixel * view_from_world.row(0)).transpose().cast<float>()));
    program.set("u_pixel_y",
                Eigen::Vector3f((pixel * view_from_world.row(1)).transpose().cast<float>()));
    program.set("u_silhouette_threshold",
                static_cast<float>(outlines.silhouette_threshold * extent_of(frame).size));
    program.set("u_crease_threshold", static_cast<float>(outlines.crease_threshold));
    program.set("u_colour", Eigen::Vector3f(outlines.colour.cast<float>()));
    draw_around_tiles(frame, FrameImage::Outlines, program, Eigen::Vector4f::Zero());
}

std::vector<gl::ProgramKey> outlines_programs() {
    return {source_program, outlines_program};
}

} // namespace isocast
