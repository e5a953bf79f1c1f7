// The passes that read the field: hits, gradients, curvatures.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "raycaster/frame.h"

namespace isocast {

/// Whether the pass "raycast" can write gradients too: with all bricks at hand, of one filter, and
/// pixels that are drawn once.
bool can_fuse_gradient(const FrameContext& frame);

void run_bounds(FrameContext& frame);
/// The frame's hits: of fields, composed or one, and of primitives.
void run_hits(FrameContext& frame);
/// The Hit image of a frame that has no passes of its own, and those of `derived` that follow from
/// the field's derivatives; makes the images that this takes.
void cast_rays(FrameContext& frame, const ImageSet& derived = {});
/// The image whose pass draws `image` too, because it fetches the same: another one, or itself.
FrameImage drawn_with(const FrameContext& frame, FrameImage image);
// Of composed objects each one's, where it is hit.
void run_gradient(FrameContext& frame);
/// Whether the image follows from the Hessian: Curvature, Direction, ViewCurvature,
/// FlowLineCurvature.
bool is_of_second_order(FrameImage image);
/// The first live one draws all live ones.
void run_second_order(FrameContext& frame, FrameImage image);

/// Binds and sets what raycast/raycast.frag needs of the frame's object.
/// returns  the rays, as set
RayCoefficients set_search_uniforms(const gl::Program& program, const FrameContext& frame);
/// raycast/raycast.frag for an object of several, and rays from the camera.
gl::ProgramKey operand_program(const FrameContext& frame);
/// The same for rays from hits to the sky.
gl::ProgramKey sky_operand_program(std::map<std::string, std::string> pool_defines);
/// If it counts steps, before its first draw: from 0. Draws that add to the same pixels need
/// glMemoryBarrier(GL_SHADER_IMAGE_ACCESS_BARRIER_BIT) between them.
void start_counting_steps(const FrameContext& frame);

/// Of shaders that go from hits to the field.
void set_hit_uniforms(const gl::Program& program, const FrameContext& frame,
                      const FieldOnGpu& field);
/// Where rays end: beyond its extent a field with a band goes on as background, one without ends.
void set_extent_uniforms(const gl::Program& program, const FrameContext& frame);
/// Of shaders/raycast/march.glsl.
void set_accuracy_uniforms(const gl::Program& program, const FrameContext& frame);

/// Of shaders/filtering/second_order.glsl: where it writes which of `images`.
void add_second_order_defines(std::map<std::string, std::string>& defines, const ImageSet& images);

/// Every program that these can ask for, up to its strides.
std::vector<gl::ProgramKey> field_programs();
/// The defines of every kind of pool, up to its strides, with the field's kernel.
std::vector<std::map<std::string, std::string>> all_pool_defines();

} // namespace isocast
