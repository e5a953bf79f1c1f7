// SPDX-License-Identifier: MPL-2.0
#include "raycaster/slim_passes.h"

#include <glad/gl.h>

namespace isocast {

namespace {

constexpr unsigned nearest_unit = 15; // of shaders/quadrics/splats.glsl and slim_splat.frag

/// What shaders/quadrics/slim.frag writes of a piece.
enum class SlimOutput { Nearest, Blend, Bends };

gl::ProgramKey piece_program(bool is_perspective, const CutKind& cut, SlimOutput output,
                             bool is_front_only) {
    gl::ProgramKey key =
        splat_program(SplatKind::Slim, is_perspective, cut, SplatOutput::Surface); // with numbers
    key.entry_points.back() = "quadrics/slim.frag";
    key.defines["STAGE"] = std::to_string(static_cast<int>(output));
    key.defines["FRONT_ONLY"] = std::to_string(is_front_only ? 1 : 0);
    return key;
}

gl::ProgramKey splat_program_of_hits(SplatOutput output) {
    return {{"common/tiles.vert", "quadrics/slim_splat.frag"},
            {{"OUTPUT", std::to_string(static_cast<int>(output))}}};
}

void draw_pieces(const FrameContext& frame, SlimOutput output,
                 const std::function<void(const gl::Program&)>& prepare) {
    const SplatsOnGpu::OfKind* pieces = frame.seen.splats->slim();
    if (pieces == nullptr) return;
    draw_splats_of_kind(
        frame, *pieces,
        piece_program(is_perspective(frame), cut_kind_of(frame), output,
                      !frame.seen.splats->shows_slims_inside),
        [&](const gl::Program& program, const SplatsOnGpu::OfKind&) { prepare(program); });
}

/// Sums over the pieces of the sheet that shows.
void blend_pieces(const FrameContext& frame, SlimOutput output, const gl::Framebuffer& target) {
    const int target_count = output == SlimOutput::Bends ? 2 : 1;
    target.bind();
    const std::array<float, 4> nothing{};
    for (int i = 0; i < target_count; ++i) glClearBufferfv(GL_COLOR, i, nothing.data());
    set_fixed_state();
    glEnable(GL_BLEND);
    glBlendEquation(GL_FUNC_ADD);
    glBlendFunc(GL_ONE, GL_ONE);
    frame.targets.texture(FrameImage::SlimNearest).bind_to_unit(1);
    draw_pieces(frame, output, [](const gl::Program&) {});
    glDisable(GL_BLEND);
}

gl::Texture scratch(FrameContext& frame, gl::Format format) {
    gl::Texture texture =
        gl::Texture::image(format, frame.part.width, frame.part.height, "blended pieces");
    frame.scratch_bytes += texture.byte_count();
    return texture;
}

} // namespace

bool has_slims(const FrameContext& frame) {
    return frame.seen.splats && !frame.scene.primitives->slims.empty();
}

void run_slim_nearest(FrameContext& frame) {
    const gl::Texture depth = scratch(frame, gl::Format::Depth32f);
    const gl::Framebuffer target({&frame.targets.texture(FrameImage::SlimNearest)},
                                 "nearest pieces", &depth);
    target.bind();
    const std::array<float, 4> nothing{};
    const float infinitely_far = 0;
    glClearBufferfv(GL_COLOR, 0, nothing.data());
    glClearBufferfv(GL_DEPTH, 0, &infinitely_far);
    set_fixed_state();
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_GREATER);
    draw_pieces(frame, SlimOutput::Nearest, [&](const gl::Program& program) {
        program.set("u_depth_unit", depth_unit_of(frame));
    });
    glDisable(GL_DEPTH_TEST);
}

void run_slim_hits(FrameContext& frame) {
    blend_pieces(frame, SlimOutput::Blend, frame.targets.framebuffer(FrameImage::SlimHit));
}

void bind_slim_hits(const FrameContext& frame) {
    frame.targets.texture(FrameImage::SlimNearest).bind_to_unit(nearest_unit);
    frame.targets.texture(FrameImage::SlimHit).bind_to_unit(1);
}

void draw_slim_hits(const FrameContext& frame, SplatOutput output, double depth_unit) {
    const SplatsOnGpu::OfKind* pieces = frame.seen.splats->slim();
    if (pieces == nullptr) return;
    const gl::Program& program = frame.shaders.program(splat_program_of_hits(output));
    bind_slim_hits(frame);
    program.set("u_depth_unit", static_cast<float>(depth_unit));
    if (output == SplatOutput::Number)
        program.set("u_to_slot", static_cast<float>(pieces->first_slot -
                                                    frame.seen.splats->of_scene->first_slim));
    draw_on_tiles_by_depth(frame, program);
}

SlimBends::SlimBends(FrameContext& frame)
    : textures{scratch(frame, gl::Format::Rgba32f), scratch(frame, gl::Format::Rgba32f)} {
    blend_pieces(frame, SlimOutput::Bends, gl::Framebuffer({&textures[0], &textures[1]}, "bends"));
}

std::vector<gl::ProgramKey> slim_programs() {
    std::vector<gl::ProgramKey> keys{splat_program_of_hits(SplatOutput::Number),
                                     splat_program_of_hits(SplatOutput::Surface)};
    for (const bool is_perspective : {false, true})
        for (const SlimOutput output :
             {SlimOutput::Nearest, SlimOutput::Blend, SlimOutput::Bends}) {
            for (const bool is_front_only : {false, true})
                keys.push_back(piece_program(is_perspective, {}, output, is_front_only));
            for (const CutLook look : {CutLook::Inside, CutLook::Flat, CutLook::Capped})
                keys.push_back(piece_program(is_perspective, {2, look}, output, false));
        }
    return keys;
}

} // namespace isocast
