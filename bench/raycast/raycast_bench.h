// What the sections of bench_raycast share.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "raycaster/renderer.h"
#include "volume/analytic_fields.h"

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

/// The torus of the accuracy sections: off the lattice, tilted; voxels of size 1.
inline constexpr int study_resolution = 64;
inline constexpr int study_size = 512; // pixels
AnalyticField study_torus();
Camera study_camera();
/// Its exact distances, rounded once.
std::shared_ptr<const FieldSource> study_distances(double half_width);
double degrees_between(const Vec3d& a, const Vec3d& b);

/// Every filter and storage on the exact distances of a torus; prints a table.
void run_accuracy(Renderer& renderer);

/// Time and error of each way to fetch, the GL's filter with fractions of 8 bits included; prints a
/// table.
void run_fetches(Renderer& renderer, int repeats);

/// Samples a second of tricubic and trilinear filters; prints a table.
void run_filter_rate(int repeats);

} // namespace isocast
