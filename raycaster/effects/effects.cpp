// SPDX-License-Identifier: MPL-2.0
#include "raycaster/effects/effects.h"

namespace isocast {

void set_surface_uniforms(const gl::Program& program, const FrameContext& frame) {
    frame.targets.texture(FrameImage::Hit).bind_to_unit(0);
    frame.targets.texture(FrameImage::Gradient).bind_to_unit(1);
    program.set(
        "u_ray_vector",
        Eigen::Matrix3f(
            world_vector_coefficients(frame.camera, frame.width, frame.height).cast<float>()));
}

} // namespace isocast
