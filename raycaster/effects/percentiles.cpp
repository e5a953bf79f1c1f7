// SPDX-License-Identifier: MPL-2.0
#include "raycaster/effects/percentiles.h"

#include <algorithm>
#include <cmath>

namespace isocast {

std::optional<double> percentile(FrameContext& frame, FrameImage image, double share,
                                 const std::function<double(const float*)>& measure) {
    const std::size_t count = std::size_t{4} * static_cast<std::size_t>(frame.width) *
                              static_cast<std::size_t>(frame.height);
    std::vector<float> hits(count);
    std::vector<float> pixels(count);
    frame.targets.texture(FrameImage::Hit).read_rgba(hits);
    frame.targets.texture(image).read_rgba(pixels);
    std::vector<double> measures;
    for (std::size_t i = 0; i < count; i += 4)
        if (hits[i + 3] != 0) measures.push_back(measure(&pixels[i]));
    if (measures.empty()) return {};
    const auto rank = std::max(0.0, std::ceil(share * double(measures.size())) - 1);
    const auto nth = measures.begin() + static_cast<std::ptrdiff_t>(rank);
    std::ranges::nth_element(measures, nth);
    return *nth;
}

} // namespace isocast
