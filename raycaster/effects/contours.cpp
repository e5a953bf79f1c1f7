// SPDX-License-Identifier: MPL-2.0
#include "raycaster/effects/effects.h"

namespace isocast {

void run_contours(FrameContext& frame) {
    const Contours& contours = frame.scene.look.effects.contours;
    const Camera& camera = frame.camera;
    const gl::Program& program = frame.shaders.program(contours_programs().front());
    frame.targets.texture(FrameImage::Hit).bind_to_unit(0);
    frame.targets.texture(FrameImage::Gradient).bind_to_unit(1);
    frame.targets.texture(FrameImage::ViewCurvature).bind_to_unit(2);
    program.set("u_ray_vector",
                Eigen::Matrix3f(
                    world_vector_coefficients(camera, frame.width, frame.height).cast<float>()));
    program.set(
        "u_forward",
        Eigen::Vector3f(-camera.view_from_world_rotation().row(2).transpose().cast<float>()));
    program.set("u_is_perspective", camera.projection == Projection::Perspective ? 1 : 0);
    program.set("u_pixels_per_world",
                static_cast<float>(frame.height / (2 * camera.half_height_at(1))));
    program.set("u_thickness", static_cast<float>(contours.thickness_pixels));
    program.set("u_colour", Eigen::Vector3f(contours.colour.cast<float>()));
    draw_tiles(frame, FrameImage::Contours, program, Eigen::Vector4f::Zero());
}

std::vector<gl::ProgramKey> contours_programs() {
    return {{{"common/tiles.vert", "shading/contours/contours.frag"}, {}}};
}

} // namespace isocast
