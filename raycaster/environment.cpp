// SPDX-License-Identifier: MPL-2.0
#include "raycaster/environment.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace isocast {

namespace {

constexpr unsigned environment_unit = 15; // of environment.glsl
// Texels from pole to pole; the built-in ones do not change around the axis. A step is then sharp
// to a tenth of a degree.
constexpr int builtin_height = 2048;

gl::Texture environment_texture(const Environment& environment) {
    if (environment.kind == Environment::Kind::Picture)
        return gl::Texture::picture(gl::Format::Rgba16f, environment.picture.width,
                                    environment.picture.height, bottom_up(environment.picture),
                                    gl::Wrap::RepeatX, "environment", gl::Levels::All);
    std::vector<float> texels;
    for (int y = 0; y < builtin_height; ++y) {
        constexpr int samples = 16; // of a texel: steps then lie where they should
        Vec3d colour = Vec3d::Zero();
        for (int i = 0; i < samples; ++i) {
            const double latitude =
                ((y + (i + 0.5) / samples) / builtin_height - 0.5) * std::numbers::pi;
            colour +=
                builtin_environment(environment, {0, std::sin(latitude), -std::cos(latitude)}) /
                samples;
        }
        for (const double c : {colour.x(), colour.y(), colour.z(), 1.0})
            texels.push_back(static_cast<float>(c));
    }
    return gl::Texture::picture(gl::Format::Rgba16f, 1, builtin_height, texels, gl::Wrap::RepeatX,
                                "environment", gl::Levels::All);
}

} // namespace

Vec3d builtin_environment(const Environment& environment, const Vec3d& direction_world) {
    const double latitude = std::asin(std::clamp(direction_world.y(), -1.0, 1.0));
    if (environment.kind == Environment::Kind::Stripes) {
        const double stripe = (latitude / std::numbers::pi + 0.5) * environment.stripes;
        return static_cast<int>(std::floor(stripe)) % 2 == 0 ? Vec3d(0.05, 0.06, 0.08)
                                                             : Vec3d(0.9, 0.9, 0.88);
    }
    const Vec3d zenith(0.10, 0.25, 0.62);
    const Vec3d horizon(0.85, 0.90, 0.95);
    const Vec3d ground(0.22, 0.20, 0.17);
    const double up = std::sin(latitude);
    if (up >= 0) return horizon + std::pow(up, 0.6) * (zenith - horizon);
    // 20: the horizon fades into the ground within a few degrees.
    return ground + std::exp(20 * up) * (horizon - ground);
}

void bind_environment(const FrameContext& frame) {
    const Environment& environment = frame.scene.look.environment;
    frame.look_textures.texture("environment", [&] { return environment_texture(environment); })
        .bind_to_unit(environment_unit);
}

} // namespace isocast
