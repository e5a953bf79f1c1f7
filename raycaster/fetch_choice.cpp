// SPDX-License-Identifier: MPL-2.0
#include "raycaster/fetch_choice.h"

#include "volume/analytic_fields.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

namespace isocast {

bool is_software_rasteriser(std::string_view gl_renderer) {
    return gl_renderer.find("llvmpipe") != gl_renderer.npos ||
           gl_renderer.find("softpipe") != gl_renderer.npos;
}

FetchChoice fastest_fetch(std::span<const FetchTime> times) {
    const FetchTime& best = *std::ranges::min_element(times, {}, &FetchTime::milliseconds);
    std::string measured;
    for (const FetchTime& time : times)
        measured += fmt::format("{}{} {:.3f} ms", measured.empty() ? "" : ", ",
                                fetch_name(time.fetch), time.milliseconds);
    return {best.fetch, fmt::format("the fastest of a probe: {}", measured)};
}

std::vector<FetchTime> time_fetches(Renderer& renderer, Filter filter,
                                    const StorageOptions& storage, int size) {
    const std::shared_ptr<const FieldSource> torus = sampled(builtin_field("torus"), 64);
    std::vector<FetchTime> times;
    for (const Fetch fetch : {Fetch::Rows, Fetch::Samples, Fetch::Linear}) {
        // Renderer::load refuses these.
        if (fetch == Fetch::Linear &&
            (kernel_of(filter) == Kernel::CatmullRom || storage.brick_size == no_bricks ||
             storage.over_budget == OverBudget::Coarsen))
            continue;
        renderer.load({.field = torus,
                       .filter = filter,
                       .storage = {.fetch = fetch,
                                   .format = storage.format,
                                   .brick_size = storage.brick_size}});
        const Camera camera = frame_box(renderer.surface_box_world(), {0.45, 0.35, 1}, 1, 30);
        double least = std::numeric_limits<double>::infinity();
        for (int turn = -1; turn < 5; ++turn) {
            double sum = 0;
            for (const PassReport& pass :
                 renderer.draw(camera, size, size, {FrameImage::Gradient}).passes)
                sum += pass.milliseconds;
            if (turn >= 0) least = std::min(least, sum);
        }
        times.push_back({fetch, least});
    }
    return times;
}

Filter hardest_filter(const Scene& scene) {
    return std::ranges::max_element(scene.objects, {},
                                    [](const FieldObject& object) {
                                        return kernel_of(object.filter) == Kernel::CatmullRom;
                                    })
        ->filter;
}

FetchChoice choose_fetch(Renderer& renderer, const gl::DriverInfo& driver, Filter filter,
                         const StorageOptions& storage) {
    if (is_software_rasteriser(driver.renderer))
        return {Fetch::Rows, "not measured: the fastest on software rasterisers"};
    return fastest_fetch(time_fetches(renderer, filter, storage));
}

} // namespace isocast
