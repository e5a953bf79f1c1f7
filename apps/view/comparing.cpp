// SPDX-License-Identifier: MPL-2.0
#include "apps/view/comparing.h"

#include "volume/errors.h"

#include <algorithm>
#include <cmath>

namespace isocast::view {

Comparing::Comparing(Scene scene, const Camera& camera, int width, int height,
                     std::function<void()> wake)
    : camera_(camera), width_(width), height_(height), wake_(std::move(wake)),
      thread_([this, scene = std::move(scene)] { run(scene); }) {}

Comparing::~Comparing() {
    is_cancelled_ = true;
    thread_.join();
}

void Comparing::run(Scene scene) {
    try {
        const Progress progress = [this](std::string_view, double fraction) {
            if (is_cancelled_) throw Interrupted();
            fraction_ = fraction;
            wake_();
        };
        ReferenceRenderer renderer;
        renderer.load(std::move(scene), progress);
        renderer.draw(camera_, width_, height_, {FrameImage::Beauty},
                      {.width = width_, .height = height_}, progress);
        picture_ = renderer.read(FrameImage::Beauty);
    } catch (...) {
        failure_ = std::current_exception();
    }
    is_done_ = true;
    wake_();
}

const Image& Comparing::picture() const {
    if (failure_) std::rethrow_exception(failure_);
    return picture_;
}

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
