// SPDX-License-Identifier: MPL-2.0
#include "raycaster/effects/effects.h"

#include "volume/errors.h"

#include <fmt/format.h>

#include <cmath>

namespace isocast {

namespace {

void check_positive(std::string_view what, double value) {
    if (!(value > 0) || !std::isfinite(value))
        throw InputError(fmt::format("{} must be positive, not {}", what, value));
}

void check_volume(const SolidTexture& texture) {
    if (!texture.volume) throw InputError("solid texture: it has no volume");
    if (texture.volume_filter != "bspline" && texture.volume_filter != "linear")
        throw InputError(fmt::format("solid texture: its filter '{}' is not one of bspline, linear",
                                     texture.volume_filter));
    const int limit = gl::max_volume_extent();
    if (const Index3 size = texture.volume->extent().size(); (size.array() > limit).any())
        throw InputError(
            fmt::format("solid texture: its volume has {} x {} x {} samples: each side "
                        "has at most {}",
                        size.x(), size.y(), size.z(), limit));
}

} // namespace

void check_colour_effects(const Effects& effects) {
    const SolidTexture& texture = effects.solid_texture;
    check_positive("solid texture: its scale", texture.scale_world.value_or(1));
    check_positive("solid texture: its axis' length", texture.axis.norm());
    if (texture.kind == SolidTexture::Kind::Volume) check_volume(texture);
    if (const auto& range = effects.curvature_colour.range; range && !((*range)[0] < (*range)[1]))
        throw InputError(fmt::format("curvature colour: its range from {} to {} is empty",
                                     (*range)[0], (*range)[1]));
    check_positive("curvature map: its range", effects.curvature_map.range.value_or(1));
    check_positive("accessibility: its radius", effects.accessibility.radius_world.value_or(1));
    check_positive("refraction: its index", effects.refraction.index);
}

void set_surface_uniforms(const gl::Program& program, const FrameContext& frame) {
    frame.targets.texture(FrameImage::Hit).bind_to_unit(0);
    frame.targets.texture(FrameImage::Gradient).bind_to_unit(1);
    program.set(
        "u_ray_vector",
        Eigen::Matrix3f(
            world_vector_coefficients(frame.camera, frame.width, frame.height).cast<float>()));
}

} // namespace isocast
