// SPDX-License-Identifier: MPL-2.0
#include "apps/view/comparing.h"

#include <algorithm>
#include <cmath>

namespace isocast::view {

Comparing::Comparing(Scene scene, const Camera& seen_by, int seen_width, int seen_height,
                     std::function<void()> wake)
    : camera(seen_by), width(seen_width), height(seen_height),
      work(
          [this, scene = std::move(scene)](const Progress& progress) {
              ReferenceRenderer renderer;
              renderer.load(scene, progress);
              renderer.draw(camera, width, height, {FrameImage::Beauty},
                            {.width = width, .height = height}, progress);
              picture = renderer.read(FrameImage::Beauty);
          },
          std::move(wake)) {}

Difference difference_of(const Image& a, const Image& b) {
    Difference out{.picture = {a.width, a.height, std::vector<float>(a.rgba.size())}};
    double sum = 0;
    std::size_t count = 0;
    for (std::size_t i = 0; i < a.rgba.size(); i += 4) {
        out.picture.rgba[i + 3] = 1;
        if (a.rgba[i + 3] == 0 && b.rgba[i + 3] == 0) continue;
        for (std::size_t c = i; c < i + 3; ++c) {
            const double off = std::abs(double(a.rgba[c]) - b.rgba[c]);
            out.greatest = std::max(out.greatest, off);
            sum += off * off;
            ++count;
            out.picture.rgba[c] = static_cast<float>(off);
        }
    }
    if (out.greatest > 0) out.gain = std::exp2(std::floor(-std::log2(out.greatest)));
    for (std::size_t i = 0; i < a.rgba.size(); ++i)
        if (i % 4 != 3) out.picture.rgba[i] *= static_cast<float>(out.gain);
    out.rms = count == 0 ? 0 : std::sqrt(sum / double(count));
    return out;
}

} // namespace isocast::view
