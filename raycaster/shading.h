// From hits, normals and what effects made to the picture.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "raycaster/frame.h"

namespace isocast {

/// What shading does with an effect's image.
enum class Blend {
    SurfaceColour, // before light: colours are mixed by coverage
    SurfaceFactor, // then r times the colour, by coverage
    AmbientLight,  // r times the ambient light
    DirectLight,   // r times the light that casts shadows
    Overlay,       // after light: colours are mixed by coverage
};

/// How an effect enters the picture. Shading knows no more of it.
struct Layer {
    FrameImage image;
    Blend blend;
    double strength;                  // in [0, 1]; 0: shading does not read the image
    bool reaches_beyond_hits = false; // by a pixel
};

/// Those of every effect there is, in the order in which they are applied.
std::vector<Layer> layers_of(const Look& look);

/// The light that casts shadows, or none.
const Light* casting_light(const Look& look);

/// The images that shading reads; where no tile shows the surface, none that effects make.
ImageSet shading_reads(const FrameContext& frame);

/// Those of the look; of none a black one, so that shaders need no case of their own.
std::vector<Light> lights_of(const Look& look);

/// Of shaders/shading/lights.glsl.
void set_lights(const gl::Program& program, const FrameContext& frame);
void run_shading(FrameContext& frame);

/// Programs for `layers` of each kind and lights, for the test that compiles them.
std::vector<gl::ProgramKey> shading_programs();

} // namespace isocast
