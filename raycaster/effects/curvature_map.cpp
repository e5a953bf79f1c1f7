// SPDX-License-Identifier: MPL-2.0
#include "raycaster/effects/curvature_map.h"

#include "raycaster/effects/curvature_measure.h"
#include "raycaster/effects/effects.h"
#include "raycaster/effects/hit_statistics.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace isocast {

namespace {

constexpr int builtin_size = 129; // odd, so that (0, 0) is a texel

gl::ProgramKey map_program() {
    return {{"common/tiles.vert", "shading/curvature_map/curvature_map.frag"}, {}};
}

gl::Texture map_texture(const CurvatureMap& map) {
    if (!map.picture.rgba.empty())
        return gl::Texture::picture(gl::Format::Rgba16f, map.picture.width, map.picture.height,
                                    bottom_up(map.picture), gl::Wrap::Clamp, "curvature map");
    std::vector<float> texels;
    for (int y = 0; y < builtin_size; ++y)
        for (int x = 0; x < builtin_size; ++x) {
            const Vec3d colour = builtin_curvature_map((2 * x + 1.0) / builtin_size - 1,
                                                       (2 * y + 1.0) / builtin_size - 1);
            for (const double c : {colour.x(), colour.y(), colour.z(), 1.0})
                texels.push_back(static_cast<float>(c));
        }
    return gl::Texture::picture(gl::Format::Rgba16f, builtin_size, builtin_size, texels,
                                gl::Wrap::Clamp, "curvature map");
}

} // namespace

Vec3d builtin_curvature_map(double k1, double k2) {
    // By shape index, from -1 to 1.
    const std::array<Vec3d, 5> shapes{Vec3d(0.03, 0.08, 0.42),  // cup
                                      Vec3d(0.02, 0.42, 0.60),  // valley
                                      Vec3d(0.16, 0.50, 0.10),  // saddle
                                      Vec3d(0.95, 0.60, 0.05),  // ridge
                                      Vec3d(0.70, 0.06, 0.04)}; // cap
    const Vec3d flat(0.75, 0.75, 0.75);
    const double place =
        2 + 2 * curvature_measure(CurvatureMeasure::ShapeIndex, std::max(k1, k2), std::min(k1, k2));
    const std::size_t i = std::clamp(static_cast<int>(place), 0, 3);
    const Vec3d shape = shapes[i] + (place - double(i)) * (shapes[i + 1] - shapes[i]);
    // A root, since most of a surface is flatter than its extremes.
    return flat + std::sqrt(std::min(std::max(std::abs(k1), std::abs(k2)), 1.0)) * (shape - flat);
}

void run_curvature_map(FrameContext& frame) {
    const CurvatureMap& map = frame.scene.look.effects.curvature_map;
    double range = map.range.value_or(1);
    if (!map.range) {
        const auto found = percentile(frame, "curvature map", FrameImage::Curvature, 0.98,
                                      [](const float* k) -> std::optional<double> {
                                          if (k[3] == no_gradient) return {};
                                          return std::max(std::abs(k[0]), std::abs(k[1]));
                                      });
        if (found) range = std::max(*found, flat_curvature(frame));
        frame.notes.push_back(
            fmt::format("curvature map: curvatures from {:.4g} to {:.4g}", -range, range));
    }
    const gl::Program& program = frame.shaders.program(map_program());
    frame.targets.texture(FrameImage::Curvature).bind_to_unit(0);
    frame.look_textures.texture("curvature map", [&] { return map_texture(map); }).bind_to_unit(1);
    program.set("u_range", static_cast<float>(range));
    draw_tiles(frame, FrameImage::CurvatureMap, program, Eigen::Vector4f::Zero());
}

std::vector<gl::ProgramKey> curvature_map_programs() {
    return {map_program()};
}

} // namespace isocast
