// SPDX-License-Identifier: MPL-2.0
#include "raycaster/environment.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace isocast {

namespace {

constexpr unsigned environment_unit = 15; // of environment.glsl
constexpr int builtin_width = 1024; // texels around; stripes are then sharp to a third of a degree

/// The rows of an image from the bottom up.
std::vector<float> bottom_up(const Image& image) {
    std::vector<float> texels;
    texels.reserve(image.rgba.size());
    for (int y = image.height - 1; y >= 0; --y)
        texels.insert(texels.end(), image.pixel(0, y), image.pixel(0, y) + 4 * image.width);
    return texels;
}

gl::Texture environment_texture(const Environment& environment) {
    if (environment.kind == Environment::Kind::Picture)
        return gl::Texture::picture(gl::Format::Rgba16f, environment.picture.width,
                                    environment.picture.height, bottom_up(environment.picture),
                                    gl::Wrap::RepeatX, "environment");
    constexpr int height = builtin_width / 2;
    std::vector<float> texels;
    texels.reserve(std::size_t{4} * builtin_width * height);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < builtin_width; ++x) {
            const double latitude = ((y + 0.5) / height - 0.5) * std::numbers::pi;
            const double longitude = ((x + 0.5) / builtin_width - 0.5) * 2 * std::numbers::pi;
            const Vec3d colour = builtin_environment(
                environment, {std::cos(latitude) * std::sin(longitude), std::sin(latitude),
                              -std::cos(latitude) * std::cos(longitude)});
            for (const double c : {colour.x(), colour.y(), colour.z(), 1.0})
                texels.push_back(static_cast<float>(c));
        }
    return gl::Texture::picture(gl::Format::Rgba16f, builtin_width, height, texels,
                                gl::Wrap::RepeatX, "environment");
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
