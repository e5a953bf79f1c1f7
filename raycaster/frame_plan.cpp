// SPDX-License-Identifier: MPL-2.0
#include "raycaster/frame_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <stdexcept>

namespace isocast {

std::string_view name_of(FrameImage image) {
    constexpr std::array<std::string_view, frame_image_count> names{"bounds",
                                                                    "splat",
                                                                    "splat surface",
                                                                    "slim nearest",
                                                                    "slim hit",
                                                                    "hit",
                                                                    "steps",
                                                                    "gradient",
                                                                    "curvature",
                                                                    "view curvature",
                                                                    "flow line curvature",
                                                                    "direction",
                                                                    "shadow map",
                                                                    "flow noise",
                                                                    "outline source",
                                                                    "splat colour",
                                                                    "solid texture",
                                                                    "curvature colour",
                                                                    "curvature map",
                                                                    "uncertainty",
                                                                    "flow",
                                                                    "accessibility",
                                                                    "occlusion",
                                                                    "shadow",
                                                                    "refraction",
                                                                    "reflection",
                                                                    "ridges",
                                                                    "contours",
                                                                    "outlines",
                                                                    "slice",
                                                                    "beauty"};
    return names.at(static_cast<std::size_t>(image));
}

std::vector<Pass> live_passes(const std::vector<Pass>& declared, const ImageSet& wanted) {
    ImageSet needed = wanted;
    std::vector<Pass> live;
    for (auto pass = declared.rbegin(); pass != declared.rend(); ++pass) {
        if (!needed.contains(pass->writes)) continue;
        needed.insert(pass->reads);
        live.push_back(*pass);
    }
    std::ranges::reverse(live);

    ImageSet written;
    const auto require = [&](const ImageSet& images, std::string_view reader) {
        for (int i = 0; i < frame_image_count; ++i) {
            const auto image = static_cast<FrameImage>(i);
            if (images.contains(image) && !written.contains(image))
                throw std::logic_error(fmt::format("{} reads '{}', which no pass before it writes",
                                                   reader, name_of(image)));
        }
    };
    for (const Pass& pass : live) {
        require(pass.reads, fmt::format("pass '{}'", pass.name));
        written.insert(pass.writes);
    }
    require(wanted, "the output");
    return live;
}

std::string asked_by(const Pass& pass, const std::vector<Pass>& live, const ImageSet& wanted) {
    std::string readers = wanted.contains(pass.writes) ? "output" : "";
    for (const Pass& other : live)
        if (other.reads.contains(pass.writes))
            readers += fmt::format("{}{}", readers.empty() ? "" : ", ", other.name);
    return readers;
}

} // namespace isocast
