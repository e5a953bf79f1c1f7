// SPDX-License-Identifier: MPL-2.0
#include "raycaster/frame.h"

#include <glad/gl.h>

#include <algorithm>

namespace isocast {

void set_fixed_state() {
    glDisable(GL_DEPTH_TEST);
    glDisable(GL_CULL_FACE);
    glDisable(GL_BLEND);
}

void set_first_pixel(const FrameContext& frame, const gl::Program& program) {
    if (program.has("u_first_pixel"))
        program.set("u_first_pixel",
                    Eigen::Vector2f(frame.part.first_pixel(frame.height).cast<float>()));
}

namespace {

/// Columns (constant, d/dx, d/dy) of the affine map from pixels to view space at `depth` in front
/// of the eye; like gl_FragCoord's they have their origin at the bottom left.
Mat3d view_point_coefficients(const Camera& camera, int width, int height, double depth) {
    const double half_height = camera.half_height_at(depth);
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

/// Two triangles for each run of tiles.
void draw_runs(const FrameContext& frame, const gl::Program& program, const NumbersOnGpu& runs,
               int run_count) {
    frame.no_vertices.bind();
    runs.texture.bind_to_unit(31);
    program.set("u_clip_from_tile",
                Eigen::Vector2f(2.0F * tile_pixels / static_cast<float>(frame.part.width),
                                2.0F * tile_pixels / static_cast<float>(frame.part.height)));
    set_first_pixel(frame, program);
    program.use();
    glDrawArrays(GL_TRIANGLES, 0, 6 * run_count);
}

} // namespace

void FrameTargets::make(FrameImage image, int width, int height) {
    framebuffer(image) = {};
    texture(image) = {}; // so that the old one and the new are never both in memory
    texture(image) = gl::Texture::image(format_of(image), width, height, name_of(image));
    framebuffer(image) = gl::Framebuffer({&texture(image)}, name_of(image));
}

Vec3d direction_world(const Light& light, const Camera& viewer) {
    const Vec3d direction =
        light.is_in_view_space
            ? Vec3d(viewer.view_from_world_rotation().transpose() * light.direction)
            : light.direction;
    return direction.normalized();
}

const gl::Texture& LookTextures::texture(const std::string& name,
                                         const std::function<gl::Texture()>& make) {
    auto found = textures_.find(name);
    if (found == textures_.end()) found = textures_.emplace(name, make()).first;
    return found->second;
}

std::int64_t LookTextures::byte_count() const {
    std::int64_t bytes = 0;
    for (const auto& [name, texture] : textures_) bytes += texture.byte_count();
    return bytes;
}

FrameContext of_object(const FrameContext& frame, const FrameObject& object) {
    return {frame.shaders,
            frame.no_vertices,
            frame.scene,
            frame.seen,
            &object,
            object.places,
            frame.camera,
            frame.width,
            frame.height,
            frame.targets,
            frame.look_textures,
            frame.look_numbers,
            frame.part,
            0,
            frame.live,
            frame.has_fused_gradient};
}

OwnFrame::OwnFrame(const FrameContext& outer, const Camera& camera, int width, int height)
    : seen(outer.see(camera, width, height)), frame{outer.shaders,
                                                    outer.no_vertices,
                                                    outer.scene,
                                                    seen,
                                                    seen.objects.empty() ? nullptr
                                                                         : &seen.objects.front(),
                                                    seen.places(),
                                                    camera,
                                                    width,
                                                    height,
                                                    targets,
                                                    outer.look_textures,
                                                    outer.look_numbers} {}

double extent_diagonal_world(const FrameContext& frame) {
    double longest = 0;
    for (const std::array<Vec3d, 8>& corners : frame.seen.extents_world)
        for (std::size_t i = 0; i < 4; ++i) // of the four diagonals of a box that may be skewed
            longest = std::max(longest, (corners[7 - i] - corners[i]).norm());
    return longest;
}

double detail_world(const FrameContext& frame) {
    return frame.one != nullptr ? frame.object().field->space().voxel_size_world()
                                : extent_diagonal_world(frame) / 1000;
}

void draw_on_tiles(const FrameContext& frame, const gl::Program& program) {
    draw_on_tiles(frame, program, frame.places);
}

void draw_on_tiles(const FrameContext& frame, const gl::Program& program,
                   const PlacesOnGpu& tiles) {
    set_fixed_state();
    draw_runs(frame, program, tiles.runs, tiles.run_count);
}

void draw_on_tiles_by_depth(const FrameContext& frame, const gl::Program& program) {
    set_fixed_state();
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_GREATER);
    draw_runs(frame, program, frame.places.runs, frame.places.run_count);
    glDisable(GL_DEPTH_TEST);
}

void draw_tiles(const FrameContext& frame, FrameImage image, const gl::Program& program,
                const Eigen::Vector4f& empty) {
    frame.targets.framebuffer(image).bind();
    glClearBufferfv(GL_COLOR, 0, empty.data());
    draw_on_tiles(frame, program);
}

void draw_around_tiles(const FrameContext& frame, FrameImage image, const gl::Program& program,
                       const Eigen::Vector4f& empty) {
    frame.targets.framebuffer(image).bind();
    glClearBufferfv(GL_COLOR, 0, empty.data());
    PlacesOnGpu around;
    around.set_runs(grown_runs(frame.places.tile_runs, frame.part.width, frame.part.height));
    draw_on_tiles(frame, program, around);
}

void draw_everywhere(const FrameContext& frame, FrameImage image, const gl::Program& program) {
    frame.targets.framebuffer(image).bind();
    const std::vector<Eigen::Vector4i> runs = whole_picture(frame.part.width, frame.part.height);
    const NumbersOnGpu all{std::as_bytes(std::span(runs)), gl::Format::Rgba32i, "whole picture"};
    set_fixed_state();
    draw_runs(frame, program, all, static_cast<int>(runs.size()));
}

RayCoefficients ray_coefficients(const Camera& camera, int width, int height,
                                 const GridSpace& space, const Index3& local_origin_index) {
    const Mat3d rotation = camera.view_from_world_rotation();
    const Mat3d index_from_view = space.world_from_index.linear().inverse() * rotation.transpose();
    // The plane passes through the object's middle; if that lies behind the eye or at it, a plane
    // one voxel away serves, since the eye is then inside the object and coordinates are small.
    const double depth = std::max(
        -(rotation * (space.to_world(local_origin_index.cast<double>()) - camera.eye_world)).z(),
        space.voxel_size_world());
    RayCoefficients ray;
    ray.depth_world = depth;
    ray.from_eye = index_from_view * view_point_coefficients(camera, width, height, depth);
    ray.point = ray.from_eye;
    ray.point.col(0) += eye_local(camera, space, local_origin_index);
    ray.vector = index_from_view * view_vector_coefficients(camera, width, height, depth);
    return ray;
}

Eigen::Matrix3f world_from_view(const FrameContext& frame) {
    return frame.camera.view_from_world_rotation().transpose().cast<float>();
}

Mat3d world_vector_coefficients(const Camera& camera, int width, int height, double depth_world) {
    return camera.view_from_world_rotation().transpose() *
           view_vector_coefficients(camera, width, height, depth_world);
}

Mat3d world_start_coefficients(const Camera& camera, int width, int height) {
    return camera.view_from_world_rotation().transpose() *
           (view_point_coefficients(camera, width, height, 1) -
            view_vector_coefficients(camera, width, height, 1));
}

Vec3d eye_local(const Camera& camera, const GridSpace& space, const Index3& local_origin_index) {
    return space.to_index(camera.eye_world) - local_origin_index.cast<double>();
}

gl::Format format_of(FrameImage image) {
    switch (image) {
    case FrameImage::SplatColour:
    case FrameImage::SolidTexture:
    case FrameImage::CurvatureColour:
    case FrameImage::CurvatureMap:
    case FrameImage::Accessibility:
    case FrameImage::Refraction:
    case FrameImage::Reflection:
    case FrameImage::Slice:
    case FrameImage::Beauty:
        return gl::Format::Rgba16f;
    case FrameImage::SplatSurface:
        return gl::Format::Rg32ui;
    case FrameImage::Bounds:
    case FrameImage::SlimNearest:
    case FrameImage::Shadow:
        return gl::Format::Rg32f;
    case FrameImage::Splat:
    case FrameImage::Steps:
    case FrameImage::ViewCurvature:
    case FrameImage::FlowLineCurvature:
    case FrameImage::ShadowMap:
    case FrameImage::Occlusion:
    case FrameImage::FlowNoise:
        return gl::Format::R32f;
    default:
        return gl::Format::Rgba32f;
    }
}

} // namespace isocast
