// Which way to fetch samples is the fastest on this GL: a short measurement.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "raycaster/renderer.h"

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace isocast {

/// What a frame of the probe took.
struct FetchTime {
    Fetch fetch;
    double milliseconds;
};

struct FetchChoice {
    Fetch fetch = Fetch::Rows;
    std::string reason; // for people
};

/// By GL_RENDERER: Mesa's llvmpipe and softpipe.
bool is_software_rasteriser(std::string_view gl_renderer);

/// The least time; of equal ones the first. Not of no times.
FetchChoice fastest_fetch(std::span<const FetchTime> times);

/// Draws hits and gradients of a torus of 64^3 by each fetch that the filter allows, once to
/// compile and warm up; the least of five frames. What was loaded is gone afterwards; the programs
/// stay, and the one chosen needs no other if all bricks of the field fit.
///
/// size  of the pictures along each side: enough to fill a GPU
std::vector<FetchTime> time_fetches(Renderer& renderer, Filter filter,
                                    const StorageOptions& storage, int size = 512);

/// That of a scene's objects which asks most of fetches: where one needs Catmull-Rom's, they must
/// serve that. The scene has objects.
Filter hardest_filter(const Scene& scene);

/// The fastest. On software rasterisers rows without a measurement: compiling the probes would take
/// longer than a frame, and rows are the fastest there (docs/raycasting.md).
FetchChoice choose_fetch(Renderer& renderer, const gl::DriverInfo& driver, Filter filter,
                         const StorageOptions& storage);

} // namespace isocast
