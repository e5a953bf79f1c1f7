// SPDX-License-Identifier: MPL-2.0
#include "raycaster/passes.h"

#include <Eigen/Eigenvalues>
#include <glad/gl.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace isocast {

namespace {

const gl::ProgramKey bounds_program{{"raycast/bounds.vert", "raycast/bounds.frag"}, {}};
const gl::ProgramKey raycast_program{{"common/fullscreen.vert", "raycast/raycast.frag"}, {}};
const gl::ProgramKey gradient_program{{"common/fullscreen.vert", "raycast/gradient.frag"}, {}};
const gl::ProgramKey blinn_phong_program{
    {"common/fullscreen.vert", "shading/blinn_phong/blinn_phong.frag"}, {}};

// 1e30: beyond any parameter of a ray; shaders/raycast/bounds.glsl has the same number.
constexpr float no_bound = 1e30f;

/// Columns (constant, d/dx, d/dy) of the affine map from gl_FragCoord to view space at `depth` in
/// front of the eye; gl_FragCoord has its origin at the bottom left.
Mat3d view_point_coefficients(const Camera& camera, int width, int height, double depth) {
    const double half_height = camera.projection == Projection::Perspective
                                   ? depth * std::tan(camera.fov_y_degrees * std::numbers::pi / 360)
                                   : camera.height_world / 2;
    const double half_width = half_height * width / height;
    Mat3d columns;
    columns.col(0) = Vec3d(-half_width, -half_height, -depth);
    columns.col(1) = Vec3d(2 * half_width / width, 0, 0);
    columns.col(2) = Vec3d(0, 2 * half_height / height, 0);
    return columns;
}

/// The same for the vectors that lead from the rays' starts to those points.
Mat3d view_vector_coefficients(const Camera& camera, int width, int height, double depth) {
    Mat3d columns = view_point_coefficients(camera, width, height, depth);
    if (camera.projection == Projection::Orthographic) {
        columns.setZero();
        columns(2, 0) = -depth;
    }
    return columns;
}

/// Clip space from local index coordinates; the depth is not used.
Eigen::Matrix4d clip_from_local(const Camera& camera, int width, int height, const GridSpace& space,
                                const Index3& local_origin_index) {
    const Mat3d rotation = camera.view_from_world_rotation();
    const Mat3d linear = rotation * space.world_from_index.linear();
    const Vec3d offset =
        rotation * (space.to_world(local_origin_index.cast<double>()) - camera.eye_world);
    Eigen::Matrix4d view_from_local = Eigen::Matrix4d::Identity();
    view_from_local.topLeftCorner<3, 3>() = linear;
    view_from_local.topRightCorner<3, 1>() = offset;

    const double aspect = double(width) / height;
    Eigen::Matrix4d clip_from_view = Eigen::Matrix4d::Zero();
    if (camera.projection == Projection::Perspective) {
        const double tan_y = std::tan(camera.fov_y_degrees * std::numbers::pi / 360);
        clip_from_view(0, 0) = 1 / (tan_y * aspect);
        clip_from_view(1, 1) = 1 / tan_y;
        clip_from_view(3, 2) = -1;
    } else {
        clip_from_view(0, 0) = 2 / (camera.height_world * aspect);
        clip_from_view(1, 1) = 2 / camera.height_world;
        clip_from_view(3, 3) = 1;
    }
    return clip_from_view * view_from_local;
}

RayCoefficients set_ray_uniforms(const gl::Program& program, const FrameContext& frame) {
    const RayCoefficients ray =
        ray_coefficients(frame.camera, frame.width, frame.height, frame.scene.field->space(),
                         frame.field.atlas.local_origin_index());
    program.set("u_ray_point", Eigen::Matrix3f(ray.point.cast<float>()));
    program.set("u_ray_vector", Eigen::Matrix3f(ray.vector.cast<float>()));
    return ray;
}

void set_fixed_state() {
    glDisable(GL_DEPTH_TEST);
    glDisable(GL_CULL_FACE);
    glDisable(GL_BLEND);
}

void draw_fullscreen(const FrameContext& frame, const gl::Program& program) {
    set_fixed_state();
    frame.no_vertices.bind();
    program.use();
    glDrawArrays(GL_TRIANGLES, 0, 3);
}

void run_bounds(FrameContext& frame) {
    frame.targets.framebuffer(FrameImage::Bounds).bind();
    const float clear[4] = {no_bound, no_bound, no_bound, 0};
    glClearBufferfv(GL_COLOR, 0, clear);
    const gl::Program& program = frame.shaders.program(bounds_program);
    set_ray_uniforms(program, frame);
    program.set("u_clip_from_local",
                Eigen::Matrix4f(clip_from_local(frame.camera, frame.width, frame.height,
                                                frame.scene.field->space(),
                                                frame.field.atlas.local_origin_index())
                                    .cast<float>()));
    set_fixed_state();
    glEnable(GL_BLEND);
    glBlendEquation(GL_MIN);
    frame.field.faces.bind();
    program.use();
    glDrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, frame.field.face_count);
}

void run_raycast(FrameContext& frame) {
    frame.targets.framebuffer(FrameImage::Hit).bind();
    const gl::Program& program = frame.shaders.program(raycast_program);
    const GridSpace& space = frame.scene.field->space();
    const Quality& quality = frame.scene.quality;
    const RayCoefficients ray = set_ray_uniforms(program, frame);
    frame.field.atlas.bind(program);
    frame.targets.texture(FrameImage::Bounds).bind_to_unit(2);
    program.set("u_ray_from_eye", Eigen::Matrix3f(ray.from_eye.cast<float>()));
    program.set("u_fine_step", float(1 / (quality.rate * quality.rate_factor)));
    program.set("u_fine_per_coarse", quality.rate_factor);
    // A field whose slope is at most L [world/voxel] has no root within a coarse step of a sample
    // that is farther from iso than L steps. Distances have slope one in the world, hence at most
    // the grid's greatest stretch in index space; other fields give their own bound.
    const double slope = frame.scene.field->half_width_world()
                             ? space.world_from_index.linear().operatorNorm()
                             : double(frame.field.atlas.greatest_slope());
    program.set("u_near_threshold", float(slope / quality.rate));
    program.set("u_refinement_steps", quality.refinement_steps);
    program.set("u_world_from_index",
                Eigen::Matrix3f(space.world_from_index.linear().cast<float>()));
    draw_fullscreen(frame, program);
}

void run_gradient(FrameContext& frame) {
    frame.targets.framebuffer(FrameImage::Gradient).bind();
    const gl::Program& program = frame.shaders.program(gradient_program);
    frame.field.atlas.bind(program);
    frame.targets.texture(FrameImage::Hit).bind_to_unit(2);
    const GridSpace& space = frame.scene.field->space();
    const Vec3d eye_local = space.to_index(frame.camera.eye_world) -
                            frame.field.atlas.local_origin_index().cast<double>();
    program.set("u_index_from_world",
                Eigen::Matrix3f(space.world_from_index.linear().inverse().cast<float>()));
    program.set("u_eye_local", Eigen::Vector3f(eye_local.cast<float>()));
    draw_fullscreen(frame, program);
}

void run_shading(FrameContext& frame) {
    frame.targets.framebuffer(FrameImage::Beauty).bind();
    const gl::Program& program = frame.shaders.program(blinn_phong_program);
    frame.targets.texture(FrameImage::Hit).bind_to_unit(0);
    frame.targets.texture(FrameImage::Gradient).bind_to_unit(1);
    const Mat3d world_from_view = frame.camera.view_from_world_rotation().transpose();
    const Material& material = frame.scene.material;
    program.set("u_ray_vector",
                Eigen::Matrix3f((world_from_view * view_vector_coefficients(
                                                       frame.camera, frame.width, frame.height, 1))
                                    .cast<float>()));
    program.set(
        "u_light_direction",
        Eigen::Vector3f(
            (world_from_view * frame.scene.light.direction_view).normalized().cast<float>()));
    program.set("u_light_colour", Eigen::Vector3f(frame.scene.light.colour.cast<float>()));
    program.set("u_colour", Eigen::Vector3f(material.colour.cast<float>()));
    program.set("u_material", Eigen::Vector4f(float(material.ambient), float(material.diffuse),
                                              float(material.specular), float(material.shininess)));
    program.set("u_background", Eigen::Vector3f(frame.scene.background.cast<float>()));
    draw_fullscreen(frame, program);
}

} // namespace

RayCoefficients ray_coefficients(const Camera& camera, int width, int height,
                                 const GridSpace& space, const Index3& local_origin_index) {
    const Mat3d rotation = camera.view_from_world_rotation();
    const Mat3d index_from_view = space.world_from_index.linear().inverse() * rotation.transpose();
    const Vec3d eye_local = space.to_index(camera.eye_world) - local_origin_index.cast<double>();
    // The plane passes through the object's middle; if that lies behind the eye or at it, a plane
    // one voxel away serves, since the eye is then inside the object and coordinates are small.
    const double depth = std::max(
        -(rotation * (space.to_world(local_origin_index.cast<double>()) - camera.eye_world)).z(),
        space.voxel_size_world());
    RayCoefficients ray;
    ray.from_eye = index_from_view * view_point_coefficients(camera, width, height, depth);
    ray.point = ray.from_eye;
    ray.point.col(0) += eye_local;
    ray.vector = index_from_view * view_vector_coefficients(camera, width, height, depth);
    return ray;
}

std::vector<Pass> declare_passes(FrameContext& frame) {
    return {
        {"bounds", {}, FrameImage::Bounds, [&frame] { run_bounds(frame); }},
        {"raycast", {FrameImage::Bounds}, FrameImage::Hit, [&frame] { run_raycast(frame); }},
        {"gradient", {FrameImage::Hit}, FrameImage::Gradient, [&frame] { run_gradient(frame); }},
        {"shading",
         {FrameImage::Hit, FrameImage::Gradient},
         FrameImage::Beauty,
         [&frame] { run_shading(frame); }},
    };
}

std::vector<gl::ProgramKey> all_programs() {
    return {bounds_program, raycast_program, gradient_program, blinn_phong_program};
}

gl::Format format_of(FrameImage image) {
    return image == FrameImage::Beauty ? gl::Format::Rgba16f : gl::Format::Rgba32f;
}

} // namespace isocast
