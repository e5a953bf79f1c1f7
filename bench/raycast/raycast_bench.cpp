// What the sections of bench_raycast share.
// SPDX-License-Identifier: MPL-2.0
#include "raycast/raycast_bench.h"

#include "peers/peer_frame.h"

#include <glad/gl.h>

#include <algorithm>

namespace isocast {

Timing timing_of(std::vector<double> seconds) {
    const double least = std::ranges::min(seconds);
    return {median(std::move(seconds)), least};
}

double frame_seconds(Renderer& renderer, const Camera& camera, int size, FrameReport& report,
                     const ImageSet& wanted) {
    const auto start = std::chrono::steady_clock::now();
    report = renderer.draw(camera, size, size, wanted);
    glFinish();
    return seconds_since(start);
}

std::vector<DrawResult> draw_in_turns(Renderer& renderer, const std::vector<DrawCase>& cases,
                                      const Camera& camera, int size, int repeats) {
    struct Taken {
        std::vector<double> frame, load;
        FrameReport report;
    };
    std::vector<Taken> taken(cases.size());
    for (int turn = 0; turn < repeats; ++turn) {
        for (std::size_t i = 0; i < cases.size(); ++i) {
            const auto start = std::chrono::steady_clock::now();
            renderer.load(cases[i].scene);
            glFinish();
            taken[i].load.push_back(seconds_since(start));
            frame_seconds(renderer, camera, size, taken[i].report);
            taken[i].frame.push_back(frame_seconds(renderer, camera, size, taken[i].report));
        }
    }
    std::vector<DrawResult> results;
    for (Taken& t : taken)
        results.push_back(
            {timing_of(std::move(t.frame)), timing_of(std::move(t.load)), std::move(t.report)});
    return results;
}

} // namespace isocast
