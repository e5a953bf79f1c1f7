// What the sections of bench_raycast share.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "raycaster/renderer.h"

#include <functional>
#include <string>
#include <vector>

namespace isocast {

/// Seconds of repeated runs.
struct Timing {
    double median;
    double least;
};
Timing timing_of(std::vector<double> seconds);

/// A way to draw a field.
struct DrawCase {
    std::string name;
    Scene scene;
};

struct DrawResult {
    Timing frame; // list of tiles, hit, normal, shading, until the GL has finished
    Timing load;  // active blocks, bricks, upload
    FrameReport report;
};

/// The cases in turn, `repeats` times, so that a machine's drift is in all of them; each is loaded,
/// drawn once to warm up and once timed.
std::vector<DrawResult> draw_in_turns(Renderer& renderer, const std::vector<DrawCase>& cases,
                                      const Camera& camera, int size, int repeats);

/// Seconds of one frame of the loaded scene.
double frame_seconds(Renderer& renderer, const Camera& camera, int size, FrameReport& report);

/// Parts of the memory that a field takes, by coarser bricks and by streaming; prints a table.
void run_coarse(Renderer& renderer, const std::shared_ptr<const FieldSource>& field,
                const Camera& camera, int size, int repeats);

/// Every filter and storage on the exact distances of a torus; prints a table.
void run_accuracy(Renderer& renderer);

/// Samples a second of tricubic and trilinear filters; prints a table.
void run_filter_rate(int repeats);

} // namespace isocast
