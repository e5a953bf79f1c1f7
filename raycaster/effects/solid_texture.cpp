// SPDX-License-Identifier: MPL-2.0
#include "raycaster/effects/effects.h"
#include "raycaster/effects/hit_statistics.h"

#include <cmath>

namespace isocast {

namespace {

gl::ProgramKey texture_program(SolidTexture::Kind kind, bool is_bspline) {
    gl::ProgramKey key{{"common/tiles.vert", "shading/solid_texture/solid_texture.frag"},
                       {{"KIND", std::to_string(static_cast<int>(kind))}}};
    if (kind == SolidTexture::Kind::Volume) key.defines.emplace("KERNEL", is_bspline ? "1" : "0");
    return key;
}

gl::Texture volume_texture(const FieldSource& volume) {
    const IndexBox extent = volume.extent();
    const Index3 size = extent.size();
    // Halves: a 2048th of the way between two colours.
    gl::Texture texture = gl::Texture::volume(gl::Format::R16f, size.x(), size.y(), size.z(),
                                              gl::Filter::Linear, "solid texture");
    IndexBox plane = extent;
    std::vector<float> samples(std::size_t(size.x()) * std::size_t(size.y()));
    std::vector<Eigen::half> halves(samples.size());
    for (int z = 0; z < size.z(); ++z) {
        plane.lo.z() = extent.lo.z() + z;
        plane.hi.z() = plane.lo.z() + 1;
        volume.copy_box(plane, 0, samples);
        for (std::size_t i = 0; i < samples.size(); ++i) halves[i] = Eigen::half(samples[i]);
        texture.upload_box(0, 0, z, size.x(), size.y(), 1, std::as_bytes(std::span(halves)));
    }
    return texture;
}

/// Sets texture = linear * (p_world - eye) + offset.
void set_map(const gl::Program& program, const Mat3d& linear, const Vec3d& offset) {
    program.set("u_texture_from_world", Eigen::Matrix3f(linear.cast<float>()));
    program.set("u_offset", Eigen::Vector3f(offset.cast<float>()));
}

void set_volume(const gl::Program& program, FrameContext& frame, const SolidTexture& texture) {
    const FieldSource& volume = *texture.volume;
    frame.targets.texture(FrameImage::Hit).bind_to_unit(0);
    frame.look_textures.texture("solid texture", [&] { return volume_texture(volume); })
        .bind_to_unit(2);
    set_map(program, volume.space().world_from_index.linear().inverse(),
            volume.space().to_index(frame.camera.eye_world) - volume.extent().lo.cast<double>());
}

void set_procedural(const gl::Program& program, const FrameContext& frame,
                    const SolidTexture& texture) {
    const Vec3d axis = texture.axis.normalized();
    const Vec3d across = axis.unitOrthogonal(); // along world axes if the axis is
    Mat3d linear;
    linear << across.transpose(), axis.cross(across).transpose(), axis.transpose();
    // A twelfth: some ten periods across the object.
    linear /= texture.scale_world.value_or(extent_diagonal_world(frame) / 12);
    const Vec3d eye = linear * (frame.camera.eye_world - texture.origin_world);
    // Of all that is drawn: the noise's 256, stretched by four along a trunk.
    constexpr double period = 1024;
    set_map(program, linear, eye - period * (eye / period).array().round().matrix());
    if (texture.kind == SolidTexture::Kind::Wood) {
        const double radius = eye.head<2>().norm();
        program.set("u_eye_to_rings", Eigen::Vector4f(float(eye.x()), float(eye.y()), float(radius),
                                                      float(radius - std::floor(radius))));
    }
    set_surface_uniforms(program, frame);
    const Mat3d world_from_view = frame.camera.view_from_world_rotation().transpose();
    program.set("u_view_axes", Eigen::Matrix3f(world_from_view.cast<float>()));
    const double at_eye = 2 * frame.camera.half_height_at(0) / frame.height;
    const double at_one = 2 * frame.camera.half_height_at(1) / frame.height;
    program.set("u_pixel", Eigen::Vector2f(float(at_eye), float(at_one - at_eye)));
}

} // namespace

ImageSet solid_texture_reads(const SolidTexture& texture) {
    ImageSet reads{FrameImage::Hit};
    if (texture.kind != SolidTexture::Kind::Volume) reads.insert(FrameImage::Gradient);
    return reads;
}

void run_solid_texture(FrameContext& frame) {
    const SolidTexture& texture = frame.scene.look.effects.solid_texture;
    const gl::Program& program =
        frame.shaders.program(texture_program(texture.kind, texture.volume_filter == "bspline"));
    if (texture.kind == SolidTexture::Kind::Volume)
        set_volume(program, frame, texture);
    else
        set_procedural(program, frame, texture);
    program.set("u_colour_a", Eigen::Vector3f(texture.colour_a.cast<float>()));
    program.set("u_colour_b", Eigen::Vector3f(texture.colour_b.cast<float>()));
    draw_tiles(frame, FrameImage::SolidTexture, program, Eigen::Vector4f::Zero());
}

std::vector<gl::ProgramKey> solid_texture_programs() {
    using Kind = SolidTexture::Kind;
    return {texture_program(Kind::Checker, false), texture_program(Kind::Stripes, false),
            texture_program(Kind::Marble, false),  texture_program(Kind::Wood, false),
            texture_program(Kind::Volume, false),  texture_program(Kind::Volume, true)};
}

} // namespace isocast
