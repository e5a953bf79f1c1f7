// The effects that a look can ask for: each is a pass that makes one image.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "raycaster/frame.h"
#include "raycaster/shown_surfaces.h"

namespace isocast {

void run_contours(FrameContext& frame);
void run_ridges(FrameContext& frame);
void run_uncertainty(FrameContext& frame);
/// Normals and depths in the form that outlines are found in.
void run_outline_source(FrameContext& frame);
void run_outlines(FrameContext& frame);

std::vector<gl::ProgramKey> contours_programs();
std::vector<gl::ProgramKey> ridges_programs();
std::vector<gl::ProgramKey> uncertainty_programs();
std::vector<gl::ProgramKey> outlines_programs();
void run_solid_texture(FrameContext& frame);
void run_curvature_colour(FrameContext& frame);
void run_curvature_map(FrameContext& frame);
void run_accessibility(FrameContext& frame);
void run_refraction(FrameContext& frame);
void run_reflection(FrameContext& frame);

/// Of solid textures, curvatures as colours, accessibility and refraction.
/// throws  InputError for numbers out of their range, and for a solid texture without its volume,
///         with one that fits no texture, or with an unknown filter
void check_colour_effects(const Effects& effects);

/// The images that a solid texture reads: what filters by the pixel's footprint needs normals.
ImageSet solid_texture_reads(const SolidTexture& texture);

/// The field of the first object where a plane meets it.
void run_slice(FrameContext& frame);
std::vector<gl::ProgramKey> slice_programs();
/// throws  InputError where there is no such field, as in octrees; for numbers out of their range
void check_slice(const Slice& slice, std::span<const FieldObject> objects);
/// Between its lines, and from iso to the full tones.
double slice_spacing_world(const Slice& slice, const FieldSource& field);
double slice_range_world(const Slice& slice, const FieldSource& field);
/// Its tone at iso, linear RGB.
inline Vec3d slice_paper() {
    return Vec3d::Constant(0.92);
}

/// Binds the hits and their gradients, and sets the rays, of shaders/shading/surface.glsl.
void set_surface_uniforms(const gl::Program& program, const FrameContext& frame);

// The programs that each can ask for.
std::vector<gl::ProgramKey> solid_texture_programs();
std::vector<gl::ProgramKey> curvature_colour_programs();
std::vector<gl::ProgramKey> curvature_map_programs();
std::vector<gl::ProgramKey> accessibility_programs();
std::vector<gl::ProgramKey> refraction_programs();
std::vector<gl::ProgramKey> reflection_programs();

} // namespace isocast
