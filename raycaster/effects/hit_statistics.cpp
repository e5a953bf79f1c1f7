// SPDX-License-Identifier: MPL-2.0
#include "raycaster/effects/hit_statistics.h"

#include <algorithm>
#include <cmath>

namespace isocast {

double extent_diagonal_world(const FrameContext& frame) {
    double longest = 0;
    for (const FrameObject& object : frame.objects) {
        const FieldSource& field = *object.object.field;
        const Index3 last = (field.extent().size().array() - 1).matrix();
        for (const int y : {-1, 1}) // of the four diagonals of a box that may be skewed
            for (const int z : {-1, 1})
                longest = std::max(longest, (field.space().world_from_index.linear() *
                                             Vec3d(last.x(), y * last.y(), z * last.z()))
                                                .norm());
    }
    return longest;
}

std::optional<double>
percentile(FrameContext& frame, FrameImage image, double share,
           const std::function<std::optional<double>(const float*)>& measure) {
    const std::size_t count = std::size_t{4} * static_cast<std::size_t>(frame.part.width) *
                              static_cast<std::size_t>(frame.part.height);
    std::vector<float> hits(count);
    std::vector<float> pixels(count);
    frame.targets.texture(FrameImage::Hit).read_rgba(hits);
    frame.targets.texture(image).read_rgba(pixels);
    std::vector<double> measures;
    for (std::size_t i = 0; i < count; i += 4)
        if (hits[i + 3] != 0)
            if (const auto value = measure(&pixels[i])) measures.push_back(*value);
    if (measures.empty()) return {};
    const auto rank = std::max(0.0, std::ceil(share * double(measures.size())) - 1);
    const auto nth = measures.begin() + static_cast<std::ptrdiff_t>(rank);
    std::ranges::nth_element(measures, nth);
    return *nth;
}

} // namespace isocast
