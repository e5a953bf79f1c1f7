// A canvas over a slice of samples, and how distances look on it.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "raycaster/image_files.h"
#include "volume/grid_space.h"

#include <cmath>

namespace isocast {

using Colour = Eigen::Vector3f; // sRGB

/// A canvas over the samples `box`, which is one sample thick in z, with y upwards.
class SliceCanvas {
public:
    explicit SliceCanvas(const IndexBox& box)
        : box_(box), image_{.width = box.size().x(), .height = box.size().y(), .rgba = {}} {
        image_.rgba.assign(4 * static_cast<std::size_t>(box.sample_count()), 1.0f);
    }
    const IndexBox& box() const { return box_; }
    void set(const Index3& sample, const Colour& colour) {
        const int row = box_.hi.y() - 1 - sample.y();
        const auto pixel = static_cast<std::size_t>(row * image_.width + sample.x() - box_.lo.x());
        for (int k = 0; k < 3; ++k) // write_png wants linear light
            image_.rgba[4 * pixel + k] = std::pow((colour[k] + 0.055f) / 1.055f, 2.4f);
    }
    const Image& image() const { return image_; }

private:
    IndexBox box_;
    Image image_;
};

/// Left and right with a white gap between.
inline Image beside(const Image& left, const Image& right) {
    constexpr int gap = 16;
    Image both{.width = left.width + gap + right.width, .height = left.height, .rgba = {}};
    for (int y = 0; y < both.height; ++y) {
        const float* l = left.pixel(0, y);
        const float* r = right.pixel(0, y);
        both.rgba.insert(both.rgba.end(), l, l + 4 * left.width);
        both.rgba.insert(both.rgba.end(), 4 * gap, 1.0f);
        both.rgba.insert(both.rgba.end(), r, r + 4 * right.width);
    }
    return both;
}

/// The upper above the lower, with a white gap between.
inline Image above(const Image& upper, const Image& lower) {
    constexpr int gap = 16;
    Image both{
        .width = upper.width, .height = upper.height + gap + lower.height, .rgba = upper.rgba};
    both.rgba.insert(both.rgba.end(), 4 * static_cast<std::size_t>(gap * upper.width), 1.0f);
    both.rgba.insert(both.rgba.end(), lower.rgba.begin(), lower.rgba.end());
    return both;
}

/// Blue inside, orange outside, in stripes of equal distance that fade away from the surface.
inline Colour distance_colour(double voxels) {
    constexpr double stripe = 5; // voxels
    const double distance = std::abs(voxels);
    if (distance < 0.8) return Colour::Zero();
    const Colour hue = voxels < 0 ? Colour(0.10f, 0.38f, 0.75f) : Colour(0.95f, 0.50f, 0.10f);
    const auto fade = static_cast<float>(std::exp(-distance / 60));
    const float shade = static_cast<int>(distance / stripe) % 2 == 0 ? 1.0f : 0.84f;
    return shade * (fade * hue + (1 - fade) * (0.25f * hue + Colour::Constant(0.75f)));
}

} // namespace isocast
