// The passes that draw primitives: which one a pixel shows, where it is hit, and how it bends.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "raycaster/frame.h"

namespace isocast {

/// FrameImage::Splat, of what no field hides: order-independent, by depth.
void run_splats(FrameContext& frame);
/// FrameImage::SplatSurface, as that: for scenes of primitives alone, in which nothing but shading
/// looks at hits.
void run_splat_surfaces(FrameContext& frame);
/// Into the bound framebuffer of one float: distances along the view where they are less than what
/// is there.
void draw_splat_distances(const FrameContext& frame, double unit_world);
/// Puts the splats' hits among those of the fields; the nearer wins. Colours with them where they
/// are asked for, and normals where the frame's gradients are drawn with hits.
void resolve_splats(FrameContext& frame);
/// Where splats are hit: normals (order 1), or what the live passes of second order ask for (order
/// 2).
void draw_splat_derivatives(FrameContext& frame, int order, const gl::Framebuffer& target);

/// Of shaders/quadrics/cut.glsl.
struct CutKind {
    std::size_t planes = 0;
    CutLook look = CutLook::Inside;
};
CutKind cut_kind_of(const FrameContext& frame);
void add_cut_defines(std::map<std::string, std::string>& defines, const CutKind& cut);
/// HAS_0 ... of shaders; kinds by bits.
void add_kind_defines(std::map<std::string, std::string>& defines, unsigned kinds);
/// Of rays in such axes, from the eye.
void set_cut_planes(const gl::Program& program, const FrameContext& frame,
                    const Mat3d& axes_from_world);

/// What is written of a splat's hit.
enum class SplatOutput {
    Number,   // of the splat + 1
    Distance, // along the view
    Surface,  // as FrameImage::SplatSurface
    Colour,   // lit
};
/// has_normals  whether triangles have some at corners; of surfaces and colours
gl::ProgramKey splat_program(SplatKind kind, bool is_perspective, const CutKind& cut,
                             SplatOutput output = SplatOutput::Number, bool has_normals = false);
bool is_perspective(const FrameContext& frame);
/// Whether triangles have normals at their corners.
bool has_normals(const SplatsOnGpu& splats);
/// Draws the splats of each kind into the bound framebuffer.
///
/// program_of  (kind): with shaders/quadrics/splat.vert
/// prepare     (program, those of its kind): sets what else it needs
void draw_splats(
    const FrameContext& frame, const std::function<gl::ProgramKey(SplatKind)>& program_of,
    const std::function<void(const gl::Program&, const SplatsOnGpu::OfKind&)>& prepare);
/// Those of one kind.
void draw_splats_of_kind(
    const FrameContext& frame, const SplatsOnGpu::OfKind& of_kind, gl::ProgramKey key,
    const std::function<void(const gl::Program&, const SplatsOnGpu::OfKind&)>& prepare);
/// Only what is nearer than 1e-20 of the scene's size is clamped.
float depth_unit_of(const FrameContext& frame);
/// Draws splats into an image of the frame, the nearest of all, but for SLIM surfaces.
///
/// none  where there are no splats; integers are 0 there
void draw_nearest_splats(
    FrameContext& frame, FrameImage image, const Eigen::Vector4f& none,
    const std::function<gl::ProgramKey(SplatKind)>& program_of,
    const std::function<void(const gl::Program&, const SplatsOnGpu::OfKind&)>& prepare,
    const std::function<void(double depth_unit)>& draw_more = {}); // by the same depths

/// Every program that these can ask for.
std::vector<gl::ProgramKey> splat_programs();

} // namespace isocast
