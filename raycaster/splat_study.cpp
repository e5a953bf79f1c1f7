// SPDX-License-Identifier: MPL-2.0
#include "raycaster/splat_study.h"

#include "gl/sample_counter.h"
#include "raycaster/splat_passes.h"

#include <Eigen/LU>

#include <algorithm>

namespace isocast {

namespace {

gl::ProgramKey covered_program(SplatKind kind, bool is_perspective) {
    gl::ProgramKey key = splat_program(kind, is_perspective, {});
    key.entry_points.back() = "quadrics/covered.frag";
    return key;
}

/// P of the GL's own convention: to [-1, 1] in x, y and z.
Eigen::Matrix4d clip_from_view(const Camera& camera, double aspect, double near, double far) {
    Eigen::Matrix4d p = Eigen::Matrix4d::Zero();
    p(1, 1) = 1 / camera.half_height_at(1);
    p(0, 0) = p(1, 1) / aspect;
    if (camera.projection == Projection::Perspective) {
        p(2, 2) = -(far + near) / (far - near);
        p(2, 3) = -2 * far * near / (far - near);
        p(3, 2) = -1;
    } else {
        p(2, 2) = -2 / (far - near);
        p(2, 3) = -(far + near) / (far - near);
        p(3, 3) = 1;
    }
    return p;
}

} // namespace

SplatFragments count_fragments(const FrameContext& frame) {
    const gl::Texture image =
        gl::Texture::image(gl::Format::R32f, frame.part.width, frame.part.height, "counted splats");
    const gl::Framebuffer target({&image}, "counted splats");
    target.bind();
    gl::SampleCounter rasterised;
    set_fixed_state();
    rasterised.start();
    draw_splats(
        frame, [&](SplatKind kind) { return covered_program(kind, is_perspective(frame)); },
        [](const gl::Program&, const SplatsOnGpu::OfKind&) {});
    rasterised.stop();
    gl::SampleCounter hit;
    hit.start();
    draw_splat_distances(frame, 1);
    hit.stop();
    return {rasterised.count(), hit.count()};
}

void set_equation_7(const gl::Program& program, const FrameContext& frame) {
    double near = std::numeric_limits<double>::infinity();
    double far = -near;
    const Vec3d forward = -frame.camera.view_from_world_rotation().row(2).transpose();
    for (const Sphere& sphere : frame.scene.primitives->spheres) {
        const double depth = forward.dot(sphere.centre_world - frame.camera.eye_world);
        near = std::min(near, depth - sphere.radius_world);
        far = std::max(far, depth + sphere.radius_world);
    }
    near = std::max(near, far / 1000);
    Eigen::Matrix4d window_from_clip = Eigen::Matrix4d::Identity(); // V
    window_from_clip.diagonal() << frame.width / 2.0, frame.height / 2.0, 0.5, 1;
    window_from_clip.col(3) << frame.width / 2.0, frame.height / 2.0, 0.5, 1;
    const Eigen::Matrix4d p =
        clip_from_view(frame.camera, double(frame.width) / frame.height, near, far);
    program.set("u_view_from_window",
                Eigen::Matrix4f((window_from_clip * p).inverse().cast<float>()));
}

std::vector<gl::ProgramKey> splat_study_programs() {
    std::vector<gl::ProgramKey> keys;
    for (const bool is_perspective : {false, true}) {
        for (int k = 0; k < splat_kind_count; ++k)
            keys.push_back(covered_program(static_cast<SplatKind>(k), is_perspective));
        keys.push_back(splat_program(SplatKind::Sphere, is_perspective, {}));
        keys.back().defines["BY_EQUATION_7"] = std::to_string(1);
    }
    return keys;
}

} // namespace isocast
