// What the sections of bench_raycast share.
// SPDX-License-Identifier: MPL-2.0
#pragma once

#include "raycaster/renderer.h"
#include "volume/analytic_fields.h"

#include <filesystem>
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
double frame_seconds(Renderer& renderer, const Camera& camera, int size, FrameReport& report,
                     const ImageSet& wanted = {FrameImage::Beauty});

/// Parts of the memory that a field takes, by coarser bricks and by streaming; prints a table.
void run_coarse(Renderer& renderer, const std::shared_ptr<const FieldSource>& field,
                const Camera& camera, int size, int repeats);

/// From the scene's iso value by `small` and by `large` and back: a fresh load, set_iso, and the
/// query for the active blocks alone, by all ranges and by the ends that are passed; prints a
/// table.
void run_moving_iso(Renderer& renderer, const std::string& name, const Scene& scene, double small,
                    double large, int repeats);

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

/// A field of the thesis's table 6.1.
struct TableField {
    std::string name;
    std::shared_ptr<const FieldSource> field;
    Camera camera;
};

/// Frames a second of several fields, by grid size; prints a table.
void run_table_6_1(Renderer& renderer, const std::vector<TableField>& fields, int size,
                   int repeats);

/// Frames a second of samples at rates, by traversal and bricks; prints a table.
void run_table_6_2(Renderer& renderer, const std::shared_ptr<const FieldSource>& field,
                   const Camera& camera, int size, int repeats);

/// What samples miss at the silhouette of a sphere, against the bound of figure 6.7; prints a
/// table.
void run_silhouettes(Renderer& renderer);

/// Figures 6.3 (blocks blue, bricks of 32 cells green) and 6.8 (a detail at rate 0.5, at 0.5 and 4
/// near the surface, and certified) as PNGs in a folder.
void write_figures(Renderer& renderer, const std::shared_ptr<const FieldSource>& field,
                   const Camera& camera, const std::filesystem::path& folder);

} // namespace isocast
