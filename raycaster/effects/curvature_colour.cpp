// SPDX-License-Identifier: MPL-2.0
#include "raycaster/effects/colour_maps.h"
#include "raycaster/effects/curvature_measure.h"
#include "raycaster/effects/effects.h"
#include "raycaster/effects/hit_statistics.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace isocast {

namespace {

using Range = std::array<double, 2>;

constexpr int map_texels = 257; // odd, so that the middle is one

gl::ProgramKey colour_program(CurvatureMeasure measure) {
    return {{"common/tiles.vert", "shading/curvature_colour/curvature_colour.frag"},
            {{"MEASURE", std::to_string(static_cast<int>(measure))}}};
}

gl::Texture map_texture(ColourMap map) {
    std::vector<float> texels;
    for (int i = 0; i < map_texels; ++i) {
        const Vec3d colour = colour_of(map, double(i) / (map_texels - 1));
        for (const double c : {colour.x(), colour.y(), colour.z(), 1.0})
            texels.push_back(static_cast<float>(c));
    }
    return gl::Texture::picture(gl::Format::Rgba32f, map_texels, 1, texels, gl::Wrap::Clamp,
                                "colour map");
}

/// Of the picture: 2 % at either end are left out.
Range range_of(FrameContext& frame, const CurvatureColour& colour, ColourMap map) {
    if (colour.range) return *colour.range;
    if (colour.measure == CurvatureMeasure::ShapeIndex) return {-1, 1};
    const bool is_symmetric = map == ColourMap::CoolWarm;
    const auto percentile_of_measure = [&](double share) {
        return percentile(frame,
                          fmt::format("curvature colour {} {} {}", name_of(colour.measure),
                                      is_symmetric ? "sizes" : "values", share),
                          FrameImage::Curvature, share,
                          [&](const float* k) -> std::optional<double> {
                              if (k[3] == no_gradient) return {};
                              const double value = curvature_measure(colour.measure, k[0], k[1]);
                              return is_symmetric ? std::abs(value) : value;
                          });
    };
    const auto low_found = percentile_of_measure(0.02);
    const auto high_found = percentile_of_measure(0.98);
    if (!low_found || !high_found) return {-1, 1}; // nothing is drawn
    const double flat = flat_curvature(frame);
    const double least = colour.measure == CurvatureMeasure::Gauss ? flat * flat : flat;
    const double low = *low_found;
    const double high = *high_found;
    if (is_symmetric) return {-std::max(high, least), std::max(high, least)};
    // A tenth: what varies less is one curvature to the eye, and its variation mostly an error.
    const double width =
        std::max({high - low, 0.1 * std::max(std::abs(low), std::abs(high)), least});
    return {(low + high - width) / 2, (low + high + width) / 2};
}

} // namespace

void run_curvature_colour(FrameContext& frame) {
    const CurvatureColour& colour = frame.scene.look.effects.curvature_colour;
    const ColourMap map = colour.map.value_or(default_colour_map(colour.measure));
    const auto [low, high] = range_of(frame, colour, map);
    if (!colour.range)
        frame.notes.push_back(fmt::format("curvature colour: {} from {:.4g} to {:.4g}",
                                          name_of(colour.measure), low, high));
    const gl::Program& program = frame.shaders.program(colour_program(colour.measure));
    frame.targets.texture(FrameImage::Curvature).bind_to_unit(0);
    frame.look_textures.texture("colour map", [&] { return map_texture(map); }).bind_to_unit(1);
    program.set("u_range", Eigen::Vector2f(float(low), float(high)));
    draw_tiles(frame, FrameImage::CurvatureColour, program, Eigen::Vector4f::Zero());
}

std::vector<gl::ProgramKey> curvature_colour_programs() {
    std::vector<gl::ProgramKey> keys;
    for (int measure = 0; measure < 6; ++measure)
        keys.push_back(colour_program(static_cast<CurvatureMeasure>(measure)));
    return keys;
}

} // namespace isocast
