// SPDX-License-Identifier: MPL-2.0
#include "raycaster/effects/hit_statistics.h"

#include "raycaster/field_passes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace isocast {

namespace {

/// The whole picture in small: the frame itself if it is that, else drawn once.
FrameContext& overview_of(FrameContext& frame) {
    const PicturePart& part = frame.part;
    const int longer = std::max(frame.width, frame.height);
    if (part.width == frame.width && part.height == frame.height && part.shift.isZero() &&
        longer <= overview_pixels)
        return frame;
    if (!frame.overview) {
        const auto small = [longer](int side) {
            const double scale = std::min(1.0, double(overview_pixels) / longer);
            return std::max(1, static_cast<int>(std::lround(scale * side)));
        };
        frame.overview = std::make_shared<OwnFrame>(frame, frame.camera, small(frame.width),
                                                    small(frame.height));
        FrameContext& overview = frame.overview->frame;
        cast_rays(overview, frame.live); // of the same programs as the frame's
        frame.scratch_bytes += overview.scratch_bytes;
        for (const gl::Texture& texture : overview.targets.textures)
            frame.scratch_bytes += texture.byte_count();
        frame.notes.push_back(fmt::format("numbers that were not given: from {} x {} pixels",
                                          overview.width, overview.height));
    }
    return frame.overview->frame;
}

std::optional<double>
percentile_of(const FrameContext& frame, FrameImage image, double share,
              const std::function<std::optional<double>(const float*)>& measure) {
    const std::size_t count = std::size_t{4} * static_cast<std::size_t>(frame.width) *
                              static_cast<std::size_t>(frame.height);
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

} // namespace

std::optional<double>
percentile(FrameContext& frame, const std::string& name, FrameImage image, double share,
           const std::function<std::optional<double>(const float*)>& measure) {
    if (const auto found = frame.look_numbers.find(name); found != frame.look_numbers.end()) {
        const FoundNumber& number = found->second;
        const bool is_same_view = number.camera == frame.camera && number.width == frame.width &&
                                  number.height == frame.height;
        if (number.value || is_same_view) return number.value;
    }
    const auto value = percentile_of(overview_of(frame), image, share, measure);
    frame.look_numbers.insert_or_assign(
        name, FoundNumber{value, frame.camera, frame.width, frame.height});
    return value;
}

} // namespace isocast
