// SPDX-License-Identifier: MPL-2.0
#include "raycaster/reference_shading.h"

#include "raycaster/effects/colour_maps.h"
#include "raycaster/effects/curvature_measure.h"
#include "raycaster/shading.h"

#include <algorithm>
#include <cmath>

namespace isocast {

namespace {

Vec3d mixed(const Vec3d& a, const Vec3d& b, double share_of_b) {
    return (1 - share_of_b) * a + share_of_b * b;
}

/// GLSL's.
double smoothstep(double lo, double hi, double x) {
    const double t = std::clamp((x - lo) / (hi - lo), 0.0, 1.0);
    return t * t * (3 - 2 * t);
}

std::optional<std::array<double, 2>> range_of(const CurvatureColour& colour) {
    if (!colour.range && colour.measure == CurvatureMeasure::ShapeIndex) return {{-1, 1}};
    return colour.range;
}

} // namespace

bool uses_curvature(const Look& look) {
    const Effects& effects = look.effects;
    return effects.curvature_colour.strength > 0 || effects.ridges.strength > 0 ||
           effects.accessibility.strength > 0 || effects.contours.strength > 0;
}

std::vector<std::string> not_in_reference(const Look& look) {
    const Effects& effects = look.effects;
    std::vector<std::string> out;
    for (const Layer& layer : layers_of(look)) {
        if (layer.strength == 0) continue;
        switch (layer.image) {
        case FrameImage::Contours:
            break;
        case FrameImage::CurvatureColour:
            if (!range_of(effects.curvature_colour))
                out.emplace_back("curvature colours without a range");
            break;
        case FrameImage::Ridges:
            if (!effects.ridges.threshold) out.emplace_back("ridges without a threshold");
            break;
        case FrameImage::Accessibility:
            if (!effects.accessibility.radius_world)
                out.emplace_back("accessibility without a radius");
            break;
        default:
            out.emplace_back(name_of(layer.image));
        }
    }
    if (look.shows_environment) out.emplace_back("the environment as the background");
    return out;
}

ReferenceShading::ReferenceShading(const Look& look, const Camera& camera, int height)
    : look_(look), camera_(camera), height_(height) {
    for (const Light& light : look.lights) to_lights_.push_back(direction_world(light, camera));
}

Eigen::Vector4d ReferenceShading::colour(const ReferenceSurface* surface,
                                         const Vec3d& direction) const {
    Eigen::Vector4d out;
    if (!surface) {
        out << look_.background, 0;
        return out;
    }
    Vec3d colour = with_surface_layers(surface->colour, *surface);
    if (look_.model != ShadingModel::Flat) {
        const Vec3d to_viewer = -direction.normalized();
        const double length = surface->gradient.norm();
        const Vec3d normal = length > 0 ? Vec3d(surface->gradient / length) : to_viewer;
        colour = lit(colour, normal.dot(to_viewer) < 0 ? Vec3d(-normal) : normal, to_viewer);
    }
    const Contours& contours = look_.effects.contours;
    if (contours.strength > 0)
        colour = mixed(colour, contours.colour,
                       contours.strength * contour_coverage(*surface, direction));
    out << colour, 1;
    return out;
}

/// twin  shaders/shading/blinn_phong/, gooch/
Vec3d ReferenceShading::lit(const Vec3d& colour, const Vec3d& normal,
                            const Vec3d& to_viewer) const {
    const Material& material = look_.material;
    Vec3d sum = Vec3d::Zero();
    for (std::size_t i = 0; i < to_lights_.size(); ++i) {
        const double lambert = normal.dot(to_lights_[i]);
        const Vec3d half_way = (to_lights_[i] + to_viewer).normalized();
        const double highlight = std::pow(std::max(normal.dot(half_way), 0.0), material.shininess);
        Vec3d light;
        if (look_.model == ShadingModel::Gooch) {
            const GoochTones& tones = look_.tones;
            light = mixed(tones.cool + tones.cool_share * colour,
                          tones.warm + tones.warm_share * colour, 0.5 + 0.5 * lambert) +
                    Vec3d::Constant(material.specular * highlight);
        } else {
            light = colour * (material.ambient + material.diffuse * std::max(lambert, 0.0)) +
                    Vec3d::Constant(lambert > 0 ? material.specular * highlight : 0.0);
        }
        sum += light.cwiseProduct(look_.lights[i].colour);
    }
    return sum;
}

/// In the order of layers_of().
/// twin  shaders/shading/curvature_colour/, ridges/, accessibility/
Vec3d ReferenceShading::with_surface_layers(Vec3d colour, const ReferenceSurface& surface) const {
    const auto& [k1, k2, direction1, direction2] = surface.curvature;
    const Effects& effects = look_.effects;
    if (const CurvatureColour& by = effects.curvature_colour;
        by.strength > 0 && surface.gradient.norm() > 0) {
        const auto [low, high] = *range_of(by);
        const ColourMap map = by.map.value_or(default_colour_map(by.measure));
        const double t =
            std::clamp((curvature_measure(by.measure, k1, k2) - low) / (high - low), 0.0, 1.0);
        colour = mixed(colour, colour_of(map, t), by.strength);
    }
    if (const Ridges& ridges = effects.ridges; ridges.strength > 0) {
        const double ridge = k1 - std::abs(k2);
        const double valley = -k2 - std::abs(k1);
        const double coverage =
            smoothstep(0.75 * *ridges.threshold, 1.25 * *ridges.threshold, std::max(ridge, valley));
        colour = mixed(colour, ridge > valley ? ridges.ridge_colour : ridges.valley_colour,
                       ridges.strength * coverage);
    }
    if (const Accessibility& accessibility = effects.accessibility; accessibility.strength > 0)
        colour *=
            1 - accessibility.strength * std::clamp(-k2 * *accessibility.radius_world, 0.0, 1.0);
    return colour;
}

/// twin  shaders/shading/contours/contours.frag, which derives it
double ReferenceShading::contour_coverage(const ReferenceSurface& surface,
                                          const Vec3d& direction) const {
    const double length = surface.gradient.norm();
    if (!(length > 0)) return 0;
    const Vec3d v = -direction.normalized();
    const double side = surface.gradient.dot(v) < 0 ? -1 : 1;
    const Vec3d n = side * surface.gradient / length;
    const double k = std::max(side * surface.view_curvature, 0.0);
    const double c = n.dot(v);
    const Vec3d outwards = n - c * v;
    const double s = outwards.norm();
    const bool is_perspective = camera_.projection == Projection::Perspective;
    const double nearness = is_perspective ? 1 / surface.from_eye.norm() : 0;
    const double w =
        c * c / std::max(k + c * nearness + s * std::sqrt(k * (k + 2 * c * nearness)), 1e-30);
    const Vec3d forward = -camera_.view_from_world_rotation().row(2).transpose();
    const Vec3d projected = outwards - direction * (outwards.dot(forward) / direction.dot(forward));
    double pixels_per_world = height_ / (2 * camera_.half_height_at(1));
    if (s > 0) pixels_per_world *= projected.norm() / s;
    if (is_perspective) pixels_per_world /= surface.from_eye.dot(forward);
    const double thickness = std::min(look_.effects.contours.thickness_pixels,
                                      0.25 * pixels_per_world / std::max(k, 1e-30));
    return std::clamp(thickness - w * pixels_per_world + 0.5, 0.0, 1.0);
}

} // namespace isocast
