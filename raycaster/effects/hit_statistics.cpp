// SPDX-License-Identifier: MPL-2.0
#include "raycaster/effects/hit_statistics.h"

#include <algorithm>

namespace isocast {

double extent_diagonal_world(const FieldSource& field) {
    const Index3 last = (field.extent().size().array() - 1).matrix();
    double longest = 0; // of the four diagonals of a box that may be skewed
    for (const int y : {-1, 1})
        for (const int z : {-1, 1})
            longest = std::max(longest, (field.space().world_from_index.linear() *
                                         Vec3d(last.x(), y * last.y(), z * last.z()))
                                            .norm());
    return longest;
}

std::optional<std::array<double, 2>>
curvature_percentiles(FrameContext& frame, double low, double high,
                      const std::function<std::optional<double>(double, double)>& measure) {
    const gl::Texture& curvatures = frame.targets.texture(FrameImage::Curvature);
    std::vector<float> texels(4 * static_cast<std::size_t>(frame.width) *
                              static_cast<std::size_t>(frame.height));
    curvatures.read_rgba(texels);
    std::vector<double> values;
    for (std::size_t i = 0; i < texels.size(); i += 4) {
        if (texels[i + 3] == 0 || texels[i + 3] == 2) continue; // no hit, no gradient
        if (const auto value = measure(texels[i], texels[i + 1])) values.push_back(*value);
    }
    if (values.empty()) return std::nullopt;
    const auto percentile = [&](double share) {
        const auto at = values.begin() +
                        static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
        std::ranges::nth_element(values, at);
        return *at;
    };
    return std::array{percentile(low), percentile(high)};
}

} // namespace isocast
