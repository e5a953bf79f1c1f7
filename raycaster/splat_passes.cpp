// SPDX-License-Identifier: MPL-2.0
#include "raycaster/splat_passes.h"

#include "raycaster/field_passes.h"
#include "raycaster/slim_passes.h"
#include "raycaster/splat_study.h"

#include <fmt/format.h>
#include <glad/gl.h>

#include <algorithm>
#include <array>

namespace isocast {

namespace {

using Defines = std::map<std::string, std::string>;

constexpr unsigned normals_unit = 14; // of shaders/quadrics/triangle_normals.glsl

/// Of a splat: rectangles' two triangles share two.
constexpr int vertex_count(SplatKind kind) {
    return kind == SplatKind::Triangle ? 3 : 4;
}

/// kinds  by bits
Defines defines_of(unsigned kinds, bool is_perspective, const CutKind& cut, bool has_normals,
                   bool has_hessian) {
    Defines defines{{"IS_PERSPECTIVE", is_perspective ? "1" : "0"},
                    {"HAS_NORMALS", has_normals ? "1" : "0"},
                    {"HAS_HESSIAN", has_hessian ? "1" : "0"}};
    add_kind_defines(defines, kinds);
    add_cut_defines(defines, cut);
    return defines;
}

gl::ProgramKey resolve_program(Defines defines, bool has_fields, bool has_gradient,
                               bool has_colour) {
    defines.emplace("HAS_FIELDS", has_fields ? "1" : "0");
    defines.emplace("GRADIENT_AT", has_gradient ? "1" : "-1");
    defines.emplace("COLOUR_AT", has_colour ? (has_gradient ? "2" : "1") : "-1");
    return {{"common/tiles.vert", "quadrics/resolve.frag"}, std::move(defines)};
}

gl::ProgramKey derivatives_program(Defines defines, int order, const ImageSet& images) {
    defines.emplace("ORDER", std::to_string(order));
    if (order == 2) add_second_order_defines(defines, images);
    return {{"common/tiles.vert", "quadrics/derivatives.frag"}, std::move(defines)};
}

Defines defines_of(const FrameContext& frame, bool has_hessian) {
    unsigned kinds = 0;
    for (const SplatsOnGpu::OfKind& of_kind : frame.seen.splats->kinds)
        kinds |= 1U << static_cast<unsigned>(of_kind.kind);
    return defines_of(kinds, is_perspective(frame), cut_kind_of(frame),
                      has_normals(*frame.seen.splats), has_hessian);
}

/// Of shaders/quadrics/splat.glsl.
void set_ray_uniforms(const gl::Program& program, const FrameContext& frame) {
    set_cut_planes(program, frame, frame.camera.view_from_world_rotation());
    if (!program.has("u_pixel")) return; // flat triangles bend the same for any ray
    program.set("u_middle_pixel", Eigen::Vector2f(0.5F * static_cast<float>(frame.width),
                                                  0.5F * static_cast<float>(frame.height)));
    program.set("u_pixel", static_cast<float>(2 * frame.camera.half_height_at(1) / frame.height));
    set_first_pixel(frame, program);
}

/// What the splats' programs need of the scene, as far as each does.
void set_scene_uniforms(const gl::Program& program, const FrameContext& frame) {
    const PrimitivesOnGpu& of_scene = *frame.seen.splats->of_scene;
    if (has_normals(*frame.seen.splats))
        of_scene.triangle_normals.texture.bind_to_unit(normals_unit);
    if (program.has("u_to_half_colours"))
        program.set("u_to_half_colours", of_scene.to_half_colours);
    if (program.has("u_first_slim")) program.set("u_first_slim", of_scene.first_slim);
    if (program.has("u_world_from_view")) program.set("u_world_from_view", world_from_view(frame));
}

/// Of shaders/quadrics/splats.glsl.
void set_splat_uniforms(const gl::Program& program, const FrameContext& frame) {
    set_ray_uniforms(program, frame);
    frame.targets.texture(FrameImage::Splat).bind_to_unit(5);
    constexpr unsigned first_unit = 6;
    for (const SplatsOnGpu::OfKind& of_kind : frame.seen.splats->kinds) {
        const auto k = static_cast<unsigned>(of_kind.kind);
        if (of_kind.kind == SplatKind::Slim)
            bind_slim_hits(frame);
        else
            of_kind.records.texture.bind_to_unit(first_unit + k);
        program.set(fmt::format("u_slots[{}]", k).c_str(),
                    Eigen::Vector2i(of_kind.first_slot, of_kind.slot_count));
    }
    set_scene_uniforms(program, frame);
}

float owner_number(const FrameContext& frame) {
    return static_cast<float>(frame.seen.objects.size() + 1);
}

/// Those of this frame.
auto splat_programs_of(const FrameContext& frame, SplatOutput output) {
    return [&frame, output](SplatKind kind) {
        return splat_program(kind, is_perspective(frame), cut_kind_of(frame), output,
                             has_normals(*frame.seen.splats));
    };
}

} // namespace

gl::ProgramKey splat_program(SplatKind kind, bool is_perspective, const CutKind& cut,
                             SplatOutput output, bool has_normals) {
    const auto k = static_cast<std::size_t>(kind);
    const bool reads_normals = kind == SplatKind::Triangle && has_normals &&
                               (output == SplatOutput::Surface || output == SplatOutput::Colour);
    Defines defines{{"KIND", std::to_string(k)},
                    {"FLOATS4", std::to_string(splat_floats[k] / 4)},
                    {"PLACE4", std::to_string(place_floats(kind) / 4)}, // of the rectangle
                    {"VERTICES", std::to_string(vertex_count(kind))},
                    {"OUTPUT", std::to_string(static_cast<int>(output))},
                    {"HAS_NORMALS", reads_normals ? "1" : "0"},
                    {"BY_EQUATION_7", "0"},
                    {"ARE_STICKS", "0"},
                    {"IS_PERSPECTIVE", is_perspective ? "1" : "0"}};
    add_cut_defines(defines, cut);
    return {{"quadrics/splat.vert", "quadrics/splat.frag"}, std::move(defines)};
}

bool is_perspective(const FrameContext& frame) {
    return frame.camera.projection == Projection::Perspective;
}

bool has_normals(const SplatsOnGpu& splats) {
    return splats.of_scene->triangle_normals.buffer.byte_count() > 0 &&
           std::ranges::any_of(splats.kinds, [](const SplatsOnGpu::OfKind& of_kind) {
               return of_kind.kind == SplatKind::Triangle;
           });
}

void draw_splats(
    const FrameContext& frame, const std::function<gl::ProgramKey(SplatKind)>& program_of,
    const std::function<void(const gl::Program&, const SplatsOnGpu::OfKind&)>& prepare) {
    for (const SplatsOnGpu::OfKind& of_kind : frame.seen.splats->kinds)
        draw_splats_of_kind(frame, of_kind, program_of(of_kind.kind), prepare);
}

void draw_splats_of_kind(
    const FrameContext& frame, const SplatsOnGpu::OfKind& of_kind, gl::ProgramKey key,
    const std::function<void(const gl::Program&, const SplatsOnGpu::OfKind&)>& prepare) {
    if (frame.seen.splats->study.meets_spheres_by_equation_7 && of_kind.kind == SplatKind::Sphere)
        key.defines["BY_EQUATION_7"] = std::to_string(1);
    if (frame.seen.splats->of_scene->are_sticks && of_kind.kind == SplatKind::Cone)
        key.defines["ARE_STICKS"] = std::to_string(1);
    const gl::Program& program = frame.shaders.program(key);
    set_ray_uniforms(program, frame);
    if (program.has("u_view_from_window")) set_equation_7(program, frame);
    set_scene_uniforms(program, frame);
    program.set("u_clip_from_pixel", Eigen::Vector2f(2 / static_cast<float>(frame.part.width),
                                                     2 / static_cast<float>(frame.part.height)));
    prepare(program, of_kind);
    of_kind.records.texture.bind_to_unit(0);
    program.use();
    if (vertex_count(of_kind.kind) == 3) {
        frame.no_vertices.bind();
        glDrawArrays(GL_TRIANGLES, 0, 3 * of_kind.count);
        return;
    }
    const RectanglesOnGpu& rectangles = frame.seen.splats->of_scene->rectangles;
    rectangles.array.bind();
    for (int first = 0; first < of_kind.count; first += rectangles.count)
        glDrawElementsBaseVertex(GL_TRIANGLES,
                                 6 * std::min(rectangles.count, of_kind.count - first),
                                 GL_UNSIGNED_SHORT, nullptr, 4 * first);
}

float depth_unit_of(const FrameContext& frame) {
    return static_cast<float>(1e-20 * extent_diagonal_world(frame));
}

CutKind cut_kind_of(const FrameContext& frame) {
    return {frame.seen.splats->planes.size(), frame.scene.cut.look};
}

void add_cut_defines(std::map<std::string, std::string>& defines, const CutKind& cut) {
    defines.emplace("CUT_PLANES", std::to_string(cut.planes));
    defines.emplace("CUT_LOOK", std::to_string(cut.planes == 0 ? 0 : static_cast<int>(cut.look)));
}

void add_kind_defines(std::map<std::string, std::string>& defines, unsigned kinds) {
    for (unsigned k = 0; k < splat_kind_count; ++k)
        defines.emplace(fmt::format("HAS_{}", k), (kinds >> k & 1) != 0 ? "1" : "0");
}

void set_cut_planes(const gl::Program& program, const FrameContext& frame,
                    const Mat3d& axes_from_world) {
    // Not of what bends the same wherever it is hit.
    if (!program.has("u_cut_planes[0]")) return;
    for (std::size_t i = 0; i < frame.seen.splats->planes.size(); ++i) {
        const CutPlane& plane = frame.seen.splats->planes[i];
        const Vec3d normal = axes_from_world * plane.normal;
        const double offset = plane.offset_world - plane.normal.dot(frame.camera.eye_world);
        program.set(fmt::format("u_cut_planes[{}]", i).c_str(),
                    Eigen::Vector4f(
                        Eigen::Vector4d(normal.x(), normal.y(), normal.z(), offset).cast<float>()));
    }
}

void draw_nearest_splats(
    FrameContext& frame, FrameImage image, const Eigen::Vector4f& none,
    const std::function<gl::ProgramKey(SplatKind)>& program_of,
    const std::function<void(const gl::Program&, const SplatsOnGpu::OfKind&)>& prepare,
    const std::function<void(double depth_unit)>& draw_more) {
    const gl::Texture depth = gl::Texture::image(gl::Format::Depth32f, frame.part.width,
                                                 frame.part.height, "depth of splats");
    frame.scratch_bytes += depth.byte_count();
    const gl::Framebuffer target({&frame.targets.texture(image)}, "nearest splats", &depth);
    target.bind();
    const float infinitely_far = 0;
    if (image == FrameImage::SplatSurface)
        glClearBufferuiv(GL_COLOR, 0, std::array<GLuint, 4>{}.data());
    else
        glClearBufferfv(GL_COLOR, 0, none.data());
    glClearBufferfv(GL_DEPTH, 0, &infinitely_far);
    set_fixed_state();
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_GREATER);
    const float depth_unit = depth_unit_of(frame);
    for (const SplatsOnGpu::OfKind& of_kind : frame.seen.splats->kinds)
        if (of_kind.kind != SplatKind::Slim)
            draw_splats_of_kind(frame, of_kind, program_of(of_kind.kind),
                                [&](const gl::Program& program, const SplatsOnGpu::OfKind& some) {
                                    program.set("u_depth_unit", depth_unit);
                                    prepare(program, some);
                                });
    if (draw_more) draw_more(depth_unit);
    glDisable(GL_DEPTH_TEST);
}

void run_splats(FrameContext& frame) {
    draw_nearest_splats(
        frame, FrameImage::Splat, Eigen::Vector4f::Zero(),
        splat_programs_of(frame, SplatOutput::Number),
        [&](const gl::Program& program, const SplatsOnGpu::OfKind& of_kind) {
            program.set("u_first_slot", of_kind.first_slot);
        },
        [&](double unit) { draw_slim_hits(frame, SplatOutput::Number, unit); });
}

void run_splat_surfaces(FrameContext& frame) {
    draw_nearest_splats(
        frame, FrameImage::SplatSurface, Eigen::Vector4f::Zero(),
        splat_programs_of(frame, SplatOutput::Surface),
        [](const gl::Program&, const SplatsOnGpu::OfKind&) {},
        [&](double unit) { draw_slim_hits(frame, SplatOutput::Surface, unit); });
}

void draw_splat_distances(const FrameContext& frame, double unit_world) {
    set_fixed_state();
    glEnable(GL_BLEND);
    glBlendEquation(GL_MIN);
    draw_splats(frame, splat_programs_of(frame, SplatOutput::Distance),
                [&](const gl::Program& program, const SplatsOnGpu::OfKind&) {
                    program.set("u_units_per_world", static_cast<float>(1 / unit_world));
                });
    glBlendEquation(GL_FUNC_ADD);
    glDisable(GL_BLEND);
}

void resolve_splats(FrameContext& frame) {
    const SplatsOnGpu& splats = *frame.seen.splats;
    const bool has_fields = !frame.seen.objects.empty();
    const bool has_gradient = frame.has_fused_gradient;
    const bool has_colour = frame.live.contains(FrameImage::SplatColour);
    std::vector<const gl::Texture*> targets{&frame.targets.texture(FrameImage::Hit)};
    if (has_gradient) targets.push_back(&frame.targets.texture(FrameImage::Gradient));
    if (has_colour) targets.push_back(&frame.targets.texture(FrameImage::SplatColour));
    const gl::Framebuffer target(targets, "hits of splats");
    target.bind();
    const Eigen::Vector4f none = Eigen::Vector4f::Zero();
    if (!has_fields) {
        glClearBufferfv(GL_COLOR, 0, none.data());
        if (has_gradient) glClearBufferfv(GL_COLOR, 1, none.data());
    }
    if (has_colour) glClearBufferfv(GL_COLOR, has_gradient ? 2 : 1, none.data());
    if (splats.kinds.empty()) return;
    const gl::Program& program = frame.shaders.program(
        resolve_program(defines_of(frame, false), has_fields, has_gradient, has_colour));
    set_splat_uniforms(program, frame);
    program.set("u_object", owner_number(frame));
    if (has_fields) {
        frame.targets.texture(FrameImage::Hit).bind_to_unit(0);
        glTextureBarrier();
    }
    if (has_colour) splats.of_scene->colours.texture.bind_to_unit(4);
    draw_on_tiles(frame, program);
}

void draw_splat_derivatives(FrameContext& frame, int order, const gl::Framebuffer& target) {
    const SplatsOnGpu& splats = *frame.seen.splats;
    if (splats.kinds.empty()) return;
    std::optional<SlimBends> bends;
    if (order == 2 && splats.slim() != nullptr) bends.emplace(frame);
    target.bind();
    set_fixed_state();
    if (bends)
        for (unsigned i = 0; i < 2; ++i) bends->textures[i].bind_to_unit(2 + i);
    const gl::Program& program = frame.shaders.program(
        derivatives_program(defines_of(frame, order == 2), order, frame.live));
    set_splat_uniforms(program, frame);
    frame.targets.texture(FrameImage::Hit).bind_to_unit(0);
    program.set("u_object", owner_number(frame));
    if (order == 2 && frame.live.contains(FrameImage::ViewCurvature))
        program.set(
            "u_ray_vector_world",
            Eigen::Matrix3f(
                world_vector_coefficients(frame.camera, frame.width, frame.height).cast<float>()));
    draw_on_tiles(frame, program);
}

std::vector<gl::ProgramKey> splat_programs() {
    std::vector<gl::ProgramKey> keys = splat_study_programs();
    for (const gl::ProgramKey& key : slim_programs()) keys.push_back(key);
    for (const bool is_perspective : {false, true}) {
        for (int k = 0; k < splat_kind_count; ++k) {
            const auto kind = static_cast<SplatKind>(k);
            for (const SplatOutput output :
                 {SplatOutput::Number, SplatOutput::Distance, SplatOutput::Surface}) {
                if (kind == SplatKind::Slim && output != SplatOutput::Distance) continue;
                keys.push_back(splat_program(kind, is_perspective, {}, output));
                for (const CutLook look : {CutLook::Inside, CutLook::Flat, CutLook::Capped})
                    keys.push_back(splat_program(kind, is_perspective, {2, look}, output, true));
                if (kind != SplatKind::Cone) continue;
                keys.push_back(splat_program(kind, is_perspective, {}, output));
                keys.back().defines["ARE_STICKS"] = std::to_string(1);
            }
        }
        for (const CutLook look : {CutLook::Inside, CutLook::Flat, CutLook::Capped})
            keys.push_back(
                resolve_program(defines_of(all_splat_kinds, is_perspective, {1, look}, true, false),
                                true, true, true));
        // Kinds add code, each its own: each alone and all together.
        for (const auto& [kinds, has_normals] : {std::pair{1U, false},
                                                 {2U, false},
                                                 {4U, false},
                                                 {8U, false},
                                                 {16U, false},
                                                 {32U, false},
                                                 {32U, true},
                                                 {64U, false},
                                                 {128U, false},
                                                 {256U, false},
                                                 {all_splat_kinds, true}}) {
            const auto defines = [&, kinds = kinds, has_normals = has_normals](bool has_hessian) {
                return defines_of(kinds, is_perspective, {}, has_normals, has_hessian);
            };
            for (const bool has_fields : {false, true})
                for (const bool has_gradient : {false, true})
                    for (const bool has_colour : {false, true})
                        keys.push_back(
                            resolve_program(defines(false), has_fields, has_gradient, has_colour));
            keys.push_back(derivatives_program(defines(false), 1, {}));
            for (const FrameImage image :
                 {FrameImage::Curvature, FrameImage::Direction, FrameImage::ViewCurvature,
                  FrameImage::FlowLineCurvature})
                keys.push_back(derivatives_program(defines(true), 2, {image}));
        }
    }
    return keys;
}

} // namespace isocast
